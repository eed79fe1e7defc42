//! The file of a sweep, which consists of complete lines only.
//!
//! A run appends its line in one write. An interruption can leave an incomplete line at the end of the file. The next
//! sweep drops this part if it begins like a line of a sweep. If a complete line is not a run, or is a run of another
//! sweep, the file is refused and remains unchanged.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::line::{Line, SCHEMA};

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
    /// A complete line is not a run.
    #[error("{}, line {line}: not a run of a sweep: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// 1-based line number.
        line: usize,
        /// The reason.
        reason: String,
    },
    /// The file belongs to another sweep.
    #[error("{} belongs to another sweep:\n  in the file: {there}\n  requested:   {asked}", path.display())]
    OtherSweep {
        /// The file.
        path: PathBuf,
        /// The words that identify the sweep in the file.
        there: String,
        /// The words that identify the requested sweep.
        asked: String,
    },
    /// The file is not a sweep, and its content would be lost.
    #[error("{} is not the file of a sweep and remains unchanged; choose another file", path.display())]
    NoSweep {
        /// The file.
        path: PathBuf,
    },
    /// The sweep was begun by another version, whose counts may differ.
    #[error("{} was begun by septet {there}, this is {}", path.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// The version that began the file.
        there: String,
    },
}

/// The beginning of every line.
const BEGINNING: &[u8] = b"{\"schema\":\"septet-scale/";

/// The lines of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// The complete lines.
    pub lines: Vec<Line>,
    /// Number of bytes of an incomplete line after them.
    pub incomplete: u64,
    /// Whether these bytes are the beginning of a line of a sweep.
    begun: bool,
    /// Number of bytes of the complete lines.
    complete: u64,
}

/// Reads the complete lines of a sweep.
///
/// # Errors
/// Fails if the file cannot be read, or if a complete line is not a run.
pub fn read_lines(path: &Path) -> Result<Lines, JournalError> {
    let io_error = |source| JournalError::Io { path: path.to_path_buf(), source };
    let mut reader = BufReader::new(File::open(path).map_err(io_error)?);
    let mut read = Lines::default();
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let length = reader.read_until(b'\n', &mut bytes).map_err(io_error)? as u64;
        if bytes.last() != Some(&b'\n') {
            read.incomplete = length;
            let shared = bytes.len().min(BEGINNING.len());
            read.begun = bytes[..shared] == BEGINNING[..shared];
            return Ok(read);
        }
        read.complete += length;
        if bytes.iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let number = read.lines.len() + 1;
        let fail = |reason| JournalError::Line { path: path.to_path_buf(), line: number, reason };
        let line: Line = serde_json::from_slice(&bytes).map_err(|e| fail(e.to_string()))?;
        if line.schema != SCHEMA {
            return Err(fail(format!("its schema is `{}`, not `{SCHEMA}`", line.schema)));
        }
        read.lines.push(line);
    }
}

/// The file of a sweep, open for appending.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Number of bytes of complete lines.
    end: u64,
    done: BTreeSet<(super::Program, String)>,
    /// Number of bytes of an incomplete line that was dropped.
    pub dropped: u64,
}

impl Journal {
    /// Opens or creates the file of the sweep that `words` identify. The sweep may be new or interrupted.
    ///
    /// # Errors
    /// Fails if the file cannot be read or written, is not a sweep, or belongs to another sweep or version.
    pub fn open(path: &Path, words: &str) -> Result<Journal, JournalError> {
        let io_error = |source| JournalError::Io { path: path.to_path_buf(), source };
        let there = if path.exists() { read_lines(path)? } else { Lines::default() };
        for line in &there.lines {
            let path = || path.to_path_buf();
            if line.sweep != words {
                let (there, asked) = (line.sweep.clone(), words.to_string());
                return Err(JournalError::OtherSweep { path: path(), there, asked });
            }
            if line.version != env!("CARGO_PKG_VERSION") {
                return Err(JournalError::OtherVersion { path: path(), there: line.version.clone() });
            }
        }
        if !there.begun && there.incomplete > 0 {
            return Err(JournalError::NoSweep { path: path.to_path_buf() });
        }
        let open = OpenOptions::new().create(true).truncate(false).write(true).open(path);
        let mut file = open.map_err(io_error)?;
        file.set_len(there.complete).map_err(io_error)?;
        file.seek(SeekFrom::End(0)).map_err(io_error)?;
        let done = there.lines.iter().map(|line| (line.program, line.command.clone())).collect();
        Ok(Journal { path: path.to_path_buf(), file, end: there.complete, done, dropped: there.incomplete })
    }

    /// Returns the number of runs in the file.
    pub fn done(&self) -> usize {
        self.done.len()
    }

    /// Returns `true` if the file contains the run of this program and command.
    pub fn has(&self, program: super::Program, command: &str) -> bool {
        self.done.contains(&(program, command.to_string()))
    }

    /// Appends a run. If this fails, the file ends with the previous line.
    ///
    /// # Errors
    /// Fails if the line cannot be written completely.
    pub fn append(&mut self, line: &Line) -> Result<(), JournalError> {
        let written = serde_json::to_vec(line).map_err(io::Error::other).and_then(|mut bytes| {
            bytes.push(b'\n');
            self.file.write_all(&bytes)?;
            Ok(bytes.len() as u64)
        });
        match written {
            Ok(length) => {
                self.end += length;
                self.done.insert((line.program, line.command.clone()));
                Ok(())
            }
            Err(source) => {
                // If this fails to remove the incomplete line, the next reader drops it.
                let _ = self.file.set_len(self.end).and_then(|()| self.file.seek(SeekFrom::End(0)));
                Err(JournalError::Io { path: self.path.clone(), source })
            }
        }
    }

    /// Waits until the lines are on disk.
    ///
    /// # Errors
    /// Fails if the operating system cannot confirm this.
    pub fn sync(&self) -> Result<(), JournalError> {
        self.file.sync_all().map_err(|source| JournalError::Io { path: self.path.clone(), source })
    }
}
