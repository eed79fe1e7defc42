//! Errors of weights of points.

use std::path::{Path, PathBuf};

use septet_core::Remedy;

use super::Place;
use super::texts::{listed, shown};
use crate::format::Role;

/// A reason why a number is no weight of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WeightFault {
    /// It is NaN or infinite.
    #[error("not a finite number")]
    NotFinite,
    /// It is a negative radius.
    #[error("not a radius, which is 0 or more")]
    Negative,
    /// It is a radius whose square is above the range of `f64`.
    #[error("too large: its square is infinite")]
    Overflow,
}

/// A reason why the weights of points cannot be read.
///
/// `path` is the file of the points, or the file of the weights. `are_radii` is whether the numbers are radii.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WeightError {
    /// A number is no weight, or no radius.
    #[error("{}{place}: {} of point {index} (from 0) is {value:?}, {fault}", shown(.path), noun(*.are_radii, 1))]
    Value {
        /// The file.
        path: PathBuf,
        /// The location of the number.
        place: Place,
        /// The zero-based row of the point: in its file for a column, and in the input for a file of weights.
        index: u64,
        /// The number.
        value: f64,
        /// Whether the number is a radius.
        are_radii: bool,
        /// The reason.
        fault: WeightFault,
    },
    /// A file of weights has too few or too many numbers.
    #[error("{}: {found} {} for {expected} {}", shown(.path), noun(*.are_radii, *.found), rows(*.expected))]
    Count {
        /// The file of the weights.
        path: PathBuf,
        /// The number of rows in it.
        found: u64,
        /// The number of rows of points in the input, including dropped ones.
        expected: u64,
        /// Whether the numbers are radii.
        are_radii: bool,
    },
    /// The column of the weights does not exist, or is a column of coordinates.
    #[error("{}{place}: {problem}{}", shown(.path), listed(.names))]
    Column {
        /// The file.
        path: PathBuf,
        /// The header row, the first row, or the header of an array.
        place: Place,
        /// The reason.
        problem: Box<str>,
        /// The names in the header row, shortened. Empty without a header row.
        names: Vec<String>,
    },
    /// The format of the points has no columns to choose.
    #[error("{}: a .{format} file has no column of weights", shown(.path))]
    NoColumns {
        /// The file.
        path: PathBuf,
        /// Its format.
        format: &'static str,
    },
    /// The points have a dimension above 3.
    #[error("{}: points of dimension {dimension} have no weights: only dimensions 2 and 3 do", shown(.path))]
    Dimension {
        /// The file.
        path: PathBuf,
        /// The number of coordinates of a point.
        dimension: usize,
    },
    /// The points are a terrain.
    #[error("{}: the points of a terrain have no weights", shown(.path))]
    Terrain {
        /// The file.
        path: PathBuf,
    },
}

impl WeightError {
    /// Returns what to do.
    pub fn remedy(&self) -> Remedy {
        match self {
            Self::Value { fault: WeightFault::NotFinite, .. } => {
                Remedy::of("correct it, or drop such points with {skip-invalid}")
            }
            Self::Value { .. } => {
                Remedy::of("correct it, drop such points with {skip-invalid}, or give squared radii with {weights}")
            }
            Self::Count { .. } => {
                Remedy::of("give one number for each row of points, also for rows that {skip-invalid} drops")
            }
            Self::Column { .. } => Remedy::of(
                "name another column, choose the columns of the coordinates with {columns} or their number with \
                 {dimension}, or give a file of one number a row: ",
            )
            .and(Role::Weights.known()),
            Self::NoColumns { .. } => Remedy::of("columns of weights are read from ")
                .and(Role::WeightColumn.extensions(|_| true))
                .and("; otherwise give a file of one number a row: ")
                .and(Role::Weights.known()),
            Self::Dimension { .. } => Remedy::of("omit the weights"),
            Self::Terrain { .. } => Remedy::of("omit {terrain}, or omit the weights"),
        }
    }

    /// Returns the file.
    pub(super) fn path(&self) -> &Path {
        match self {
            Self::Value { path, .. }
            | Self::Count { path, .. }
            | Self::Column { path, .. }
            | Self::NoColumns { path, .. }
            | Self::Dimension { path, .. }
            | Self::Terrain { path } => path,
        }
    }

    /// Returns the location in the file.
    pub(super) fn place(&self) -> Place {
        match self {
            Self::Value { place, .. } | Self::Column { place, .. } => *place,
            Self::Count { .. } | Self::NoColumns { .. } | Self::Dimension { .. } | Self::Terrain { .. } => {
                Place::Whole
            }
        }
    }

    /// Returns the zero-based row of the point, if the error concerns a single one.
    pub(super) fn row(&self) -> Option<u64> {
        match self {
            Self::Value { index, .. } => Some(*index),
            _ => None,
        }
    }

    /// Returns `true` if the call is at fault and not the file.
    pub(super) fn is_usage(&self) -> bool {
        matches!(self, Self::Column { .. } | Self::NoColumns { .. } | Self::Terrain { .. })
    }
}

/// Returns the word for this many numbers.
fn noun(are_radii: bool, count: u64) -> &'static str {
    match (are_radii, count) {
        (false, 1) => "weight",
        (false, _) => "weights",
        (true, 1) => "radius",
        (true, _) => "radii",
    }
}

fn rows(count: u64) -> &'static str {
    if count == 1 { "row of points" } else { "rows of points" }
}
