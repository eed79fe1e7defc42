//! The description of an input after the ranks have prepared it.

use septet_protocol::message::{PointSum, Survey};

/// The input as a rank knows it after it was prepared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loaded {
    /// The survey of all rows.
    pub survey: Survey,
    /// The distinct points of all ranks. Empty if the survey does not admit the rows.
    pub population: PointSum,
    /// Dimension of the affine hull of all points; -1 for no points.
    pub dimension: isize,
    /// Rows of this rank with a coordinate that is not finite, ascending.
    pub refused: Vec<u64>,
    /// Rows of this rank that repeat an earlier row, ascending, each with the first row that has its coordinates.
    pub repeated: Vec<[u64; 2]>,
}
