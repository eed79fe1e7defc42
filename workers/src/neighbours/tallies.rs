//! What a descent of balls costs at each node.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::ids::NodeId;
use septet_protocol::ledger::LedgerPart;

use crate::neighbours::walk::{Counts, Visits};
use crate::state::subdomain::Subdomain;

/// Balls by the nodes that they visited.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tallies {
    inner: BTreeMap<NodeId, Visits>,
    /// Of each leaf, the pairs of balls and points.
    pairs: BTreeMap<NodeId, Sweep>,
}

/// What one node is charged: cost and items.
pub(crate) struct Charge {
    pub(crate) node: NodeId,
    pub(crate) cost: Cost,
    pub(crate) items: u64,
}

impl Tallies {
    /// Counts a ball at an inner node, from which it goes to both sides or not.
    pub(crate) fn visit(&mut self, node: NodeId, both: bool) {
        self.inner.entry(node).or_default().visit(both);
    }

    /// Adds what a walk counted; enters the visits of leaves in the ledger.
    pub(crate) fn add<P: Point>(
        &mut self,
        subdomain: &Subdomain<P>,
        counts: &Counts,
        ledger: &mut LedgerPart,
    ) {
        let shared = subdomain.path.iter().map(|shared| shared.id).zip(&counts.shared);
        let local = subdomain.inner_ids.iter().copied().zip(&counts.local);
        for (node, visits) in shared.chain(local) {
            if visits.down.items() > 0 {
                self.inner.entry(node).or_default().join(visits);
            }
        }
        for (leaf, counted) in subdomain.leaves.iter().zip(&counts.at_leaf) {
            if counted.visits > 0 {
                self.pairs.entry(leaf.id).or_default().join(&counted.pairs);
                ledger.facts(leaf.id).visits += counted.visits;
            }
        }
    }

    /// Charges each node in a pass of the bottom-up correction, by the pass of that level.
    pub(crate) fn charge_pass(self, ledger: &mut LedgerPart, level: u32) {
        for Charge { node, cost, items } in self.into_charges() {
            ledger.charge_correction(level, node, cost, items);
        }
    }

    /// What each node is charged.
    pub(crate) fn into_charges(self) -> impl Iterator<Item = Charge> {
        let inner = self.inner.into_iter().map(|(node, Visits { down, both })| {
            let (mut cost, items) = (Cost::ZERO, down.items());
            cost.charge_sweep(down);
            cost.charge_sweep(both);
            Charge { node, cost, items }
        });
        let leaves = self.pairs.into_iter().map(|(node, pairs)| {
            let (mut cost, items) = (Cost::ZERO, pairs.items());
            cost.charge_sweep(pairs);
            Charge { node, cost, items }
        });
        inner.chain(leaves)
    }
}
