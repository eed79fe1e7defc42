//! The counts of the workers of one of several processes, and their union.

use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::{CondensedLedger, Condensing, LedgerPart, PhaseSet};

use crate::spec::Fault;

/// The counts of the workers of one process.
#[derive(Clone, Debug)]
pub struct OwnCounts {
    /// The counts.
    pub ledger: LedgerPart,
    /// The roots of the subtrees of the partition tree that only one worker of this process charges.
    pub(crate) roots: Vec<NodeId>,
    /// Number of coordinates.
    pub(crate) space: usize,
    /// The planted fault.
    pub(crate) fault: Option<Fault>,
}

impl OwnCounts {
    /// Takes the counts, with sums in place of the rows of subtrees that only one worker charges. `phases` are those of all
    /// processes. If `keeps_nodes` is set, the facts of all nodes remain rows.
    pub fn condense(&mut self, phases: PhaseSet, keeps_nodes: bool) -> CondensedLedger {
        // The sets with own separators that one worker charges can be below the subtree of another.
        let needs_rows = phases.contains(Phase::OwnSets) || self.fault.is_some_and(Fault::needs_rows);
        let roots = if needs_rows { &[][..] } else { &self.roots };
        let condensing = Condensing { roots, phases, space: self.space, keeps_nodes };
        std::mem::take(&mut self.ledger).condense(&condensing)
    }
}
