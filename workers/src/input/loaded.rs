//! The description of an input after the ranks have prepared it.

use septet_protocol::message::{PointSum, SiteTotals, Survey};

/// The input as a rank knows it after it was prepared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loaded {
    /// The survey of all rows.
    pub survey: Survey,
    /// The distinct points of all ranks. Empty if the survey does not admit the rows.
    pub population: PointSum,
    /// Dimension of the affine hull of all points; -1 for no points.
    pub dimension: isize,
    /// The largest weight of all ranks, and the number of rows that are hidden under a heavier site at the same position.
    /// The default without weights.
    pub sites: SiteTotals,
    /// Rows of this rank with a coordinate or a weight that is not finite, ascending.
    pub refused: Vec<u64>,
    /// Rows of this rank that repeat a row, ascending, each with the row that stands for its coordinates: the first one, and
    /// with weights the first of the heaviest ones.
    pub repeated: Vec<[u64; 2]>,
    /// Rows of this rank that are hidden under a heavier site at the same position, ascending.
    pub hidden: Vec<u64>,
}
