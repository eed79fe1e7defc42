//! Reasons against a certificate.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The reasons why the stars do not form a triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error, Serialize, Deserialize)]
#[non_exhaustive]
#[error("{disagreements} disagreements, {minima} minima, {stars} of {points} stars{}", owned(*.foreign))]
pub struct Refutation {
    /// Number of cells missing from a star.
    pub disagreements: u64,
    /// Vertices without a smaller neighbour; 1 in a triangulation.
    pub minima: u64,
    /// Number of stars that hold a cell.
    pub stars: u64,
    /// Number of points.
    pub points: u64,
    /// Whether the points of the stars are not those of the input.
    pub foreign: bool,
}

fn owned(foreign: bool) -> &'static str {
    if foreign { ", of points that are not those of the input" } else { "" }
}
