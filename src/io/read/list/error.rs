//! Errors of lists of files.

use std::path::PathBuf;

use septet_core::{Code, Remedy};

use super::super::error::{InputError, shown};
use super::super::points::CoordinateType;

/// A reason why a line of a list does not name a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EntryFault {
    /// The file does not exist.
    #[error("no such file ({})", .path.display())]
    Missing {
        /// The path with the folder of the list.
        path: PathBuf,
    },
    /// The path is a directory.
    #[error("is a directory")]
    Folder,
    /// The line names the list that contains it.
    #[error("is this list itself")]
    Itself,
    /// The line begins with `@`.
    #[error("a list cannot contain a list")]
    List,
    /// The line is `-`.
    #[error("a list cannot contain standard input")]
    StandardInput,
    /// The line is not UTF-8.
    #[error("the name is not UTF-8")]
    NotUtf8,
}

/// A reason why a list of files cannot be read as one set of points.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ListError {
    /// The pattern violates the rules of patterns.
    #[error("{}: invalid pattern: {problem}", .pattern.display())]
    Pattern {
        /// The pattern with its folder.
        pattern: PathBuf,
        /// The violated rule.
        problem: &'static str,
    },
    /// The folder of a pattern cannot be read.
    #[error("{}: the folder {} cannot be read: {source}", .pattern.display(), .folder.display())]
    Folder {
        /// The pattern with its folder.
        pattern: PathBuf,
        /// The folder.
        folder: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// No file matches the pattern.
    #[error("{}: no file matches this pattern", .pattern.display())]
    NoMatch {
        /// The pattern with its folder.
        pattern: PathBuf,
    },
    /// The list itself cannot be read.
    #[error("{error}")]
    List {
        /// The error, which names the list.
        error: Box<InputError>,
    },
    /// A line of the list does not name a file.
    #[error("{}, line {line}: {name}: {fault}", shown(.list))]
    Entry {
        /// The list.
        list: PathBuf,
        /// The 1-based line number.
        line: u64,
        /// The line without surrounding whitespace.
        name: String,
        /// The reason.
        fault: EntryFault,
    },
    /// The list has only comments and empty lines.
    #[error("{}: the list names no file", shown(.list))]
    NoEntry {
        /// The list.
        list: PathBuf,
    },
    /// A file cannot be read.
    #[error("{}{error}", at_row(.error, *.before))]
    File {
        /// The error, which names the file and the row in the file.
        error: Box<InputError>,
        /// The number of rows in the files before this one.
        before: u64,
    },
    /// The file of the weights of all rows cannot be read.
    #[error("{error}")]
    Weights {
        /// The error, which names the file of the weights.
        error: Box<InputError>,
    },
    /// Two files have points of different dimensions.
    #[error("{}: points of dimension {found}, but {} has points of dimension {expected}", .path.display(), .first.display())]
    MixedDimension {
        /// The file.
        path: PathBuf,
        /// The dimension of its points, from 2 to 6.
        found: usize,
        /// The first file with points.
        first: PathBuf,
        /// The dimension of the points in the first file.
        expected: usize,
    },
    /// Two binary files store coordinates as different types.
    #[error("{}: coordinates of type {found}, but {} has type {expected}", .path.display(), .first.display())]
    MixedTypes {
        /// The file.
        path: PathBuf,
        /// The type of its coordinates.
        found: CoordinateType,
        /// The first binary file with points.
        first: PathBuf,
        /// The type of the coordinates in the first file.
        expected: CoordinateType,
    },
    /// Two files have other kept columns.
    #[error("{}: the kept columns are {}, but {} has {}", .path.display(), names(.found), .first.display(), names(.expected))]
    MixedColumns {
        /// The file.
        path: PathBuf,
        /// The names of its numeric columns that are not coordinates.
        found: Vec<String>,
        /// The first file with points.
        first: PathBuf,
        /// The names of the columns of the first file.
        expected: Vec<String>,
    },
}

impl EntryFault {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(Remedy::of(match self {
            Self::Missing { .. } => "check the name, which is relative to the folder of the list",
            Self::Folder => "name the files in it, one per line",
            Self::Itself => "remove the line",
            Self::List => "copy its lines, or write ./@NAME for a file whose name begins with @",
            Self::StandardInput => "save the points to a file and name it",
            Self::NotUtf8 => "save the list as UTF-8, or rename the file",
        }))
    }
}

impl ListError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(Remedy::of(match self {
            Self::File { error, .. } | Self::List { error } | Self::Weights { error } => {
                return error.remedy();
            }
            Self::Entry { fault, .. } => return fault.remedy(),
            Self::Pattern { .. } => "use *, ? and [...] only, in the file name",
            Self::Folder { .. } => "check the folder, which cannot be a pattern",
            Self::NoMatch { .. } => "check the name and the folder",
            Self::NoEntry { .. } => "write one path per line",
            Self::MixedDimension { .. } => "give files of one dimension, or use {dimension=2}",
            Self::MixedTypes { .. } => "save all files with one type",
            Self::MixedColumns { .. } => "give all files the same numeric columns, or omit {keep-columns}",
        }))
    }

    /// Returns the exit code of the program.
    pub fn exit_code(&self) -> Code {
        match self {
            Self::File { error, .. } | Self::List { error } | Self::Weights { error } => error.exit_code(),
            Self::Pattern { .. } => Code::Usage,
            _ => Code::Input,
        }
    }

    /// Returns the index across all files of the offending point, if the error concerns a single row of points.
    pub fn row(&self) -> Option<u64> {
        match self {
            Self::File { error, before } => error.row().map(|row| before + row),
            Self::Weights { error } => error.row(),
            _ => None,
        }
    }
}

/// Formats the row across the files of a list, and the row in the file, if the error concerns a single row of points.
/// `before` is the number of rows in the files before this one.
fn at_row(error: &InputError, before: u64) -> String {
    let at = |row| format!("row {} of the list, row {row} of its file (both from 0): ", before + row);
    error.row().map_or_else(String::new, at)
}

/// Formats the names of columns.
fn names(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
