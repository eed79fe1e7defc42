//! What a certificate lacks.

use thiserror::Error;

/// Why the stars do not form a triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{disagreements} disagreements, {minima} minima, {stars} of {points} stars")]
pub struct Refutation {
    /// Cells missing from stars.
    pub disagreements: u64,
    /// Vertices without a smaller neighbour (1 is right).
    pub minima: u64,
    /// Stars that hold a cell.
    pub stars: u64,
    /// Number of points.
    pub points: u64,
}
