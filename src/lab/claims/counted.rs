//! The counts of one run: its line, and the facts and depths of the nodes of its tree.

use std::collections::BTreeMap;

use crate::experiment::{Line, of_run};
use septet_core::Outcome;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::{Ledger, NodeFacts};

use super::sample::Sample;

/// The counts of one run.
#[derive(Clone, Debug)]
pub(super) struct Counted {
    pub(super) line: Line,
    pub(super) nodes: Vec<NodeCounts>,
}

/// The facts of a node of the tree, and its depth in every phase.
#[derive(Clone, Debug)]
pub(super) struct NodeCounts {
    pub(super) level: u32,
    pub(super) facts: NodeFacts,
    pub(super) depth: BTreeMap<&'static str, u64>,
    /// The number of items of the node's charges in every phase.
    pub(super) items: BTreeMap<&'static str, u64>,
}

impl Counted {
    /// Returns the counts of a run over a sample.
    pub(super) fn of(sample: Sample, seed: u64, counts: &Outcome) -> Counted {
        Counted::of_line(sample, seed, of_run(counts), &counts.ledger)
    }

    /// Returns the counts of a run with this line and ledger.
    pub(super) fn of_line(sample: Sample, seed: u64, mut line: Line, ledger: &Ledger) -> Counted {
        (line.kind, line.asked, line.seed) = (sample.kind.name().to_string(), sample.n, seed);
        line.settings.lipschitz = sample.lipschitz;
        Counted { line, nodes: nodes(ledger) }
    }

    /// Returns log2 of the number of points.
    pub(super) fn log(&self) -> f64 {
        (self.line.n as f64).log2()
    }

    /// Returns Brent's bound with n processors: the sum of `T_n` over the groups of phases.
    pub(super) fn brent(&self) -> u64 {
        self.line.totals.each().into_iter().filter_map(|(_, row)| *row).map(|row| row.total.brent).sum()
    }

    /// Returns a sum over all nodes, divided by the number of points.
    pub(super) fn per_point(&self, of: impl Fn(&NodeCounts) -> u64) -> f64 {
        self.nodes.iter().map(of).sum::<u64>() as f64 / self.line.n as f64
    }

    /// Returns the nodes that were split.
    pub(super) fn splits(&self) -> impl Iterator<Item = &NodeCounts> {
        self.nodes.iter().filter(|node| !node.facts.is_leaf())
    }
}

impl NodeCounts {
    /// Returns the number of points whose balls meet the separator.
    pub(super) fn crossing(&self) -> u64 {
        self.facts.crossing_inside + self.facts.crossing_outside
    }
}

fn nodes(ledger: &Ledger) -> Vec<NodeCounts> {
    let node = |(id, facts): (&NodeId, &NodeFacts)| NodeCounts {
        level: id.level(),
        facts: *facts,
        depth: BTreeMap::new(),
        items: BTreeMap::new(),
    };
    let mut nodes: BTreeMap<NodeId, NodeCounts> =
        ledger.part.nodes.iter().map(|row| (*row.0, node(row))).collect();
    for phase in Phase::ALL {
        for (id, charge) in ledger.part.members(phase) {
            let Some(node) = nodes.get_mut(&id) else { continue };
            node.depth.insert(phase.name(), charge.cost.depth());
            node.items.insert(phase.name(), charge.items);
        }
    }
    nodes.into_values().collect()
}
