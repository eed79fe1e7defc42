//! What can be wrong with an input file. Every message names the file, the place and what to do.

use std::fmt;
use std::path::{Path, PathBuf};

/// Where in a file something was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, counted from 1.
    Line(u64),
    /// A byte of a binary file (after gunzipping), counted from 0.
    Byte(u64),
    /// The file as a whole.
    Whole,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(line) => write!(f, ", line {line}"),
            Place::Byte(offset) => write!(f, ", byte {offset}"),
            Place::Whole => Ok(()),
        }
    }
}

/// A point or cell file that cannot be read. In every variant `path` is the file (`-` is standard
/// input) and `place`, where present, the line or byte at fault.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// There is no such file.
    #[error("{}: no such file; check the name, or give - to read standard input", shown(.path))]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The operating system refused to open or read the file.
    #[error("{}: cannot be read: {source}; check its permissions and that it is a plain file", shown(.path))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The gzip stream is damaged, cut short, or absent under a `.gz` name.
    #[error("{}: the gzip data are damaged or cut short: {source}; fetch the file again, or test it with `gzip -t`", shown(.path))]
    Gzip {
        /// The file.
        path: PathBuf,
        /// What the decoder said.
        source: std::io::Error,
    },
    /// Neither name nor content tell the format.
    #[error("{}: unknown format; rename the file or state its format (known: {known})", shown(.path))]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The formats that could be read here.
        known: &'static str,
    },
    /// A legal file of a kind that is not read.
    #[error("{}{place}: {what} is not read; {advice}", shown(.path))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Where it shows.
        place: Place,
        /// The kind of content.
        what: String,
        /// What to do.
        advice: &'static str,
    },
    /// A line or token that breaks the rules of the format.
    #[error("{}, line {line}{}: found \"{text}\", expected {expected}", shown(.path), at_column(*.column))]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The column in bytes, from 1, where one token is to blame.
        column: Option<u64>,
        /// What stands there (shortened).
        text: String,
        /// What should stand there.
        expected: String,
    },
    /// Binary content that breaks the rules of the format.
    #[error("{}, byte {offset}: found {found}, expected {expected}", shown(.path))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The byte, from 0, after gunzipping.
        offset: u64,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: &'static str,
    },
    /// A coordinate is NaN or infinite.
    #[error("{}{place}: coordinate of point {index} (from 0) is {value}, not a finite number; mend it, or drop such points with --skip-invalid", shown(.path))]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Where the coordinate stands.
        place: Place,
        /// The zero-based index of the point in the file.
        index: u64,
        /// The value: NaN or an infinity (also a number too large for a double).
        value: f64,
    },
    /// The file ends before what it announces.
    #[error("{}{place}: {expected} {what} announced, {found} found; the file is cut short or its count is wrong", shown(.path))]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Where it was announced or where it ends.
        place: Place,
        /// How many were announced.
        expected: u64,
        /// How many are there.
        found: u64,
        /// What was counted.
        what: &'static str,
    },
    /// The file goes on after what it announces.
    #[error("{}{place}: more than the {expected} {what} announced; correct the count in the header", shown(.path))]
    Count {
        /// The file.
        path: PathBuf,
        /// The first surplus line.
        place: Place,
        /// How many were announced.
        expected: u64,
        /// What was counted.
        what: &'static str,
    },
    /// A row has another number of coordinates than the rest, or than was asked for.
    #[error("{}{place}: {found} coordinates, where {expected} are expected; give every row the same number, or choose the dimension with -d", shown(.path))]
    MixedDimension {
        /// The file.
        path: PathBuf,
        /// The row.
        place: Place,
        /// Coordinates expected: 2 or 3.
        expected: usize,
        /// Coordinates found.
        found: usize,
    },
    /// Neither the plane nor space.
    #[error("{}{place}: dimension {found}; only 2 and 3 are supported", shown(.path))]
    UnsupportedDimension {
        /// The file.
        path: PathBuf,
        /// Where it is stated.
        place: Place,
        /// The dimension found or asked for.
        found: u64,
    },
    /// A cell names a point that does not exist.
    #[error("{}{place}: cell {cell} (from 0) names point {value}; point ids start at {first}{}; check that the points belong to these cells", shown(.path), of_points(*.limit))]
    OutOfRangeIndex {
        /// The file.
        path: PathBuf,
        /// Where the index stands.
        place: Place,
        /// The zero-based index of the cell in the file.
        cell: u64,
        /// The index as written.
        value: i128,
        /// The smallest legal id.
        first: u64,
        /// The number of points, where known.
        limit: Option<u64>,
    },
    /// The content does not fit in memory.
    #[error("{}: {bytes} bytes of memory are not to be had; free some memory or split the input", shown(.path))]
    OutOfMemory {
        /// The file.
        path: PathBuf,
        /// Bytes asked for.
        bytes: u64,
    },
}

impl InputError {
    /// The file at fault (`-` is standard input).
    pub fn path(&self) -> &Path {
        match self {
            Self::Missing { path }
            | Self::Unreadable { path, .. }
            | Self::Gzip { path, .. }
            | Self::UnknownFormat { path, .. }
            | Self::Unsupported { path, .. }
            | Self::Syntax { path, .. }
            | Self::Malformed { path, .. }
            | Self::NotFinite { path, .. }
            | Self::Truncated { path, .. }
            | Self::Count { path, .. }
            | Self::MixedDimension { path, .. }
            | Self::UnsupportedDimension { path, .. }
            | Self::OutOfRangeIndex { path, .. }
            | Self::OutOfMemory { path, .. } => path,
        }
    }

    /// The same fault, its place known better.
    pub(super) fn at(mut self, better: Place) -> Self {
        if let Self::NotFinite { place, .. } | Self::OutOfRangeIndex { place, .. } = &mut self {
            *place = better;
        }
        self
    }

    /// Where in the file the fault is.
    pub fn place(&self) -> Place {
        match self {
            Self::Missing { .. }
            | Self::Unreadable { .. }
            | Self::Gzip { .. }
            | Self::UnknownFormat { .. }
            | Self::OutOfMemory { .. } => Place::Whole,
            Self::Syntax { line, .. } => Place::Line(*line),
            Self::Malformed { offset, .. } => Place::Byte(*offset),
            Self::Unsupported { place, .. }
            | Self::NotFinite { place, .. }
            | Self::Truncated { place, .. }
            | Self::Count { place, .. }
            | Self::MixedDimension { place, .. }
            | Self::UnsupportedDimension { place, .. }
            | Self::OutOfRangeIndex { place, .. } => *place,
        }
    }

    /// The line at fault, counted from 1, where the file is text and one line is to blame.
    pub fn line(&self) -> Option<u64> {
        match self.place() {
            Place::Line(line) => Some(line),
            Place::Byte(_) | Place::Whole => None,
        }
    }

    /// The column at fault in bytes, counted from 1, where one token is to blame.
    pub fn column(&self) -> Option<u64> {
        match self {
            Self::Syntax { column, .. } => *column,
            _ => None,
        }
    }
}

/// The file's name for messages.
fn shown(path: &Path) -> String {
    if path.as_os_str() == "-" { "standard input".to_owned() } else { path.display().to_string() }
}

fn at_column(column: Option<u64>) -> String {
    column.map_or_else(String::new, |column| format!(", column {column}"))
}

fn of_points(limit: Option<u64>) -> String {
    limit.map_or_else(String::new, |limit| format!(" and there are {limit} points"))
}
