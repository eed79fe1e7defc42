//! The goal of an improvement, and its result.

use super::change::Kind;
use crate::conformity::Follow;

/// The goal of an improvement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Cells with an angle below this, or above its supplement, in degrees, are improved.
    pub angle: f64,
    /// The radius-edge ratio that cells may reach.
    pub ratio: f64,
    /// The largest number of rounds.
    pub sweeps: u32,
    /// Whether the boundary is fixed, including points in facets.
    pub fixed: bool,
    /// The requirements for a remeshed boundary. `None` for an exact boundary.
    pub follow: Option<Follow>,
}

impl Default for Target {
    fn default() -> Self {
        Target { angle: 16.0, ratio: 2.0, sweeps: 100, fixed: false, follow: None }
    }
}

/// The result of an improvement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Improved {
    /// The number of bad cells before and after.
    pub bad: [u64; 2],
    /// The number of times that a vertex moved.
    pub moved: u64,
    /// The number of edges and faces that were replaced.
    pub flipped: u64,
    /// The number of cells that were removed at a remeshed boundary.
    pub peeled: u64,
    /// The number of vertices that were inserted.
    pub inserted: u64,
    /// The number of vertices that were merged with others.
    pub merged: u64,
    /// The number of rounds.
    pub sweeps: u32,
}

impl Improved {
    /// Returns the number of changes.
    pub fn changes(&self) -> u64 {
        self.moved + self.flipped + self.peeled + self.inserted + self.merged
    }

    pub(super) fn count(&mut self, kind: Kind) {
        match kind {
            Kind::Move => self.moved += 1,
            Kind::Flip => self.flipped += 1,
            Kind::Peel => self.peeled += 1,
            Kind::Insert => self.inserted += 1,
            Kind::Merge => self.merged += 1,
        }
    }
}
