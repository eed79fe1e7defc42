//! One pass: the steps between two certificates.

use crate::config::WorkerConfig;
use crate::splaying::messages::GatheredPoint;

/// The state of splaying at its start.
#[derive(Debug, Default)]
pub(crate) struct Start {
    /// The points that stars received from a gathering.
    gathered: Vec<GatheredPoint>,
    /// The number of steps of all earlier passes.
    steps: u32,
}

impl Start {
    /// Returns the start of a pass after a gathering and after `steps` steps of all earlier passes.
    pub(crate) fn after_gathering(gathered: Vec<GatheredPoint>, steps: u32) -> Self {
        Start { gathered, steps }
    }

    /// Returns the points that stars received, and the number of earlier steps.
    pub(super) fn into_parts(self) -> (Vec<GatheredPoint>, u32) {
        (self.gathered, self.steps)
    }
}

/// What splaying knows of the points of all ranks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AllPoints {
    /// Their number.
    pub(crate) count: u64,
    /// Their largest weight; 0 without weights.
    pub(crate) heaviest: f64,
}

/// The steps of one pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passed {
    /// The last round in which this rank sent a message.
    pub(crate) rounds: u32,
    /// The number of steps of this pass and all earlier ones.
    pub(crate) steps: u32,
}

/// Returns the number of rounds after which a pass ends without agreement.
pub(super) fn most_rounds(config: &WorkerConfig, population: u64) -> u32 {
    config.graph.exchange_cap.unwrap_or(6 * (64 - population.max(2).leading_zeros()))
}
