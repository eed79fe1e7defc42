//! Work and depth of a run, as the second account counts them.

/// Work and depth of a phase.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PhaseAccount {
    /// The name.
    pub phase: String,
    /// The sum of the work of its rows.
    pub work: u64,
    /// The depth of the longest path through its rows.
    pub depth: u64,
}

/// Work and depth of a group of phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TotalAccount {
    /// The sum of the work of its rows.
    pub work: u64,
    /// The depth of the longest path through its rows.
    pub depth: u64,
    /// Brent's bound with as many processors as points: `ceil((work - depth) / n) + depth`, summed over the phases and,
    /// within a phase, over its levels or steps.
    pub brent: u64,
}

/// The second account of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Accounts {
    /// Number of distinct points.
    pub points: u64,
    /// The seed of the run.
    pub seed: u64,
    /// The phases with rows, in their order.
    pub phases: Vec<PhaseAccount>,
    /// The phases of the paper.
    pub paper: TotalAccount,
    /// The phases of agreement and repair.
    pub repair: TotalAccount,
    /// The choice of the supergraph.
    pub selection: TotalAccount,
}
