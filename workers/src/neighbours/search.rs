//! Balls of owned points, and the parameters of a search with them.

use septet_protocol::ids::Phase;

/// The parameters of one search, equal on all ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Search {
    /// The phase to which the search is charged.
    pub(crate) phase: Phase,
    /// The number of nearest points to find. Points that tie with the last one are also kept.
    pub(crate) wanted: u32,
    /// Whether the balls probe (the punt): beyond each separator on the way to its own leaf, a ball visits one leaf
    /// only.
    pub(crate) probe: bool,
    /// Whether a ball also searches its own leaf.
    pub(crate) own_leaf: bool,
    /// Whether every ball visits every leaf: a planted fault.
    pub(crate) everywhere: bool,
}

impl Search {
    /// Returns `true` if a point at the centre counts. Otherwise, the centre is a point and not its own neighbour.
    pub(crate) fn finds_centre(self) -> bool {
        self.phase == Phase::ProbeCells
    }
}

/// The ball of an owned point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    /// The owned point.
    pub(crate) point: u32,
    /// The index of its leaf.
    pub(crate) leaf: usize,
    pub(crate) radius2: f64,
}
