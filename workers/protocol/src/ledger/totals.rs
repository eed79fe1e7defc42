//! The totals of a folded ledger.

use serde::{Deserialize, Serialize};

use crate::ids::{ByGroup, NodeId, Phase};

/// Totals of one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseTotal {
    /// The phase.
    pub phase: Phase,
    /// Rounds in which a rank sent messages.
    pub rounds: u64,
    /// Work over all subproblems.
    pub work: u64,
    /// Length of the longest chain of the phase alone; a scan counts 1.
    pub depth: u64,
    /// Length of that chain if a scan of `m` items counts `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Share of the phase in the critical path of the run.
    pub critical_depth: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
}

/// Work, depth and Brent's bound over a group of phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Total {
    /// Number of operations.
    pub work: u64,
    /// Longest chain of vector steps, with each scan counted as 1.
    pub depth: u64,
    /// Longest chain, with a scan of m items counted as `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Brent's bound on the steps with as many processors as points. A step is a phase at a level of the tree. The bound
    /// is the sum of `ceil((work - depth) / n) + depth` over all steps.
    pub brent: u64,
}

impl Total {
    /// Returns the total of two groups, one after the other.
    #[must_use]
    pub fn then(self, next: Total) -> Total {
        Total {
            work: self.work + next.work,
            depth: self.depth + next.depth,
            depth_log_scan: self.depth_log_scan + next.depth_log_scan,
            brent: self.brent + next.brent,
        }
    }
}

/// The totals of the groups whose phases count work.
pub type Totals = ByGroup<Total>;

impl Totals {
    /// Returns the total of all groups.
    pub fn sum(&self) -> Total {
        self.each().into_iter().fold(Total::default(), |sum, (_, total)| sum.then(*total))
    }
}

/// One step of the critical path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathStep {
    /// The subproblem.
    pub node: NodeId,
    /// The phase.
    pub phase: Phase,
    /// Depth of the phase at the subproblem.
    pub depth: u64,
}
