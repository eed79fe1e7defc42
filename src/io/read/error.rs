//! Errors of the readers. Each message gives the file, the location and the problem.

mod texts;
mod weight;

use std::fmt;
use std::path::{Path, PathBuf};

use septet_core::{Code, Remedy};

use crate::format::{Role, may_be_table};
pub(super) use texts::shown;
use texts::{at_column, choose_columns, known_formats, listed, of_points};
pub use weight::{WeightError, WeightFault};

/// A location in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A 1-based line number in a text file.
    Line(u64),
    /// A 0-based byte offset in a binary file, after decompression.
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

/// A reason why a file of points, cells, sizes or a domain cannot be read.
///
/// `path` is the file, or `-` for standard input. `place` is the line or byte at which the error occurs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// The file does not exist.
    #[error("{}: no such file", shown(.path))]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The path is a directory.
    #[error("{}: is a directory", shown(.path))]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// The operating system cannot open or read the file.
    #[error("{}: cannot be read: {source}", shown(.path))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The gzip data are damaged, incomplete, or missing although the name ends in `.gz`.
    #[error("{}: the gzip data are damaged or incomplete: {source}", shown(.path))]
    Gzip {
        /// The file.
        path: PathBuf,
        /// The error of the decoder.
        source: std::io::Error,
    },
    /// Neither the name nor the content determines the format.
    #[error("{}: unknown format", shown(.path))]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The nearest format, or how to convert the file to a known one, if its extension is known.
        advice: Option<String>,
        /// The use of the file.
        role: Role,
    },
    /// The file is valid, but this kind of content is not supported.
    #[error("{}{place}: {what} is not supported", shown(.path))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The location of the unsupported content.
        place: Place,
        /// The kind of content.
        what: String,
        /// The remedy.
        advice: String,
    },
    /// A line or word violates the rules of the format.
    #[error("{}, line {line}{}: found \"{text}\", expected {expected}", shown(.path), at_column(*.column))]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The 1-based line number.
        line: u64,
        /// The 1-based column in bytes, if the error concerns a single word.
        column: Option<u32>,
        /// The offending text, shortened.
        text: Box<str>,
        /// The text that the format requires.
        expected: Box<str>,
        /// The zero-based index in the file of the point, if the error concerns a row of points.
        row: Option<u64>,
        /// A possible choice of columns, if other columns of the row are numbers.
        columns: Option<Box<str>>,
    },
    /// Binary content violates the rules of the format.
    #[error("{}, byte {offset}: found {found}, expected {expected}", shown(.path))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The 0-based byte offset, after decompression.
        offset: u64,
        /// The offending content.
        found: String,
        /// The content that the format requires.
        expected: &'static str,
    },
    /// The columns of a table do not determine the coordinates.
    #[error("{}{place}: {problem}{}", shown(.path), listed(.names))]
    Columns {
        /// The file.
        path: PathBuf,
        /// The header row, or the first row of numbers.
        place: Place,
        /// The reason.
        problem: Box<str>,
        /// The names in the header row, shortened. Empty without a header row.
        names: Vec<String>,
        /// A choice of columns, or an empty text if none is sure.
        example: String,
    },
    /// The file is a grid of heights, and not a table of points.
    #[error("{}: a grid of heights (ESRI ASCII raster), not a table of points", shown(.path))]
    Grid {
        /// The file.
        path: PathBuf,
    },
    /// The points of a terrain have no height.
    #[error("{}{place}: the points have no z, which a terrain needs", shown(.path))]
    NoHeights {
        /// The file.
        path: PathBuf,
        /// The location of the dimension, or the first row.
        place: Place,
    },
    /// A terrain is requested in space.
    #[error("{}: a terrain is triangulated in the plane, and not in dimension 3", shown(.path))]
    TerrainInSpace {
        /// The file.
        path: PathBuf,
    },
    /// A table has a header row that names the coordinates, but no rows of points.
    #[error("{}{place}: the file has a header and no rows", shown(.path))]
    NoRows {
        /// The file.
        path: PathBuf,
        /// The header row.
        place: Place,
    },
    /// The name of a file to be read as raw coordinates is that of another format.
    #[error("{}: the coordinates of a .{format} file are not raw", shown(.path))]
    NotRaw {
        /// The file.
        path: PathBuf,
        /// The format of its name.
        format: &'static str,
    },
    /// A raw file does not end with a whole row.
    #[error("{}: {size} bytes are not whole rows of {row} bytes", shown(.path))]
    PartOfRow {
        /// The file.
        path: PathBuf,
        /// The size in bytes, after decompression.
        size: u64,
        /// The number of bytes of a row.
        row: u64,
    },
    /// Columns are chosen in a file that is not a text table.
    #[error("{}: a .{format} file has no columns to choose", shown(.path))]
    NotATable {
        /// The file.
        path: PathBuf,
        /// The format of the file.
        format: &'static str,
    },
    /// A coordinate is NaN or infinite.
    #[error("{}{place}: coordinate of point {index} (from 0) is {value}, not a finite number", shown(.path))]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The location of the coordinate.
        place: Place,
        /// The zero-based index of the point in the file.
        index: u64,
        /// NaN or an infinity. A number above the range of `f64` is read as an infinity.
        value: f64,
    },
    /// The file ends before the announced number of entries.
    #[error("{}{place}: {expected} {what} announced, {found} found", shown(.path))]
    Truncated {
        /// The file.
        path: PathBuf,
        /// The location of the count, or the end of the file.
        place: Place,
        /// The announced number.
        expected: u64,
        /// The number of entries in the file.
        found: u64,
        /// The kind of entries.
        what: &'static str,
    },
    /// The file continues after the announced number of entries.
    #[error("{}{place}: more than the {expected} {what} announced", shown(.path))]
    Count {
        /// The file.
        path: PathBuf,
        /// The first surplus line.
        place: Place,
        /// The announced number.
        expected: u64,
        /// The kind of entries.
        what: &'static str,
    },
    /// The number of coordinates in a row differs from the other rows or from the requested dimension.
    #[error("{}{place}: {found} coordinate{} instead of {expected}", shown(.path), if *.found == 1 { "" } else { "s" })]
    MixedDimension {
        /// The file.
        path: PathBuf,
        /// The row.
        place: Place,
        /// The expected number of coordinates: 2 to 6.
        expected: usize,
        /// The number of coordinates in the row.
        found: usize,
        /// The zero-based index in the file of the point, if the error concerns a row of points.
        row: Option<u64>,
    },
    /// An array of points has a constant last column, like homogeneous coordinates.
    #[error(
        "{}{place}: the last column of an array of shape ({rows}, {columns}) is constant (homogeneous coordinates?)",
        shown(.path)
    )]
    Homogeneous {
        /// The file.
        path: PathBuf,
        /// The first row.
        place: Place,
        /// The number of rows.
        rows: u64,
        /// The number of columns.
        columns: usize,
    },
    /// The dimension is not supported.
    #[error("{}{place}: dimension {found} is not supported (supported: 2 to 6)", shown(.path))]
    UnsupportedDimension {
        /// The file.
        path: PathBuf,
        /// The location of the dimension, or the first row.
        place: Place,
        /// The dimension of the file, or the requested one.
        found: u64,
    },
    /// A cell refers to a point that does not exist.
    #[error("{}{place}: cell {cell} (from 0) names point {value}, but point ids start at {first}{}", shown(.path), of_points(*.limit))]
    OutOfRangeIndex {
        /// The file.
        path: PathBuf,
        /// The location of the id.
        place: Place,
        /// The zero-based index of the cell in the file.
        cell: u64,
        /// The id as written.
        value: i128,
        /// The smallest valid id.
        first: u64,
        /// The number of points, if it is known.
        limit: Option<u64>,
    },
    /// A piece of a triangulation does not agree with the other pieces.
    #[error("{}: this piece does not agree with the others: {what}", shown(.path))]
    Pieces {
        /// The file of the piece.
        path: PathBuf,
        /// The difference.
        what: String,
    },
    /// The content does not fit in memory.
    #[error("{}: cannot allocate {bytes} bytes", shown(.path))]
    OutOfMemory {
        /// The file.
        path: PathBuf,
        /// The number of bytes requested.
        bytes: u64,
    },
    /// The weights of the points cannot be read.
    #[error(transparent)]
    Weights(#[from] WeightError),
}

