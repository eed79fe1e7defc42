//! Reads a range of a file in chunks of whole rows.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use super::super::error::InputError;
use super::super::load;
use super::error::SharedError;

/// Where a chunk can end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// At the end of any line.
    Lines,
    /// After a multiple of this number of bytes.
    Bytes(u64),
}

impl Unit {
    /// Returns the number of leading bytes that are whole units. More bytes follow.
    pub fn whole(self, data: &[u8]) -> usize {
        match self {
            Unit::Bytes(size) => data.len() - data.len() % (size as usize).max(1),
            Unit::Lines if data.last() == Some(&b'\n') => data.len(),
            // The byte after a carriage return at the end may be a line feed.
            Unit::Lines => (1..data.len()).rev().find(|&at| begins_line(data, at)).unwrap_or(0),
        }
    }
}

/// Returns `true` if a line begins at a position after the first. The byte at the position must be known, or must not
/// exist.
fn begins_line(data: &[u8], at: usize) -> bool {
    match data[at - 1] {
        b'\n' => true,
        b'\r' => data.get(at) != Some(&b'\n'),
        _ => false,
    }
}

/// A function that receives the chunks of a file, each with its offset.
pub(super) type EachChunk<'a> = dyn FnMut(u64, &[u8]) -> Result<(), SharedError> + 'a;

/// A file that is open.
pub(super) struct OpenFile<'a> {
    path: &'a Path,
    file: File,
    /// The number of bytes to read at a time.
    step: usize,
}

impl<'a> OpenFile<'a> {
    /// Opens a file.
    pub fn of(path: &'a Path, step: usize) -> Result<Self, InputError> {
        Ok(OpenFile { path, file: load::open(path)?.0, step: step.max(1) })
    }

    /// Appends the bytes of a range to `data`.
    pub fn read(&mut self, range: Range<u64>, data: &mut Vec<u8>) -> Result<(), SharedError> {
        let length = range.end.saturating_sub(range.start);
        load::reserve(data, length, self.path)?;
        let unreadable = |error| load::unreadable(self.path, error);
        self.file.seek(SeekFrom::Start(range.start)).map_err(unreadable)?;
        let got = (&self.file).take(length).read_to_end(data).map_err(unreadable)?;
        if got as u64 == length { Ok(()) } else { Err(SharedError::Changed { path: self.path.to_owned() }) }
    }

    /// Calls `each` for chunks of whole units, with the offset of each chunk. The range contains whole units.
    pub fn chunks(
        &mut self,
        range: Range<u64>,
        unit: Unit,
        each: &mut EachChunk<'_>,
    ) -> Result<(), SharedError> {
        let (mut data, mut read, mut step) = (Vec::new(), range.start, self.step as u64);
        while read < range.end {
            let begin = read - data.len() as u64;
            let end = range.end.min(read + step);
            self.read(read..end, &mut data)?;
            read = end;
            let whole = if read == range.end { data.len() } else { unit.whole(&data) };
            // A line that is longer than a step doubles the step, so that its bytes are searched a few times only.
            step = if whole == 0 { 2 * step } else { self.step as u64 };
            if whole > 0 {
                each(begin, &data[..whole])?;
                data.drain(..whole);
            }
        }
        Ok(())
    }

    /// Returns the first position in a range that is the beginning of a line, or the end of the range. A line begins at
    /// offset `first`, and at no offset before it.
    pub fn line_from(&mut self, range: Range<u64>, first: u64) -> Result<u64, SharedError> {
        if range.start <= first {
            return Ok(first);
        }
        let mut data = Vec::new();
        let mut at = range.start - 1;
        while at < range.end {
            let end = range.end.min(at + (self.step as u64).max(2));
            data.clear();
            self.read(at..end, &mut data)?;
            // At the end of the file, no byte is missing.
            let known = if end == range.end { data.len() } else { data.len() - 1 };
            if let Some(found) = (1..=known).find(|&i| begins_line(&data, i)) {
                return Ok(at + found as u64);
            }
            if end == range.end {
                break;
            }
            at = end - 1;
        }
        Ok(range.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_end_where_lines_end() {
        let whole = |text: &str| Unit::Lines.whole(text.as_bytes());
        assert_eq!(
            ["", "a", "a\n", "a\nb", "a\r", "a\r\n", "a\rb", "\n\r"].map(whole),
            [0, 0, 2, 2, 0, 3, 2, 1]
        );
        assert_eq!(Unit::Bytes(4).whole(b"123456789"), 8);
    }

    #[test]
    fn lines_are_found_from_every_position() {
        let text = b"one\r\ntwo\rthree\n\n\r\rsix";
        let starts = [0, 5, 9, 15, 16, 17, 18, 21];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        std::fs::write(&path, text).unwrap();
        for step in 1..6 {
            let mut file = OpenFile::of(&path, step).unwrap();
            for from in 0..=text.len() as u64 {
                let expected = starts.iter().copied().find(|&start| start >= from).unwrap();
                let found = file.line_from(from..text.len() as u64, 0).unwrap();
                assert_eq!(found, expected, "from {from} in steps of {step}");
            }
            let mut all = Vec::new();
            let each = &mut |at: u64, data: &[u8]| {
                assert!(starts.contains(&at) && at == all.len() as u64, "{at}");
                all.extend_from_slice(data);
                Ok(())
            };
            file.chunks(0..text.len() as u64, Unit::Lines, each).unwrap();
            assert_eq!(all, text);
        }
    }
}
