//! The counts of the baseline: steps along chains, and totals of rounds.

use crate::cost::Price;

/// Numbers of steps along a chain of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clock {
    /// Number of cells: the dependence depth.
    pub chain: u64,
    /// Vector steps, with each scan counted as 1.
    pub steps: u64,
    /// Vector steps, with a scan of `m` items counted as `ceil(log2 m)`.
    pub log_scan: u64,
    /// Number of vector steps if uniting conflicts took one step, as with a concurrent hash table. The EREW machine has
    /// no such table.
    pub hashed: u64,
}

impl Clock {
    pub(super) fn later(self, other: Clock) -> Clock {
        Clock {
            chain: self.chain.max(other.chain),
            steps: self.steps.max(other.steps),
            log_scan: self.log_scan.max(other.log_scan),
            hashed: self.hashed.max(other.hashed),
        }
    }

    /// Appends one cell to the chain: the cost of uniting its conflicts (`union`) and its other costs (`rest`).
    pub(super) fn then(self, union: Price, rest: Price) -> Clock {
        Clock {
            chain: self.chain + 1,
            steps: self.steps + union.depth() + rest.depth(),
            log_scan: self.log_scan + union.depth_log_scan(1) + rest.depth_log_scan(1),
            hashed: self.hashed + union.depth().min(1) + rest.depth(),
        }
    }
}

/// Counts of one round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Round {
    /// Number of ready facets.
    pub facets: u64,
    /// Number of cells created.
    pub cells: u64,
    /// Number of in-sphere tests, including those of infinite cells.
    pub tests: u64,
    /// Number of elementary operations.
    pub work: u64,
    /// Vector steps: those of the slowest cell, and those that all cells share.
    pub steps: u64,
}

impl Round {
    /// Adds a cost that is incurred in parallel to the cells so far.
    pub(super) fn charge(&mut self, cost: Price) {
        self.work += cost.work();
        self.steps = self.steps.max(cost.depth());
    }

    /// Adds the cost of steps that all cells of the round wait for.
    pub(super) fn charge_shared(&mut self, cost: Price) {
        self.work += cost.work();
        self.steps += cost.depth();
    }
}
