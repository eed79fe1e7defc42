//! Star splaying: stars that disagree exchange cells until they agree.
//!
//! **Statement.** The stars of all points run in steps. The *candidates* of a star are all points that it has received; a star
//! with a link is the local hull of its candidates.
//! 1. If star(v) has a cell t that star(a) lacks, v *proposes* t to a. Then a adds the vertices of t to its candidates. If
//!    star(a) still lacks t, a *objects*: it returns the points of its link that conflict with t.
//! 2. A star proposes each cell that it gained. It objects to each cell that it lost, with the points of its link that conflict
//!    with it.
//! 3. A star that has a cell to which another star objects adds the returned points to its candidates.
//!
//! With these rules, the steps end ([`crate::splaying`] has the proofs). If every vertex except the smallest has a
//! lexicographically smaller candidate, they end in the Delaunay triangulation.
//!
//! **Source.** Shewchuk, "Star splaying: an algorithm for repairing Delaunay triangulations and convex hulls" (2005).
//!
//! **Receivers.** All stars agree on a cell if and only if the star of its smallest vertex agrees with the star of
//! each other vertex. Therefore a star reports a gained or lost cell only to the smallest vertex of the cell or, if
//! its own vertex is the smallest, to all other vertices. It skips stars that sent it the same report in the same
//! step. If no star sends a message before the limit of rounds is reached, all stars agree.
//!
//! **After gathering.** The stars receive the gathered points as candidates. They also propose the cells of the last check that
//! they still have.
//!
//! **Rounds.** None if the paper's hypothesis holds; about `0.6 log2 n` on uniform sets (measured). After `6 log2 n` rounds,
//! rank 0 gathers the open regions ([`crate::splaying::fallback`]). This limits time; correctness does not depend on it.
//!
//! **Work and depth.** In each step, the messages to the stars of a leaf are delivered, and all stars process theirs in
//! parallel ([`crate::splaying::step`] states the cost for one star). A step starts when the previous step has ended at
//! every leaf, so the depth is the sum over all steps of the largest depth of a leaf.
//!
//! **Departure.** All stars step together, whether they are on one rank or on several. The messages of a step do not depend on
//! the owners of the stars. Work and depth are therefore independent of the number of ranks. One step takes one round.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Lanes, Sweep};
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::splaying::messages::{GatheredPoint, Objections, Proposal};
use crate::splaying::pending::{Pending, StarInbox, StepOutput};
use crate::splaying::step::{Splayed, StarStep, Tools};
use crate::stars::check::{Agreement, Disagreement};
use crate::stars::look_up::LookUp;
use crate::stars::owned::{Stars, StarsView};
use crate::state::cells::{finite_cell, in_order};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// Number of stars that a thread processes in sequence.
const GROUP: usize = 512;

/// The state of splaying at its start.
#[derive(Debug, Default)]
pub(crate) struct Start {
    /// The points that stars received from a gathering.
    gathered: Vec<GatheredPoint>,
    /// The number of steps of all earlier passes.
    steps: u32,
}

impl Start {
    /// Returns the start of a pass after a gathering and after `steps` steps of all earlier passes.
    pub(crate) fn after_gathering(gathered: Vec<GatheredPoint>, steps: u32) -> Self {
        Start { gathered, steps }
    }
}

/// The steps of one pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passed {
    /// The last round in which this rank sent a message.
    pub(crate) rounds: u32,
    /// The number of steps of this pass and all earlier ones.
    pub(crate) steps: u32,
}

