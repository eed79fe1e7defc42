//! The place of a process in a file.

use std::fs::File;
use std::io::{self, BufWriter, IntoInnerError, Seek, SeekFrom, Write};

/// A file of which a process writes ranges of bytes in ascending order. In a stream, the ranges follow each other without gaps.
pub(super) struct Place<'a> {
    out: Out<'a>,
    /// Whether this process also writes the bytes outside of the shares: header, lengths and end.
    pub is_first: bool,
}

enum Out<'a> {
    Stream(&'a mut dyn Write),
    File(BufWriter<File>),
}

impl<'a> Place<'a> {
    /// Returns the place of a process that writes the whole file.
    pub fn stream(out: &'a mut dyn Write) -> Self {
        Place { out: Out::Stream(out), is_first: true }
    }

    /// Returns the place of one of several processes that write a file.
    pub fn shared(file: File, is_first: bool) -> Self {
        Place { out: Out::File(BufWriter::with_capacity(1 << 18, file)), is_first }
    }

    /// Sets the length of the file. A stream gets its length from what is written.
    pub fn set_len(&mut self, length: usize) -> io::Result<()> {
        if let Out::File(file) = &self.out { file.get_ref().set_len(length as u64) } else { Ok(()) }
    }

    /// Moves to a position in the file. A stream is there already.
    pub fn go_to(&mut self, position: usize) -> io::Result<()> {
        if let Out::File(file) = &mut self.out {
            file.seek(SeekFrom::Start(position as u64))?;
        }
        Ok(())
    }

    /// Writes the remaining bytes to the file, and returns it. A stream has no file.
    pub fn into_file(self) -> io::Result<Option<File>> {
        match self.out {
            Out::Stream(_) => Ok(None),
            Out::File(file) => file.into_inner().map(Some).map_err(IntoInnerError::into_error),
        }
    }
}

impl Write for Place<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.out {
            Out::Stream(out) => out.write(bytes),
            Out::File(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.out {
            Out::Stream(out) => out.flush(),
            Out::File(file) => file.flush(),
        }
    }
}
