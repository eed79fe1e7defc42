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

use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use crate::config::Repair;
use crate::machine::context::Context;
use crate::splaying::all_stars::{StepCharges, step};
use crate::splaying::messages::Proposal;
use crate::splaying::pass::{AllPoints, Passed, Start, most_rounds};
use crate::splaying::pending::Pending;
use crate::stars::check::{Agreement, Disagreement};
use crate::stars::look_up::LookUp;
use crate::stars::owned::Stars;
use crate::state::cells::{finite_cell, in_order};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// Runs steps until no star sends a message.
pub(crate) async fn splay<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    agreement: &Agreement,
    start: Start,
    all: AllPoints,
) -> Result<Passed, TransportError> {
    cx.enter(Phase::Repair)?;
    let leaves = subdomain.leaves();
    let (gathered, mut steps) = start.into_parts();
    let mut pending = Pending::new(gathered);
    if !(pending.is_empty() && agreement.disagreements().is_empty()) {
        stars.extract_links(table);
    }
    let mut found: Vec<_> = agreement.disagreements().iter().filter_map(|d| proposal(stars, d)).collect();
    let last = most_rounds(cx.config(), all.count);
    let mut rounds = 0;
    // All ranks step together, so they agree on the number of the round.
    for round in 1.. {
        steps += 1;
        if !(found.is_empty() && pending.is_empty()) {
            let has_messages = !pending.is_empty();
            let (mut output, mut charges) = step(cx, leaves, table, stars, &mut pending, Repair::Splay);
            if has_messages {
                keep_held(cx, leaves, stars, &mut found, &mut charges);
            }
            output.proposals.append(&mut found);
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
pub(super) fn proposal<P: Point>(stars: &Stars<P>, of: &Disagreement) -> Option<Proposal<P::Cell>> {
    let facet = stars.link(of.holder)[(of.facet - stars.start(of.holder)) as usize];
    let cell = finite_cell::<P>(of.holder, &facet)?;
    Some(Proposal { to: of.other, cell: in_order::<P>(&cell), from: of.holder })
}

/// Keeps the proposals of the last check whose cells their senders' stars still have.
fn keep_held<P: Point>(
    cx: &Context<P>,
    leaves: &[Leaf<P>],
    stars: &Stars<P>,
    found: &mut Vec<Proposal<P::Cell>>,
    charges: &mut StepCharges,
) {
    let meter = cx.own_cost();
    let look_up = LookUp::new(stars, found.iter().map(|proposal| proposal.from));
    found.retain(|proposal| {
        let (mut sweep, mut cost) = (Sweep::default(), meter.nested());
        sweep.visit_all(stars.link(proposal.from));
        cost.charge_sweep(sweep);
        charges.add_proposal(leaf_number(leaves, proposal.from), cost);
        look_up.position_in(proposal.from, &proposal.cell).is_some()
    });
}
