//! The file of a sweep or of checked claims, which consists of complete lines only.
//!
//! Each result is appended in one write. An interruption can leave an incomplete line at the end of the file. The next
//! call drops this part if it begins like a line of the file. If a complete line is not a result, or belongs to another
//! sweep, the next call rejects the file and leaves it unchanged.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use septet_core::Remedy;
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use super::line::{Line, Program, SCHEMA};

/// A reason why the file of a sweep cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The file cannot be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A complete line is not an entry.
    #[error("{}, line {line}: not a line of {what}: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// 1-based line number. Blank lines are not counted.
        line: usize,
        /// The expected kind of file.
        what: &'static str,
        /// The reason.
        reason: String,
    },
    /// The file belongs to another sweep, or to claims with other options.
    #[error("{} belongs to other options of {what}:\n  in the file: {there}\n  requested:   {asked}", path.display())]
    OtherSweep {
        /// The file.
        path: PathBuf,
        /// The expected kind of file.
        what: &'static str,
        /// The words that identify the sweep in the file.
        there: String,
        /// The words that identify the requested sweep.
        asked: String,
    },
    /// The file does not begin like a journal. Opening it would delete its content.
    #[error("{} is not the file of {what} and remains unchanged", path.display())]
    NoSweep {
        /// The expected kind of file.
        what: &'static str,
        /// The file.
        path: PathBuf,
    },
    /// The file was begun by another version, whose counts may differ.
    #[error("{} was begun by septet {there}, this is septet {}", path.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// The version that began the file.
        there: String,
    },
}

impl JournalError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(Remedy::of(match self {
            Self::Io { .. } => "choose a file that you can read and write",
            Self::Line { .. } => "delete the line, or choose another file",
            Self::NoSweep { .. } => "choose another file: this one has other content",
            Self::OtherSweep { .. } | Self::OtherVersion { .. } => {
                "choose another file; `septet fit` accepts several files"
            }
        }))
    }
}

/// A line of a journal. The schema is its first field.
pub trait Entry: Serialize + DeserializeOwned {
    /// The kind of file, for messages.
    const WHAT: &'static str;
    /// Name and version of the schema.
    const SCHEMA: &'static str;
    /// Identifies the line in its file.
    type Key: Ord + std::fmt::Debug;

    /// Returns the stamp of the line.
    fn stamp(&self) -> Stamp<'_>;
    /// Returns the key of the line.
    fn key(&self) -> Self::Key;
}

/// The fields that all lines of a file share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp<'a> {
    /// Name and version of the schema.
    pub schema: &'a str,
    /// Version of septet.
    pub version: &'a str,
    /// The words that identify the sweep.
    pub words: &'a str,
}

impl Entry for Line {
    const WHAT: &'static str = "a sweep";
    const SCHEMA: &'static str = SCHEMA;
    type Key = (Program, String);

    fn stamp(&self) -> Stamp<'_> {
        Stamp { schema: &self.schema, version: &self.version, words: &self.sweep }
    }

    fn key(&self) -> Self::Key {
        (self.program, self.command.clone())
    }
}

/// The lines of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines<T = Line> {
    /// The complete lines.
    pub lines: Vec<T>,
    /// Number of bytes of an incomplete line after them.
    pub incomplete: u64,
    /// Whether these bytes are the beginning of a line of this kind.
    begun: bool,
    /// Number of bytes of the complete lines.
    complete: u64,
}

impl<T> Default for Lines<T> {
    fn default() -> Self {
        Lines { lines: Vec::new(), incomplete: 0, begun: false, complete: 0 }
    }
}

/// Reads the complete lines of a sweep.
///
/// # Errors
/// Fails if the file cannot be read, or if a complete line is not a run.
pub fn read_lines(path: &Path) -> Result<Lines, JournalError> {
    read_entries(path)
}

