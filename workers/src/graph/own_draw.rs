//! The draw of a set's own separator, and the decision on it.
//!
//! **Statement** (paper, Section 4.3, step 2). The separator of a set is drawn from samples of the set, copies included. It
//! divides the set if it keeps three bounds for the set:
//! 1. Each side has at most `(d+1)/(d+2) + 0.05` of the members ([`septet_geometry::separator::split_bound`]).
//! 2. At most `CROSSINGS w m^(1-1/d)` of the `m` members have balls that meet the separator. `w` is `alpha`, times
//!    `k^(1/d)` if the balls extend to the k-th neighbour.
//! 3. Neither child has more than 93 % of the members. Otherwise the recursion might not end.
//!
//! If bound 1 or 2 fails, another separator is drawn. If bound 3 fails, or all draws fail, the set is not divided.
//!
//! **Departure.** The paper has no bound 3, because its constants hide that most balls of a small set meet every sphere.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_geometry::separator::DrawKey;
use septet_protocol::ids::NodeId;
use septet_protocol::message::{Child, Decision};

use crate::graph::own_steps::OwnStep;
use crate::graph::sharing::shrinks;
use crate::machine::context::Context;
use crate::machine::group_tree::Gathered;
use crate::partition::leader::{
    Draw, DrawOf, MAX_ATTEMPTS, acceptable, divide, draw_from, is_leaf, refused, separator_of, words_of,
};
use crate::partition::parts::{Samples, Words};
use crate::state::subdomain::Group;

/// The constant of the bound on the members whose balls meet a separator.
const CROSSINGS: f64 = 4.0;

/// An attempt to divide a set.
#[derive(Clone, Copy)]
pub(super) struct Attempt {
    pub(super) node: NodeId,
    /// The number of members of the set, on all ranks.
    pub(super) members: u64,
    pub(super) number: u32,
}

/// The decision on an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The separator divides the set. The children have these numbers of members.
    Divide([u64; 2]),
    Retry,
    /// The set is not divided.
    Leaf,
}

/// Returns the attempts at a set, in order. There are none if the set is small enough to be a leaf.
pub(super) fn attempts<P: Point>(
    cx: &Context<P>,
    node: NodeId,
    members: u64,
) -> impl Iterator<Item = Attempt> + use<P> {
    let most = if is_leaf(cx.config(), node, members) { 0 } else { MAX_ATTEMPTS };
    (0..most).map(move |number| Attempt { node, members, number })
}

/// Selects the samples among some members of a set.
pub(super) fn samples<P: Point>(cx: &mut Context<P>, attempt: Attempt, positions: &[P]) -> Samples<P> {
    let key = DrawKey { seed: cx.config().seed, node: attempt.node.0, attempt: attempt.number };
    let sampler = cx.config().sampler(key, attempt.members);
    let mut cost = cx.shared_cost();
    let samples = cost.pack(positions, |&x| sampler.accepts(x));
    cx.charge(OwnStep::Sample(attempt.number).account(attempt.node), cost, positions.len() as u64);
    Samples(samples)
}

/// Draws a separator from the samples of a set. Returns its words, of which there are none without a separator.
pub(super) fn draw<P: Point>(
    cx: &mut Context<P>,
    attempt: Attempt,
    Samples(mut samples): Samples<P>,
) -> Words {
    let Attempt { node, members, number } = attempt;
    let mut cost = cx.shared_cost();
    let gathered = samples.len() as u64;
    // Sets have copies beyond their parent's cube, so every set has a curve of its own.
    let next = DrawOf { node, attempt: number, population: members, curve: None };
    let drawn: Draw<P> = draw_from(cx.config(), next, &mut samples, &mut cost);
    cx.charge(OwnStep::Draw(number).account(node), cost, gathered);
    Words(words_of(&drawn))
}

/// Draws a separator from the samples that a leader gathered.
pub(super) fn draw_gathered<P: Point>(
    cx: &mut Context<P>,
    attempt: Attempt,
    gathered: Option<Gathered<Samples<P>>>,
) -> Option<Words> {
    gathered.map(|Gathered { value, .. }| draw(cx, attempt, value))
}

/// Returns the separator with these words, if there is one.
pub(super) fn separator<P: Point>(Words(words): &Words) -> Option<septet_geometry::separator::Separator<P>> {
    separator_of(words)
}

/// Decides on a separator from the numbers of interior members, exterior members, crossing interior members and crossing
/// exterior members; `None` if no separator was drawn.
pub(super) fn decide<P: Point>(
    cx: &Context<P>,
    supergraph: Supergraph,
    attempt: Attempt,
    counts: Option<[u64; 4]>,
) -> Verdict {
    let Some([inside, outside, crossing_inside, crossing_outside]) = counts else { return Verdict::Leaf };
    let good = !refused(cx.config(), attempt.node, attempt.number)
        && acceptable::<P>(cx.config(), inside, outside)
        && (crossing_inside + crossing_outside) as f64 <= most_crossings::<P>(supergraph, attempt.members);
    let children = [inside + crossing_outside, outside + crossing_inside];
    if !good && attempt.number + 1 < MAX_ATTEMPTS {
        Verdict::Retry
    } else if good && shrinks(children, attempt.members) {
        Verdict::Divide(children)
    } else {
        Verdict::Leaf
    }
}

/// Returns the largest admissible number of members whose balls meet the separator of a set.
fn most_crossings<P: Point>(supergraph: Supergraph, members: u64) -> f64 {
    let share = 1.0 / P::DIM as f64;
    let alpha = match supergraph {
        Supergraph::Density { alpha } | Supergraph::Overlap { alpha, .. } => alpha,
        Supergraph::Knn { .. } => 1.0,
    };
    let width = alpha * f64::from(supergraph.ball_order()).powf(share);
    CROSSINGS * width * (members as f64).powf(1.0 - share)
}

/// Places a decision of a leader: divides the ranks of the group between the children, in proportion to their members.
pub(super) fn placed<P: Point>(cx: &Context<P>, group: &Group, verdict: Verdict) -> Decision {
    if cx.config().fault.is_some_and(|fault| fault.refuses(group.node)) {
        return Decision::Leaf;
    }
    let members = match verdict {
        Verdict::Retry => return Decision::Retry,
        Verdict::Leaf => return Decision::Leaf,
        Verdict::Divide(members) => members,
    };
    let Child { first, ranks, .. } = group.child;
    let interior = divide(ranks, members);
    let child = |side: usize, first, ranks| Child {
        population: members[side],
        first,
        ranks,
        leaf: is_leaf(cx.config(), group.node.child(side), members[side]),
    };
    Decision::Split([child(0, first, interior), child(1, first + interior, ranks - interior)])
}
