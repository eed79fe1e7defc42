//! Reasons why a query has no answer.

use septet_core::Code;
use septet_geometry::range::RangeError;
use thiserror::Error;

/// A triangulation or an argument that queries cannot use.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum QueryError {
    /// The points are not those of the run.
    #[error("the run has {run} points, but {given} are given; pass the points of the run")]
    OtherPoints {
        /// Number of given points.
        given: usize,
        /// Number of points of the run.
        run: u64,
    },
    /// The run has weights, a periodic box, several processes, or stopped early.
    #[error("queries need a whole triangulation of one process, without weights and without a periodic box")]
    OtherRun,
    /// There are more points or cells than 32-bit indices can address.
    #[error("there are {count} {what}, but queries can address {most}", most = u32::MAX - 1)]
    TooMany {
        /// `points` or `cells`.
        what: &'static str,
        /// Number of points or cells.
        count: usize,
    },
    /// Two points differ in scale by more than the exact predicates allow.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// The points do not span the space, so they have no cells.
    #[error("the points have no cells, because their affine hull has the dimension {dimension}")]
    Flat {
        /// Dimension of the affine hull.
        dimension: isize,
    },
    /// The lower corner of a box is not below the upper one, or a corner is not finite.
    #[error(
        "the box is empty or infinite along axis {axis}; its lower corner must be below its upper corner"
    )]
    EmptyBox {
        /// The axis, from 0.
        axis: usize,
    },
    /// A point lies outside of the box.
    #[error("point {index} lies outside of the box; enlarge the box or drop the point")]
    OutsideBox {
        /// Position of the point.
        index: usize,
    },
    /// A radius is negative or not a number.
    #[error("a radius must be 0 or more")]
    Radius,
    /// An array of values does not fit the points.
    #[error(
        "there are {given} values for {points} points with {columns} values each; pass {columns} for each point"
    )]
    Values {
        /// Number of values.
        given: usize,
        /// Number of values of each point.
        columns: usize,
        /// Number of points.
        points: usize,
    },
    /// A list of cells has not one for each query.
    #[error("there are {given} cells for {queries} queries; pass one cell for each query")]
    Cells {
        /// Number of cells.
        given: usize,
        /// Number of queries.
        queries: usize,
    },
    /// There is no such cell.
    #[error("entry {at}: there is no cell {cell}; the triangulation has {cells}")]
    NoCell {
        /// Position in the list.
        at: usize,
        /// The number of the cell.
        cell: u32,
        /// Number of cells.
        cells: usize,
    },
}

impl QueryError {
    /// Returns the exit code of the program.
    pub fn code(&self) -> Code {
        match self {
            Self::EmptyBox { .. }
            | Self::Radius
            | Self::Values { .. }
            | Self::Cells { .. }
            | Self::NoCell { .. }
            | Self::OtherRun
            | Self::Flat { .. }
            | Self::OtherPoints { .. } => Code::Usage,
            Self::TooMany { .. } => Code::Limit,
            Self::Range(_) | Self::OutsideBox { .. } => Code::Input,
        }
    }

    /// Returns the row of the point that is the reason.
    pub fn row(&self) -> Option<u64> {
        match self {
            Self::Range(RangeError::NotFinite { index, .. } | RangeError::Spread { low: index, .. })
            | Self::OutsideBox { index } => Some(*index as u64),
            _ => None,
        }
    }
}