/// Reads the complete lines of a journal.
///
/// # Errors
/// Fails if the file cannot be read, or if a complete line is not an entry of this kind.
pub fn read_entries<T: Entry>(path: &Path) -> Result<Lines<T>, JournalError> {
    let io_error = |source| JournalError::Io { path: path.to_path_buf(), source };
    let mut reader = BufReader::new(File::open(path).map_err(io_error)?);
    let mut read = Lines::default();
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let length = reader.read_until(b'\n', &mut bytes).map_err(io_error)? as u64;
        if bytes.last() != Some(&b'\n') {
            read.incomplete = length;
            let beginning = beginning::<T>();
            let shared = bytes.len().min(beginning.len());
            read.begun = bytes[..shared] == beginning[..shared];
            return Ok(read);
        }
        read.complete += length;
        if bytes.iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let number = read.lines.len() + 1;
        let fail =
            |reason| JournalError::Line { path: path.to_path_buf(), line: number, what: T::WHAT, reason };
        let line: T = serde_json::from_slice(&bytes).map_err(|e| fail(e.to_string()))?;
        let schema = line.stamp().schema;
        if schema != T::SCHEMA {
            return Err(fail(format!("its schema is `{schema}`, not `{}`", T::SCHEMA)));
        }
        read.lines.push(line);
    }
}

/// Returns the beginning of every line of a kind, up to the version of the schema.
fn beginning<T: Entry>() -> Vec<u8> {
    let name = T::SCHEMA.split_inclusive('/').next().unwrap_or_default();
    format!("{{\"schema\":\"{name}").into_bytes()
}

/// The file of a sweep, open for appending.
#[derive(Debug)]
pub struct Journal<T: Entry = Line> {
    path: PathBuf,
    file: File,
    /// Number of bytes of complete lines.
    end: u64,
    done: BTreeSet<T::Key>,
    /// Number of bytes of an incomplete line that was dropped.
    pub dropped: u64,
}

impl Journal {
    /// Returns `true` if the file contains the run of this program and command.
    pub fn has(&self, program: Program, command: &str) -> bool {
        self.done.contains(&(program, command.to_string()))
    }
}

impl<T: Entry> Journal<T> {
    /// Opens or creates the file of the sweep that `words` identify. The sweep may be new or interrupted.
    ///
    /// # Errors
    /// Fails if the file cannot be read or written, is of another kind, or belongs to another sweep or version.
    pub fn open(path: &Path, words: &str) -> Result<Self, JournalError> {
        let io_error = |source| JournalError::Io { path: path.to_path_buf(), source };
        let there = if path.exists() { read_entries::<T>(path)? } else { Lines::default() };
        for line in &there.lines {
            let (path, Stamp { version, words: found, .. }) = (path.to_path_buf(), line.stamp());
            if found != words {
                let (there, asked) = (found.to_string(), words.to_string());
                return Err(JournalError::OtherSweep { path, what: T::WHAT, there, asked });
            }
            if version != env!("CARGO_PKG_VERSION") {
                return Err(JournalError::OtherVersion { path, there: version.to_string() });
            }
        }
        if !there.begun && there.incomplete > 0 {
            return Err(JournalError::NoSweep { path: path.to_path_buf(), what: T::WHAT });
        }
        let open = OpenOptions::new().create(true).truncate(false).write(true).open(path);
        let mut file = open.map_err(io_error)?;
        file.set_len(there.complete).map_err(io_error)?;
        file.seek(SeekFrom::End(0)).map_err(io_error)?;
        let done = there.lines.iter().map(Entry::key).collect();
        Ok(Journal { path: path.to_path_buf(), file, end: there.complete, done, dropped: there.incomplete })
    }

    /// Returns the number of lines in the file.
    pub fn done(&self) -> usize {
        self.done.len()
    }

    /// Appends a line. After a failure, the file ends with the previous line.
    ///
    /// # Errors
    /// Fails if the line cannot be written completely.
    pub fn append(&mut self, line: &T) -> Result<(), JournalError> {
        let written = serde_json::to_vec(line).map_err(io::Error::other).and_then(|mut bytes| {
            bytes.push(b'\n');
            self.file.write_all(&bytes)?;
            Ok(bytes.len() as u64)
        });
        match written {
            Ok(length) => {
                self.end += length;
                self.done.insert(line.key());
                Ok(())
            }
            Err(source) => {
                // If the incomplete line cannot be removed, the next reader drops it.
                let _ = self.file.set_len(self.end).and_then(|()| self.file.seek(SeekFrom::End(0)));
                Err(JournalError::Io { path: self.path.clone(), source })
            }
        }
    }

    /// Waits until the lines are on disk.
    ///
    /// # Errors
    /// Fails if the operating system cannot confirm that the lines are on disk.
    pub fn sync(&self) -> Result<(), JournalError> {
        self.file.sync_all().map_err(|source| JournalError::Io { path: self.path.clone(), source })
    }
}
