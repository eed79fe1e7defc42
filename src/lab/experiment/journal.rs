//! The file of a sweep: complete lines, and nothing else that is trusted.
//!
//! A run's line is appended in one piece when the run is over. What stands after the last line's end was torn
//! by an interruption and is dropped when the sweep is taken up, if it begins as lines do. Anything else (a complete
//! line that is no run, or belongs to another sweep) is refused and the file left as it is.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::line::{Line, SCHEMA};

/// A file of lines that cannot be read or written.
#[derive(Debug, Error)]
pub enum JournalError {
    /// The file cannot be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A complete line that is no run.
    #[error("{}, line {line}: no run of a sweep: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// The file belongs to a sweep that asked for something else.
    #[error("{} holds another sweep:\n  there: {there}\n  asked: {asked}", path.display())]
    OtherSweep {
        /// The file.
        path: PathBuf,
        /// Its sweep's words.
        there: String,
        /// The words of the sweep asked for.
        asked: String,
    },
    /// Something else than the lines of a sweep, which would be lost.
    #[error("{} holds no sweep: it is left as it is; name another file", path.display())]
    NoSweep {
        /// The file.
        path: PathBuf,
    },
    /// The same sweep by another version, whose counts may differ.
    #[error("{} was begun by septet {there}, this is {}", path.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// The version that began it.
        there: String,
    },
}

/// How every run's line begins.
const BEGINNING: &[u8] = b"{\"schema\":\"septet-scale/";

/// Lines of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// The complete ones.
    pub lines: Vec<Line>,
    /// Bytes after them, of a line that was torn.
    pub torn: u64,
    /// Are those bytes the beginning of a run's line?
    begun: bool,
    /// Bytes of the complete lines.
    complete: u64,
}

/// Reads the complete lines of a sweep.
///
/// # Errors
/// A file that cannot be read, or a complete line that is no run.
pub fn read_lines(path: &Path) -> Result<Lines, JournalError> {
    let io_error = |source| JournalError::Io { path: path.to_path_buf(), source };
    let mut reader = BufReader::new(File::open(path).map_err(io_error)?);
    let mut read = Lines::default();
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let length = reader.read_until(b'\n', &mut bytes).map_err(io_error)? as u64;
        if bytes.last() != Some(&b'\n') {
            read.torn = length;
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

/// The file of a sweep, open for the lines that are missing.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Bytes of complete lines.
    end: u64,
    done: BTreeSet<(super::Program, String)>,
    /// Bytes of a torn line that was dropped.
    pub dropped: u64,
}

impl Journal {
    /// Opens the file of the sweep with these words, new or interrupted.
    ///
    /// # Errors
    /// A file that cannot be read or written, is none of a sweep, or that of another sweep or version.
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
        if !there.begun && there.torn > 0 {
            return Err(JournalError::NoSweep { path: path.to_path_buf() });
        }
        let open = OpenOptions::new().create(true).truncate(false).write(true).open(path);
        let mut file = open.map_err(io_error)?;
        file.set_len(there.complete).map_err(io_error)?;
        file.seek(SeekFrom::End(0)).map_err(io_error)?;
        let done = there.lines.iter().map(|line| (line.program, line.command.clone())).collect();
        Ok(Journal { path: path.to_path_buf(), file, end: there.complete, done, dropped: there.torn })
    }

    /// Runs that are there.
    pub fn done(&self) -> usize {
        self.done.len()
    }

    /// Is the run that this command makes there?
    pub fn has(&self, program: super::Program, command: &str) -> bool {
        self.done.contains(&(program, command.to_string()))
    }

    /// Appends a run. After a failure the file ends with the line before.
    ///
    /// # Errors
    /// If it cannot be written whole.
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
                // A torn line is dropped by the next reader if it cannot be cut off here.
                let _ = self.file.set_len(self.end).and_then(|()| self.file.seek(SeekFrom::End(0)));
                Err(JournalError::Io { path: self.path.clone(), source })
            }
        }
    }

    /// Waits until the lines are on the disk.
    ///
    /// # Errors
    /// If the system cannot say so.
    pub fn sync(&self) -> Result<(), JournalError> {
        self.file.sync_all().map_err(|source| JournalError::Io { path: self.path.clone(), source })
    }
}
