//! The machine that a time is predicted for.

use std::collections::BTreeMap;

use serde::Serialize;

/// The machine that a time is predicted for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hardware {
    /// Seconds from one rank to another.
    pub latency: f64,
    /// Seconds a rank spends on a message.
    pub overhead: f64,
    /// Bytes a second between two ranks.
    pub bandwidth: f64,
    /// Charged operations a second of one worker.
    pub rate: f64,
    /// The same by phase, where it was measured.
    pub phase_rates: BTreeMap<String, f64>,
    /// Seconds that no worker shares: reading, gathering the result.
    pub fixed: f64,
}

impl Default for Hardware {
    /// A cluster of today: 2 us and 10 GB/s between nodes, 1 us a message, 1e9 operations a second.
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
