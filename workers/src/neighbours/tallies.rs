//! The cost of a descent of balls at each node.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;

use crate::machine::context::Context;
use crate::neighbours::stages::March;
use crate::neighbours::walk::{BallCounts, Visits};

/// The balls that visited each node.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tallies {
    inner: BTreeMap<NodeId, Visits>,
    /// For each leaf, the pairs of a ball and a point.
    pairs: BTreeMap<NodeId, Sweep>,
}

/// The charge of one node.
pub(crate) struct NodeCharge {
    pub(crate) node: NodeId,
    pub(crate) cost: Cost,
    pub(crate) items: u64,
}

impl Tallies {
    /// Counts a ball at an inner node. `both` is `true` if it continues to both children.
    pub(crate) fn visit(&mut self, node: NodeId, both: bool) {
        self.inner.entry(node).or_default().visit(both);
    }

    /// Adds the counts of a walk of balls in `phase`, and enters the visits of leaves in the ledger. The visits of cells count in
    /// their round.
    pub(crate) fn add<P: Point>(&mut self, cx: &mut Context<P>, phase: Phase, counts: &BallCounts) {
        for (node, visits) in &counts.inner {
            self.inner.entry(*node).or_default().join(visits);
        }
        for (leaf, counted) in &counts.leaves {
            self.pairs.entry(*leaf).or_default().join(&counted.pairs);
            if phase == Phase::ProbeCells {
                let round = cx.round();
                cx.tally(round).probe_visits += counted.visits;
            } else {
                cx.facts(*leaf).visits += counted.visits;
            }
        }
    }

    /// Charges each node for the pass of the bottom-up correction at `level`. A node within a block has a charge of zero,
    /// which connects those above and below.
    pub(crate) fn charge_pass<P: Point>(mut self, cx: &mut Context<P>, level: u32, march: March) {
        let meter = cx.shared_cost();
        for (node, visits) in std::mem::take(&mut self.inner) {
            let cost = march.charge(&meter, (level, node), visits);
            cx.charge(Account::pass(level, node), cost, visits.down.items());
        }
        for NodeCharge { node, cost, items } in self.into_charges(meter, 1) {
            cx.charge(Account::pass(level, node), cost, items);
        }
    }

    /// Charges each node for step number `step` of cells that ask. Each level of the tree is a step of its own.
    pub(crate) fn charge_cells<P: Point>(self, cx: &mut Context<P>, step: u32) {
        for NodeCharge { node, cost, items } in self.into_charges(cx.shared_cost(), 1) {
            cx.charge(Account::step(Phase::ProbeCells, step + node.level(), node), cost, items);
        }
    }

    /// Returns the charge of each node. `meter` is an empty meter, and `wanted` the number of points that each ball
    /// searches for.
    ///
    /// At an inner node, the balls are replicated to the children on the way down, and the results of the replicas are
    /// combined on the way up, list by list if there are lists. At a leaf, each ball is tested against each point.
    pub(crate) fn into_charges(self, meter: Cost, wanted: u32) -> impl Iterator<Item = NodeCharge> {
        let own = meter.nested();
        let inner = self.inner.into_iter().map(move |(node, Visits { down, both })| {
            let (mut cost, items) = (meter.fresh(), down.items());
            cost.charge_replication(down);
            cost.charge_combination(both);
            cost.charge_list_merges(both, wanted);
            NodeCharge { node, cost, items }
        });
        let leaves = self.pairs.into_iter().map(move |(node, pairs)| {
            let (mut cost, items) = (own.fresh(), pairs.items());
            cost.charge_pairs(pairs);
            cost.charge_lists(pairs, wanted as usize);
            NodeCharge { node, cost, items }
        });
        inner.chain(leaves)
    }
}
