//! Balls of home points, and what they look for.

use septet_protocol::ids::Phase;

/// What the balls of a phase look for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Ask {
    /// The phase, which is charged.
    pub(crate) phase: Phase,
    /// How many nearest points, ties included.
    pub(crate) wanted: u32,
    /// The punt: one leaf beyond each separator of the way home.
    pub(crate) probe: bool,
    /// Whether the ball's own leaf answers too.
    pub(crate) own_leaf: bool,
}

/// A ball of a home point.
#[derive(Clone, Debug)]
pub(crate) struct Ball {
    pub(crate) owned: u32,
    pub(crate) leaf: usize,
    pub(crate) radius2: f64,
}