impl InputError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(match self {
            Self::Missing { .. } => Remedy::of("check the name, or use - to read standard input"),
            Self::Directory { .. } => Remedy::of("name a file in it"),
            Self::Unreadable { .. } => Remedy::of("check its permissions and that it is a regular file"),
            Self::Gzip { .. } => Remedy::of("fetch the file again, or test it with `gzip -t`"),
            Self::UnknownFormat { advice, role, .. } => known_formats(advice.as_deref(), *role),
            Self::Unsupported { advice, .. } => Remedy::plain(advice),
            Self::Columns { example, .. } => choose_columns(example),
            Self::Syntax { columns: Some(example), .. } => choose_columns(example),
            Self::Syntax { columns: None, .. } => {
                Remedy::of("correct the file, or give it the extension of its format")
            }
            Self::Grid { .. } => Remedy::of("read the heights of its cells with {terrain}"),
            Self::NoHeights { .. } => Remedy::of("give a file with x, y and z, or omit {terrain}"),
            Self::TerrainInSpace { .. } => Remedy::of("omit {dimension} or {terrain}"),
            Self::NoRows { .. } => Remedy::of("add the rows, or check that the file is complete"),
            Self::NotRaw { .. } => Remedy::of("omit {raw}, or rename the file"),
            Self::PartOfRow { .. } => {
                Remedy::of("check the type and the dimension in {raw}, or fetch the complete file")
            }
            Self::NotATable { .. } => Remedy::of("omit {columns} and {keep-columns}"),
            Self::NotFinite { .. } => Remedy::of("correct it, or drop such points with {skip-invalid}"),
            Self::Truncated { .. } => Remedy::of("the file is incomplete or its count is wrong"),
            Self::Count { .. } => Remedy::of("correct the count in the header"),
            Self::Homogeneous { columns, .. } => {
                Remedy::of("save only the columns of the coordinates, or state ")
                    .set("dimension", columns)
                    .then(" if it is a coordinate")
            }
            Self::MixedDimension { .. } => {
                Remedy::of("give every row the same number, or choose it with {dimension}")
            }
            Self::OutOfRangeIndex { .. } => Remedy::of("check that the points belong to these cells"),
            Self::Pieces { .. } => {
                Remedy::of("write all pieces again, together with the file that lists them")
            }
            Self::OutOfMemory { .. } => Remedy::of("free memory or split the input"),
            Self::Weights(error) => error.remedy(),
            Self::Malformed { .. } | Self::UnsupportedDimension { .. } => return None,
        })
    }

    /// Returns the offending file, or `-` for standard input.
    pub fn path(&self) -> &Path {
        match self {
            Self::Missing { path }
            | Self::Directory { path }
            | Self::Unreadable { path, .. }
            | Self::Gzip { path, .. }
            | Self::UnknownFormat { path, .. }
            | Self::Unsupported { path, .. }
            | Self::Syntax { path, .. }
            | Self::Malformed { path, .. }
            | Self::Columns { path, .. }
            | Self::Grid { path }
            | Self::NoHeights { path, .. }
            | Self::TerrainInSpace { path }
            | Self::NoRows { path, .. }
            | Self::NotRaw { path, .. }
            | Self::PartOfRow { path, .. }
            | Self::NotATable { path, .. }
            | Self::NotFinite { path, .. }
            | Self::Truncated { path, .. }
            | Self::Count { path, .. }
            | Self::MixedDimension { path, .. }
            | Self::Homogeneous { path, .. }
            | Self::UnsupportedDimension { path, .. }
            | Self::OutOfRangeIndex { path, .. }
            | Self::Pieces { path, .. }
            | Self::OutOfMemory { path, .. } => path,
            Self::Weights(error) => error.path(),
        }
    }

    /// Returns the error with a more precise location.
    pub(super) fn at(mut self, better: Place) -> Self {
        if let Self::NotFinite { place, .. } | Self::OutOfRangeIndex { place, .. } = &mut self {
            *place = better;
        }
        self
    }

    /// Returns the error for this row of points, given by its zero-based index in the file.
    pub(super) fn in_row(mut self, index: u64) -> Self {
        if let Self::Syntax { row, .. } | Self::MixedDimension { row, .. } = &mut self {
            *row = Some(index);
        }
        self
    }

    /// Returns the error with a possible choice of columns.
    pub(super) fn with_columns(mut self, example: Option<String>) -> Self {
        if let Self::Syntax { columns, .. } = &mut self {
            *columns = example.map(String::into_boxed_str);
        }
        self
    }

    /// Returns the zero-based index in the file of the offending point, if the error concerns a single row of points.
    pub fn row(&self) -> Option<u64> {
        match self {
            Self::NotFinite { index, .. } => Some(*index),
            Self::Weights(error) => error.row(),
            Self::Syntax { row, .. } | Self::MixedDimension { row, .. } => *row,
            _ => None,
        }
    }

    /// Returns the location of the error in the file.
    pub fn place(&self) -> Place {
        match self {
            Self::Missing { .. }
            | Self::Directory { .. }
            | Self::Unreadable { .. }
            | Self::Gzip { .. }
            | Self::UnknownFormat { .. }
            | Self::Grid { .. }
            | Self::TerrainInSpace { .. }
            | Self::NotRaw { .. }
            | Self::PartOfRow { .. }
            | Self::NotATable { .. }
            | Self::Pieces { .. }
            | Self::OutOfMemory { .. } => Place::Whole,
            Self::Syntax { line, .. } => Place::Line(*line),
            Self::Malformed { offset, .. } => Place::Byte(*offset),
            Self::Unsupported { place, .. }
            | Self::Columns { place, .. }
            | Self::NoHeights { place, .. }
            | Self::NoRows { place, .. }
            | Self::NotFinite { place, .. }
            | Self::Truncated { place, .. }
            | Self::Count { place, .. }
            | Self::MixedDimension { place, .. }
            | Self::Homogeneous { place, .. }
            | Self::UnsupportedDimension { place, .. }
            | Self::OutOfRangeIndex { place, .. } => *place,
            Self::Weights(error) => error.place(),
        }
    }

    /// Returns the 1-based number of the offending line, if the file is text and the error concerns a single line.
    pub fn line(&self) -> Option<u64> {
        match self.place() {
            Place::Line(line) => Some(line),
            Place::Byte(_) | Place::Whole => None,
        }
    }

    /// Returns the 1-based column of the offending word in bytes, if the error concerns a single word.
    pub fn column(&self) -> Option<u64> {
        match self {
            Self::Syntax { column, .. } => column.map(u64::from),
            _ => None,
        }
    }

    /// Returns the exit code of the program.
    pub fn exit_code(&self) -> Code {
        match self {
            Self::OutOfMemory { .. } => Code::Limit,
            _ if self.is_usage() => Code::Usage,
            _ => Code::Input,
        }
    }

    /// Returns `true` if the call is at fault and not the file: the file can be read with other options, or the extension
    /// of its name is unknown.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Columns { .. }
            | Self::TerrainInSpace { .. }
            | Self::NotATable { .. }
            | Self::NotRaw { .. } => true,
            Self::UnknownFormat { path, .. } => !may_be_table(path),
            Self::Weights(error) => error.is_usage(),
            _ => false,
        }
    }
}
