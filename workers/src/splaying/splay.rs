//! Stars that disagree exchange what they miss (star splaying).
//!
//! **Statement.** If a cell `t` of `star(v)` is missing from `star(a)`, `v` proposes it. Then `a` takes the vertices of `t`,
//! and holds `t`, or answers with those points of its link that conflict with `t`. A star proposes the cells that it
//! gained; of a cell that it lost, it sends the points that replaced it. Each exchange with any disagreement enlarges
//! some candidate set, so it ends; and if every vertex but the smallest has a smaller candidate, it ends in the
//! triangulation.
//!
//! **Source.** Shewchuk (2005); the end of the proof is in ARCHITECTURE.md.
//!
//! **Receivers.** Stars agree on a cell iff that of its smallest vertex agrees with each other's
//! ([`crate::stars::check`]). So a star tells the smallest vertex what it gains or loses, or if that is its own, the
//! others; but none that reported just that to it in the same step. Each of the two of such a pair then hears of every change
//! of the other. When no star says anything more, all stars agree.
//!
//! **After a gathering** the stars get its points. They also propose what the check found, as far as they still hold it.
//!
//! **Rounds.** None where the paper's hypothesis holds; about `0.6 log2 n` on uniform sets (measured).
//!
//! **Work and depth.** That of the reactions ([`crate::splaying::step`]), star beside star.
//!
//! **Departure.** All stars move in lockstep, those of one rank like those of two. What they exchange in a round does not
//! depend on where a star is at home, so work and depth do not depend on the number of ranks. A round of exchange is
//! one round of messages.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use crate::config::map_in;
use crate::machine::context::Context;
use crate::splaying::pending::{Announced, Announcements, Gathered, Proposal, Received};
use crate::splaying::step::{Splayed, Tools};
use crate::stars::check::{Agreement, Disagreement};
use crate::stars::owned::{Chart, Stars};
use crate::state::cells::{finite_cell, in_order};
use crate::state::subdomain::{Leaf, Subdomain, leaf_number};
use crate::state::table::Table;

/// Stars that are looked at one after the other.
const GROUP: usize = 512;

/// Rounds of exchange until no star says anything. Returns the last round in which this rank said something.
pub(crate) async fn splay<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    agreement: &Agreement,
    gathered: Vec<Gathered>,
    population: u64,
) -> Result<u32, TransportError> {
    cx.enter(Phase::Repair)?;
    let mut heard = Received::of(gathered);
    if heard.is_pending() || !agreement.disagreements.is_empty() {
        stars.write_out(table);
    }
    let mut found: Vec<_> = agreement.disagreements.iter().filter_map(|d| proposal(stars, d)).collect();
    let last = cx.config.exchange_cap.unwrap_or(6 * (64 - population.max(2).leading_zeros()));
    let mut rounds = 0;
    // All ranks step together, so the number of the round is the same on each.
    for round in 1.. {
        if !found.is_empty() || heard.is_pending() {
            let found = std::mem::take(&mut found);
            let (proposals, objections) = splay_all(cx, &subdomain.leaves, (table, stars), &mut heard, found);
            let speech = Announcements { proposals, objections, round };
            if !speech.is_empty() && round <= last {
                rounds = round;
                speech.tell(cx, &subdomain.leaves, table, &mut heard);
            }
        }
        if !cx.exchange_if(heard.is_pending()).await? {
            break;
        }
        heard.take(cx, table, stars);
    }
    Ok(rounds)
}

/// The proposal of a cell that another star lacks.
fn proposal<P: Point>(stars: &Stars<P>, of: &Disagreement) -> Option<Proposal<P>> {
    let facet = stars.link(of.owned)[(of.facet - stars.start(of.owned)) as usize];
    finite_cell::<P>(of.owned, &facet).map(|cell| (of.other, in_order::<P>(&cell), of.owned))
}

/// All stars that heard something take it in. Returns what they say: what has changed, and what the check found as far
/// as stars still hold it.
fn splay_all<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    (table, stars): (&Table<P>, &mut Stars<P>),
    heard: &mut Received<P>,
    mut found: Vec<Proposal<P>>,
) -> (Vec<Proposal<P>>, Announced<P>) {
    let mut heard = std::mem::replace(heard, Received::of(Vec::new()));
    stars.extend_hashes(table);
    heard.sort();
    let news = heard.star_by_star();
    let groups: Vec<_> = news.chunks(GROUP).collect();
    let (chart, points) = (Chart { table, stars }, heard.objected.points());
    let reactions = map_in(&cx.pool, &groups, |group| {
        let mut tools = Tools::new(table.positions.len());
        let mut out = Splayed::default();
        group.iter().for_each(|news| chart.splay_star(news, points, &mut tools, &mut out));
        out
    });
    charge(cx, leaves, reactions.iter().flat_map(Splayed::costs));
    let (mut proposals, mut objections) = (Vec::new(), Announced::default());
    for group in reactions {
        group.each_change(|owned, change| stars.change(table, owned, change));
        proposals.extend(group.proposals);
        objections.append(group.objections);
    }
    if !groups.is_empty() {
        retain_held(cx, leaves, stars, &mut found);
    }
    proposals.extend(found);
    (proposals, objections)
}

/// Leaves those proposals whose cells their stars hold still: each looks at every facet of its link.
fn retain_held<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    stars: &Stars<P>,
    found: &mut Vec<Proposal<P>>,
) {
    let mut costs = Vec::new();
    found.retain(|(_, cell, from)| {
        let (mut looks, mut cost) = (Sweep::default(), Cost::ZERO);
        looks.visit_lanes(stars.link(*from).len());
        cost.charge_nested_sweep(looks);
        costs.push((*from, cost));
        stars.position_in(*from, cell).is_some()
    });
    charge(cx, leaves, costs.into_iter());
}

/// Charges one vector step over stars, leaf by leaf.
fn charge<P: Point>(cx: &mut Context<P>, leaves: &[Leaf<P>], costs: impl Iterator<Item = (u32, Cost)>) {
    let mut of_leaves: BTreeMap<u32, (Cost, u64)> = BTreeMap::new();
    for (owned, cost) in costs {
        let entry = of_leaves.entry(leaf_number(leaves, owned)).or_default();
        entry.0.join(cost);
        entry.1 += 1;
    }
    for (at, (cost, items)) in of_leaves {
        cx.ledger.charge(Phase::Repair, leaves[at as usize].id, cost, items);
    }
}
