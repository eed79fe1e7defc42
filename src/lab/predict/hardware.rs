//! The hardware of a predicted machine.

use std::collections::BTreeMap;

use septet_protocol::ids::Phase;
use serde::Serialize;

/// The hardware of a predicted machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Hardware {
    /// Seconds that a message takes from one rank to another, without the time for its bytes.
    pub latency: f64,
    /// Seconds that a rank spends on each message.
    pub overhead: f64,
    /// Bytes per second between two ranks.
    pub bandwidth: f64,
    /// Charged operations per second of one worker.
    pub rate: f64,
    /// Charged operations per second by phase, if measured.
    pub phase_rates: BTreeMap<String, f64>,
    /// Seconds that do not depend on the number of workers: the phases without charged work. They are
    /// measured with one worker, so they are too long for larger numbers of workers, which read their blocks in parallel.
    pub fixed: f64,
}

impl Default for Hardware {
    /// Returns typical values for a current cluster: a latency of 2 us and 10 GB/s between nodes, an overhead of 1 us
    /// per message, and 1e9 operations per second.
    fn default() -> Self {
        Hardware {
            latency: 2e-6,
            overhead: 1e-6,
            bandwidth: 1e10,
            rate: 1e9,
            phase_rates: BTreeMap::new(),
            fixed: 0.0,
        }
    }
}

impl Hardware {
    /// Returns the charged operations per second of one worker in a phase.
    pub(super) fn rate_of(&self, phase: Phase) -> f64 {
        self.phase_rates.get(phase.name()).copied().unwrap_or(self.rate)
    }
}
