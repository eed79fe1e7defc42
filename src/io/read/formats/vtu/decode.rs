//! Decodes the numbers of an array from text, raw bytes, base64 and zlib.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::arrays::{Arrays, DataArray, Storage};
use super::base64;
use crate::read::error::{InputError, Place};
use crate::read::scalar::{Endian, Scalar};
use crate::read::text::{excerpt, expected};

impl<'a> Arrays<'a> {
    /// Returns all numbers of an array.
    pub fn values<T>(
        &self,
        array: &DataArray<'a>,
        from_bytes: impl Fn(Scalar, &[u8], Endian) -> T,
        from_word: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<Vec<T>, InputError> {
        let source = self.source;
        if array.storage == Storage::Ascii {
            let words = array.text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
            let value = |word: &[u8]| {
                let offset = (word.as_ptr() as usize).wrapping_sub(source.data.as_ptr() as usize);
                from_word(word).ok_or_else(|| source.bad_at(offset, excerpt(word), expected(word)))
            };
            return words.map(value).collect();
        }
        let (bytes, offset) = self.bytes(array)?;
        let numbers = bytes.chunks_exact(array.scalar.size());
        if !numbers.remainder().is_empty() {
            return Err(source.malformed(
                offset,
                format!("{} bytes", bytes.len()),
                "a whole number of array elements",
            ));
        }
        Ok(numbers.map(|b| from_bytes(array.scalar, b, self.endian)).collect())
    }

    /// Returns the location of a number in an array. It is a line in a text array and a byte in a raw array.
    /// Otherwise, it is the line of the opening tag of the array.
    pub fn locate(&self, array: &DataArray<'a>, element: usize) -> Place {
        let word = |text: &'a [u8]| {
            let mut words = text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
            words.nth(element)
        };
        match (array.storage, &self.appended) {
            (Storage::Ascii, _) => word(array.text).map_or(array.place(), |word| {
                let data = self.source.data.as_ptr() as usize;
                let offset = (word.as_ptr() as usize).wrapping_sub(data);
                Place::Line(self.source.line_at(offset))
            }),
            (Storage::Appended(at), Some(appended)) if appended.raw && !self.zlib => {
                let header = if self.wide_header { 8 } else { 4 };
                let within = header + element * array.scalar.size();
                Place::Byte(at.saturating_add((appended.offset + within) as u64))
            }
            _ => array.place(),
        }
    }

    /// Returns the bytes of an array without their counts, and the offset of its data in the file.
    fn bytes(&self, array: &DataArray<'a>) -> Result<(Cow<'a, [u8]>, usize), InputError> {
        let source = self.source;
        let text = |text: &[u8], offset: usize| {
            base64::decode(text)
                .ok_or_else(|| source.malformed(offset, "damaged base64", "base64 in groups of four"))
        };
        let (stored, offset): (Cow<'a, [u8]>, usize) = match array.storage {
            Storage::Ascii | Storage::Base64 => (text(array.text, array.offset)?.into(), array.offset),
            Storage::Appended(at) => {
                let missing = || source.truncated(array.place(), "sections of appended data", 1, 0);
                let appended = self.appended.as_ref().ok_or_else(missing)?;
                let length = appended.data.len() as u64;
                let rest = usize::try_from(at).ok().and_then(|at| appended.data.get(at..));
                let place = array.place();
                let rest =
                    rest.ok_or_else(|| source.truncated(place, "bytes of appended data", at, length))?;
                let offset = appended.offset + at as usize;
                if appended.raw { (rest.into(), offset) } else { (text(rest, offset)?.into(), offset) }
            }
        };
        let taken =
            if self.zlib { self.inflate(&stored, offset)?.into() } else { self.plain(stored, offset)? };
        Ok((taken, offset))
    }

    /// Reads a count. Returns the count and the bytes after it.
    fn count<'s>(&self, stored: &'s [u8], offset: usize) -> Result<(u64, &'s [u8]), InputError> {
        let scalar = if self.wide_header { Scalar::U64 } else { Scalar::U32 };
        let short = || self.short(offset, scalar.size() as u64, stored.len() as u64);
        let (head, rest) = stored.split_at_checked(scalar.size()).ok_or_else(short)?;
        Ok((u64::try_from(scalar.integer(head, self.endian)).unwrap_or(u64::MAX), rest))
    }

    fn short(&self, offset: usize, expected: u64, found: u64) -> InputError {
        self.source.truncated(Place::Byte(offset as u64), "bytes of an array", expected, found)
    }

    fn plain(&self, stored: Cow<'a, [u8]>, offset: usize) -> Result<Cow<'a, [u8]>, InputError> {
        let (length, rest) = self.count(&stored, offset)?;
        let found = rest.len() as u64;
        if length > found {
            return Err(self.short(offset, length, found));
        }
        let start = stored.len() - rest.len();
        let range = start..start + length as usize;
        Ok(match stored {
            Cow::Borrowed(stored) => Cow::Borrowed(&stored[range]),
            Cow::Owned(stored) => Cow::Owned(stored[range].to_vec()),
        })
    }

    /// Decompresses blocks. The table before them gives their compressed lengths.
    fn inflate(&self, stored: &[u8], offset: usize) -> Result<Vec<u8>, InputError> {
        let (blocks, rest) = self.count(stored, offset)?;
        let (block_size, rest) = self.count(rest, offset)?;
        let (_last, mut table) = self.count(rest, offset)?;
        let entry = if self.wide_header { 8 } else { 4 };
        let start =
            usize::try_from(blocks).ok().and_then(|n| n.checked_mul(entry)).filter(|n| *n <= table.len());
        let start = start.ok_or_else(|| self.short(offset, blocks, (table.len() / entry) as u64))?;
        let mut data = &table[start..];
        let mut bytes = Vec::new();
        for _ in 0..blocks {
            let length;
            (length, table) = self.count(table, offset)?;
            let short = || self.short(offset, length, data.len() as u64);
            let split = usize::try_from(length).ok().and_then(|n| data.split_at_checked(n));
            let (block, rest) = split.ok_or_else(short)?;
            data = rest;
            let damaged = |_| self.source.malformed(offset, "damaged zlib data", "a zlib block");
            ZlibDecoder::new(block).take(block_size).read_to_end(&mut bytes).map_err(damaged)?;
        }
        Ok(bytes)
    }
}
