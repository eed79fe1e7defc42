//! Reads all bytes of a file or of standard input, decompresses gzip, decodes UTF-16, and reports progress.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::error::InputError;
use super::points::{ReadOptions, ReadProgress};
use super::utf16;
use crate::ending::without_gz;

/// The number of bytes between two calls of the progress function.
const STEP: usize = 1 << 20;

/// Whether data are compressed with gzip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    /// They are.
    Gzip,
    /// They are if they begin with the header of gzip.
    Unknown,
    /// They are not, whatever their first bytes are.
    Plain,
}

impl Packing {
    /// Returns the packing that the name of a file states.
    pub fn of(path: &Path) -> Self {
        if without_gz(path).1 { Packing::Gzip } else { Packing::Unknown }
    }

    /// Returns the packing of a file of points. The first coordinate of a raw file could look like a header of gzip.
    pub fn of_points(path: &Path, options: &ReadOptions) -> Self {
        match (Packing::of(path), options.raw) {
            (Packing::Unknown, Some(_)) => Packing::Plain,
            (packing, _) => packing,
        }
    }
}

/// Counts the bytes read and reports them to the progress function.
struct Counting<'a, R> {
    inner: R,
    read: u64,
    /// The count at the last report.
    reported: u64,
    total: Option<u64>,
    progress: &'a mut ReadProgress<'a>,
    /// Whether the reader itself failed, and not the decoder that reads from it.
    failed: bool,
}

impl<R> Counting<'_, R> {
    fn report(&mut self) {
        self.reported = self.read;
        (self.progress)(self.read, self.total);
    }
}

impl<R: Read> Read for Counting<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let got = self.inner.read(buffer).inspect_err(|error| {
            self.failed = error.kind() != io::ErrorKind::Interrupted;
        })?;
        self.read += got as u64;
        if self.read - self.reported >= STEP as u64 || (got == 0 && self.read > self.reported) {
            self.report();
        }
        Ok(got)
    }
}

/// Returns all bytes of a file, or of standard input for `-`, after decompression.
pub(super) fn load(
    path: &Path,
    packing: Packing,
    progress: &mut ReadProgress<'_>,
) -> Result<Vec<u8>, InputError> {
    if path.as_os_str() == "-" {
        return load_from(io::stdin().lock(), path, None, packing, progress);
    }
    let (file, total) = open(path)?;
    load_from(file, path, total, packing, progress)
}

/// Opens a file. Also returns its size if it is a regular file.
pub(super) fn open(path: &Path) -> Result<(File, Option<u64>), InputError> {
    let file = File::open(path).map_err(|error| unreadable(path, error))?;
    let meta = file.metadata().map_err(|error| unreadable(path, error))?;
    if meta.is_dir() {
        return Err(InputError::Directory { path: path.to_owned() });
    }
    Ok((file, meta.is_file().then_some(meta.len())))
}

/// Returns the error for a file that cannot be opened or read.
pub(super) fn unreadable(path: &Path, source: io::Error) -> InputError {
    match source.kind() {
        io::ErrorKind::NotFound => InputError::Missing { path: path.to_owned() },
        io::ErrorKind::IsADirectory => InputError::Directory { path: path.to_owned() },
        _ => InputError::Unreadable { path: path.to_owned(), source },
    }
}

/// Returns all bytes of a reader, after decompression. Data of [`Packing::Gzip`] without a gzip header are an error.
pub(super) fn load_from<R: Read>(
    reader: R,
    path: &Path,
    total: Option<u64>,
    packing: Packing,
    progress: &mut ReadProgress<'_>,
) -> Result<Vec<u8>, InputError> {
    let mut step = |read: u64, total: Option<u64>| progress(read, total);
    let mut input =
        Counting { inner: reader, read: 0, reported: 0, total, progress: &mut step, failed: false };
    let unreadable = |source| InputError::Unreadable { path: path.to_owned(), source };
    let mut head = Vec::new();
    input.by_ref().take(2).read_to_end(&mut head).map_err(unreadable)?;
    if head == [0x1f, 0x8b] && packing != Packing::Plain {
        let mut data = Vec::new();
        let mut decoder = MultiGzDecoder::new(head.as_slice().chain(&mut input));
        // A few compressed bytes can be many mebibytes.
        let drained = drain(&mut decoder, (&mut data, path), |it| it.get_mut().get_mut().1.report());
        return match drained {
            Ok(()) => Ok(utf16::decoded(data)),
            Err(InputError::Unreadable { path, source }) if !input.failed => {
                Err(InputError::Gzip { path, source })
            }
            Err(error) => Err(error),
        };
    }
    if packing == Packing::Gzip {
        let source = io::Error::new(io::ErrorKind::InvalidData, "the file does not begin as gzip");
        return Err(InputError::Gzip { path: path.to_owned(), source });
    }
    let mut data = head;
    reserve(&mut data, total.unwrap_or(0), path)?;
    drain(&mut input, (&mut data, path), |_| {})?;
    Ok(if packing == Packing::Plain { data } else { utf16::decoded(data) })
}

/// Reads to the end in large steps, and calls `each` after each of them. Returns an error if memory runs out.
fn drain<R: Read>(
    reader: &mut R,
    (data, path): (&mut Vec<u8>, &Path),
    mut each: impl FnMut(&mut R),
) -> Result<(), InputError> {
    loop {
        if data.capacity() - data.len() < STEP {
            let more = data.len().max(STEP) as u64;
            reserve(data, more, path)?;
        }
        let before = data.len();
        let got = reader.by_ref().take(STEP as u64).read_to_end(data);
        got.map_err(|source| InputError::Unreadable { path: path.to_owned(), source })?;
        if data.len() == before {
            return Ok(());
        }
        each(reader);
    }
}

/// Reserves memory for more bytes.
pub(super) fn reserve(data: &mut Vec<u8>, bytes: u64, path: &Path) -> Result<(), InputError> {
    let out_of_memory = || InputError::OutOfMemory { path: path.to_owned(), bytes };
    // Without one extra step, the last read, which finds the end, would reallocate the buffer.
    let wanted = usize::try_from(bytes).map_err(|_| out_of_memory())?.saturating_add(STEP);
    data.try_reserve(wanted).map_err(|_| out_of_memory())
}
