//! One step of all stars of a rank.
//!
//! **Statement.** Every star that has received messages processes them ([`crate::splaying::step`]). The stars do not read each
//! other, so the results do not depend on the order.
//!
//! **Work and depth.** The messages to the stars of a leaf are delivered, then all stars process theirs in parallel.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Lanes, Sweep};
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;

use crate::config::Repair;
use crate::machine::context::Context;
use crate::splaying::messages::Objections;
use crate::splaying::pending::{Pending, StarInbox, StepOutput};
use crate::splaying::step::{Splayed, StarStep, Tools};
use crate::stars::owned::{Stars, StarsView};
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// Number of stars that a thread processes in sequence.
const GROUP: usize = 512;

/// Processes the pending messages of each star. Returns the messages that result from the changes, by the rules of `repair`.
pub(super) fn step<P: Point>(
    cx: &Context<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
    stars: &mut Stars<P>,
    pending: &mut Pending<P>,
    repair: Repair,
) -> (StepOutput<P>, StepCharges) {
    let mut pending = std::mem::replace(pending, Pending::new(Vec::new()));
    stars.extend_hashes(table);
    pending.sort();
    let inboxes = pending.by_star();
    let groups: Vec<_> = inboxes.chunks(GROUP).collect();
    let view = StarsView::new(table, stars);
    let mut charges = StepCharges::new(cx.own_cost(), leaves.iter().map(Leaf::id).collect());
    for inbox in &inboxes {
        charges.deliver(leaf_number(leaves, inbox.vertex), inbox);
    }
    let meter = cx.own_cost();
    let mut splayed = cx.map(&groups, |group| {
        let mut tools = Tools::new(table.positions().len(), meter.fresh(), repair);
        let mut out = Splayed::default();
        group.iter().for_each(|&inbox| StarStep::new(view, inbox, &mut tools, &mut out).run());
        out
    });
    for (vertex, cost) in splayed.iter_mut().flat_map(Splayed::take_costs) {
        charges.add_star(leaf_number(leaves, vertex), cost);
    }
    let count = splayed.iter().map(|group| group.proposals.len()).sum();
    let (mut proposals, mut objections) = (Vec::with_capacity(count), Objections::default());
    for group in splayed {
        group.each_change(|vertex, change| stars.splay(table, vertex, change));
        proposals.extend(group.proposals);
        objections.append(group.objections);
    }
    (StepOutput { proposals, objections }, charges)
}

/// The cost of one step in each leaf: the delivery of messages, then the stars in parallel, then the proposals of the last
/// check in parallel. A star looks up the cell of such a proposal in its link.
pub(super) struct StepCharges {
    /// An empty meter.
    meter: Cost,
    leaves: Vec<NodeId>,
    of_leaves: BTreeMap<u32, LeafStep>,
}

/// The cost of one step in one leaf.
struct LeafStep {
    /// The messages to its stars, and the witnesses of the objections among them.
    delivered: Sweep,
    stars: Lanes,
    proposals: Lanes,
}

impl StepCharges {
    pub(super) fn new(meter: Cost, leaves: Vec<NodeId>) -> Self {
        StepCharges { meter, leaves, of_leaves: BTreeMap::new() }
    }

    /// Returns the cost of the leaf with this index, so that the caller can add to it.
    fn of_leaf(&mut self, leaf: u32) -> &mut LeafStep {
        let lanes = || self.meter.lanes();
        self.of_leaves.entry(leaf).or_insert_with(|| LeafStep {
            delivered: Sweep::default(),
            stars: lanes(),
            proposals: lanes(),
        })
    }

    /// Counts the messages to a star of a leaf.
    pub(super) fn deliver<P: Point>(&mut self, leaf: u32, inbox: &StarInbox<'_, P>) {
        let delivered = &mut self.of_leaf(leaf).delivered;
        delivered.visit_all(inbox.proposals);
        delivered.visit_all(inbox.gathered);
        delivered.visit_all(inbox.answers);
        for objection in delivered.visit_all(inbox.objections) {
            delivered.visit_all(inbox.witnesses(objection));
        }
    }

    /// Adds the cost of a star of a leaf.
    fn add_star(&mut self, leaf: u32, cost: Cost) {
        self.of_leaf(leaf).stars.add(cost);
    }

    /// Adds the cost of looking up the cell of a proposal.
    pub(super) fn add_proposal(&mut self, leaf: u32, cost: Cost) {
        self.of_leaf(leaf).proposals.add(cost);
    }

    /// Charges step number `step` of the phase.
    pub(super) fn enter<P: Point>(self, cx: &mut Context<P>, step: u32) {
        for (leaf, LeafStep { delivered, stars, proposals }) in self.of_leaves {
            let mut cost = self.meter.fresh();
            cost.charge_delivery(delivered);
            cost.run_lanes(stars);
            cost.run_lanes(proposals);
            cx.charge(
                Account::step(Phase::Repair, step, self.leaves[leaf as usize]),
                cost,
                delivered.items(),
            );
        }
    }
}
