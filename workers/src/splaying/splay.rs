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
//! **Work and depth.** All stars perform their steps in parallel. [`crate::splaying::step`] states the cost of one
//! step.
//!
//! **Departure.** All stars step together, whether they are on one rank or on several. The messages of a step do not depend on
//! the owners of the stars. Work and depth are therefore independent of the number of ranks. One step takes one round.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::splaying::messages::{GatheredPoint, Objections, Proposal};
use crate::splaying::pending::{Pending, StepOutput};
use crate::splaying::step::{Splayed, StarStep, Tools};
use crate::stars::check::{Agreement, Disagreement};
use crate::stars::owned::{Stars, StarsView};
use crate::state::cells::{finite_cell, in_order};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// Number of stars that a thread processes in sequence.
const GROUP: usize = 512;

/// Runs steps until no star sends a message. Returns the last round in which this rank sent a message.
pub(crate) async fn splay<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    agreement: &Agreement,
    gathered: Vec<GatheredPoint>,
    population: u64,
) -> Result<u32, TransportError> {
    cx.enter(Phase::Repair)?;
    let leaves = subdomain.leaves();
    let mut pending = Pending::new(gathered);
    if !(pending.is_empty() && agreement.disagreements().is_empty()) {
        stars.extract_links(table);
    }
    let mut found: Vec<_> = agreement.disagreements().iter().filter_map(|d| proposal(stars, d)).collect();
    let last = cx.config().exchange_cap.unwrap_or(6 * (64 - population.max(2).leading_zeros()));
    let mut rounds = 0;
    // All ranks step together, so they agree on the number of the round.
    for round in 1.. {
        if !(found.is_empty() && pending.is_empty()) {
            let output = step(cx, leaves, table, stars, &mut pending, std::mem::take(&mut found));
            if !output.is_empty() && round <= last {
                rounds = round;
                if let Some(recorder) = cx.recorder() {
                    output.record(recorder, leaves, table, round);
                }
                output.send(cx, table, &mut pending, round);
            }
        }
        if !cx.exchange_if(!pending.is_empty()).await? {
            break;
        }
        pending.receive(cx, table, stars);
    }
    Ok(rounds)
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
) -> StepOutput<P> {
    let mut pending = std::mem::replace(pending, Pending::new(Vec::new()));
    stars.extend_hashes(table);
    pending.sort();
    let inboxes = pending.by_star();
    let groups: Vec<_> = inboxes.chunks(GROUP).collect();
    let view = StarsView::new(table, stars);
    let splayed = cx.map(&groups, |group| {
        let mut tools = Tools::new(table.positions().len());
        let mut out = Splayed::default();
        group.iter().for_each(|&inbox| StarStep::new(view, inbox, &mut tools, &mut out).run());
        out
    });
    charge(cx, leaves, splayed.iter().flat_map(Splayed::costs));
    let (mut proposals, mut objections) = (Vec::new(), Objections::default());
    for group in splayed {
        group.each_change(|vertex, change| stars.splay(table, vertex, change));
        proposals.extend(group.proposals);
        objections.append(group.objections);
    }
    if !groups.is_empty() {
        retain_present(cx, leaves, stars, &mut found);
    }
    proposals.extend(found);
    StepOutput { proposals, objections }
}

/// Keeps the proposals of cells that their senders' stars still have. Charges a comparison with every facet of a link.
fn retain_present<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    stars: &Stars<P>,
    found: &mut Vec<Proposal<P::Cell>>,
) {
    let mut costs = Vec::new();
    found.retain(|proposal| {
        let (mut sweep, mut cost) = (Sweep::default(), Cost::ZERO);
        sweep.visit_lanes(stars.link(proposal.from).len());
        cost.charge_nested_sweep(sweep);
        costs.push((proposal.from, cost));
        stars.position_in(proposal.from, &proposal.cell).is_some()
    });
    charge(cx, leaves, costs.into_iter());
}

/// Charges one vector step over stars to each leaf.
fn charge<P: Point>(cx: &mut Context<P>, leaves: &[Leaf<P>], costs: impl Iterator<Item = (u32, Cost)>) {
    let mut of_leaves: BTreeMap<u32, (Cost, u64)> = BTreeMap::new();
    for (vertex, cost) in costs {
        let entry = of_leaves.entry(leaf_number(leaves, vertex)).or_default();
        entry.0.join(cost);
        entry.1 += 1;
    }
    for (at, (cost, items)) in of_leaves {
        cx.charge(Account::member(Phase::Repair, leaves[at as usize].id()), cost, items);
    }
}