/// Runs steps until no star sends a message.
pub(crate) async fn splay<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    agreement: &Agreement,
    start: Start,
    population: u64,
) -> Result<Passed, TransportError> {
    cx.enter(Phase::Repair)?;
    let leaves = subdomain.leaves();
    let mut steps = start.steps;
    let mut pending = Pending::new(start.gathered);
    if !(pending.is_empty() && agreement.disagreements().is_empty()) {
        stars.extract_links(table);
    }
    let mut found: Vec<_> = agreement.disagreements().iter().filter_map(|d| proposal(stars, d)).collect();
    let last = cx.config().graph.exchange_cap.unwrap_or(6 * (64 - population.max(2).leading_zeros()));
    let mut rounds = 0;
    // All ranks step together, so they agree on the number of the round.
    for round in 1.. {
        steps += 1;
        if !(found.is_empty() && pending.is_empty()) {
            let (output, charges) = step(cx, leaves, table, stars, &mut pending, std::mem::take(&mut found));
            charges.enter(cx, steps);
            if !output.is_empty() && round <= last {
                rounds = round;
                output.send(cx, table, &mut pending, round);
            }
        }
        if !cx.exchange_if(!pending.is_empty()).await? {
            break;
        }
        pending.receive(cx, table, stars);
    }
    Ok(Passed { rounds, steps })
}

/// Returns the proposal of a cell that another star lacks.
fn proposal<P: Point>(stars: &Stars<P>, of: &Disagreement) -> Option<Proposal<P::Cell>> {
    let facet = stars.link(of.holder)[(of.facet - stars.start(of.holder)) as usize];
    let cell = finite_cell::<P>(of.holder, &facet)?;
    Some(Proposal { to: of.other, cell: in_order::<P>(&cell), from: of.holder })
}

/// Processes the pending messages of each star. Returns the messages that result from the changes, and the proposals
/// in `found` whose cells their senders' stars still have.
fn step<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
    stars: &mut Stars<P>,
    pending: &mut Pending<P>,
    mut found: Vec<Proposal<P::Cell>>,
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
        let mut tools = Tools::new(table.positions().len(), meter.fresh());
        let mut out = Splayed::default();
        group.iter().for_each(|&inbox| StarStep::new(view, inbox, &mut tools, &mut out).run());
        out
    });
    for (vertex, cost) in splayed.iter_mut().flat_map(Splayed::take_costs) {
        charges.add_star(leaf_number(leaves, vertex), cost);
    }
    let (mut proposals, mut objections) = (Vec::new(), Objections::default());
    for group in splayed {
        group.each_change(|vertex, change| stars.splay(table, vertex, change));
        proposals.extend(group.proposals);
        objections.append(group.objections);
    }
    if !groups.is_empty() {
        let look_up = LookUp::new(stars, found.iter().map(|proposal| proposal.from));
        found.retain(|proposal| {
            let (mut sweep, mut cost) = (Sweep::default(), meter.nested());
            sweep.visit_all(stars.link(proposal.from));
            cost.charge_sweep(sweep);
            charges.add_proposal(leaf_number(leaves, proposal.from), cost);
            look_up.position_in(proposal.from, &proposal.cell).is_some()
        });
    }
    proposals.extend(found);
    (StepOutput { proposals, objections }, charges)
}

/// The cost of one step in each leaf: the delivery of messages, then the stars in parallel, then the proposals of the last
/// check in parallel. A star looks up the cell of such a proposal in its link.
struct StepCharges {
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
    fn new(meter: Cost, leaves: Vec<NodeId>) -> Self {
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
    fn deliver<P: Point>(&mut self, leaf: u32, inbox: &StarInbox<'_, P>) {
        let delivered = &mut self.of_leaf(leaf).delivered;
        delivered.visit_all(inbox.proposals);
        delivered.visit_all(inbox.gathered);
        for objection in delivered.visit_all(inbox.objections) {
            delivered.visit_all(inbox.witnesses(objection));
        }
    }

    /// Adds the cost of a star of a leaf.
    fn add_star(&mut self, leaf: u32, cost: Cost) {
        self.of_leaf(leaf).stars.add(cost);
    }

    /// Adds the cost of looking up the cell of a proposal.
    fn add_proposal(&mut self, leaf: u32, cost: Cost) {
        self.of_leaf(leaf).proposals.add(cost);
    }

    /// Charges step number `step` of the phase.
    fn enter<P: Point>(self, cx: &mut Context<P>, step: u32) {
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
