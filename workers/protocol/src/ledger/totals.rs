//! The totals of a folded ledger.

use crate::ids::{NodeId, Phase};

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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Total {
    /// Work.
    pub work: u64,
    /// Depth; a scan counts 1.
    pub depth: u64,
    /// Depth if a scan of `m` items counts `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Brent's bound on the time with `n` processors. A step is a phase at a level of the tree. The bound is the sum
    /// of `ceil((work - depth) / n) + depth` over all steps.
    pub brent: u64,
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
