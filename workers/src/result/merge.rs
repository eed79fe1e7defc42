//! The merged triangulation: results up the tree, node by node.
//!
//! **Statement.** A cell belongs to its lexicographically smallest vertex, so the union of the leaves' cells has none
//! twice. Each subproblem's merged result goes up the tree: counts and the certificate's clauses. Rank 0 judges the
//! result of the root. The cells themselves travel once ([`crate::result::collect`]).
//!
//! **Rounds.** One for each level of shared nodes, and one for the verdict.
//!
//! **Work and depth.** One vector step over all link facets; O(1) for each node.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::graph::Supergraph;
use septet_geometry::measure::Diameters;
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Merged, Message};
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::config::map_in;
use crate::coordinator::judge;
use crate::direct::subdomain_triangulation::SubdomainTriangulation;
pub use crate::direct::subdomain_triangulation::{HULL, SEAM};
use crate::machine::collectives::{Reduction, Rising};
use crate::machine::context::Context;
use crate::stars::check::Agreement;
use crate::stars::owned::Chart;
use crate::state::cells::{Smallest, smallest_of};
use crate::state::subdomain::{Group, Subdomain, Tree, owned_groups};

/// What a rank has in the end, to be read by several cores.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Results<'a, P: Point> {
    pub(crate) subdomain: &'a Subdomain<P>,
    pub(crate) chart: Chart<'a, P>,
    pub(crate) supergraph: Supergraph,
}

/// A pass of splaying and certificate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pass {
    /// The number of the pass, from 0.
    pub(crate) number: u32,
    /// The last round of splaying in which this rank sent something.
    pub(crate) rounds: u32,
    /// Number of points of all ranks.
    pub(crate) population: u64,
}

impl Pass {
    /// The phase whose account pays for merging: after a gathering the certificate, which the paper does not have.
    fn payer(self) -> Phase {
        if self.number > 0 { Phase::Certificate } else { Phase::Merge }
    }
}

/// The cells that belong to this rank.
#[derive(Debug, Default)]
pub(crate) struct OwnedCells {
    /// Their number.
    pub(crate) cells: u64,
    /// For each home point a bit for each of its first 64 facets, set where the cell belongs to it; empty for a piece.
    pub(crate) facets: Vec<u64>,
}

/// The outcome of merging.
#[derive(Debug)]
pub(crate) struct MergedResult {
    /// The decision of the coordinator.
    pub(crate) outcome: Outcome,
    /// The cells that belong to this rank.
    pub(crate) cells_here: OwnedCells,
    /// The merged result of all ranks, on the coordinator; empty on every other rank.
    pub(crate) whole: Merged,
}

/// Merges the results of all ranks. The coordinator decides on the merged result and broadcasts its decision.
pub(crate) async fn merge<P: Point>(
    cx: &mut Context<P>,
    results: Results<'_, P>,
    agreement: &Agreement,
    pass: Pass,
) -> Result<MergedResult, TransportError> {
    cx.enter(Phase::Merge)?;
    let subdomain = results.subdomain;
    let mut cells_here = OwnedCells::default();
    let leaves = match results.chart.stars.piece().map(SubdomainTriangulation::merged) {
        Some(own) => vec![own],
        None => merge_leaves(cx, results, pass, &mut cells_here.facets),
    };
    if let Some((root, mut own)) = merge_subtree(cx, subdomain, &leaves, pass) {
        cells_here.cells = own.cells;
        own.disagreements += agreement.count();
        own.exchange_rounds = u64::from(pass.rounds);
        send_up(cx, subdomain, root, own);
    }
    let (mut reduction, mut outcome, mut whole) = (Reduction::default(), None, Merged::default());
    while cx.exchange().await? {
        let arrived = take_merged(cx);
        // The result of a root that one rank holds needs no combination.
        let root = arrived.iter().find(|rising| rising.node == NodeId::ROOT).map(|rising| rising.value);
        let joined = reduction
            .join(&subdomain.led, arrived, |group, both, sent| join_results(cx, pass, group, both, sent));
        for (node, own) in root.map(|own| (NodeId::ROOT, own)).into_iter().chain(joined) {
            if node == NodeId::ROOT && cx.is_coordinator() {
                let decision = judge(own, pass.population, pass.number);
                cx.to_workers(|| Body::Outcome(decision));
                (outcome, whole) = (Some(decision), own);
            } else {
                send_up(cx, subdomain, node, own);
            }
        }
        outcome = take_outcome(cx).or(outcome);
    }
    let outcome = outcome.ok_or_else(|| {
        let reason = if cx.is_coordinator() {
            "not all results reached the root"
        } else {
            "it received no decision on the certificate"
        };
        TransportError::WorkerFailed { rank: cx.rank(), reason: reason.to_string() }
    })?;
    Ok(MergedResult { outcome, cells_here, whole })
}

/// Merges the stars of each leaf; appends the facets that belong to each home point.
fn merge_leaves<P: Point>(
    cx: &mut Context<P>,
    results: Results<'_, P>,
    pass: Pass,
    facets: &mut Vec<u64>,
) -> Vec<Merged> {
    let leaves = &results.subdomain.leaves;
    let groups = owned_groups(leaves);
    let sums = map_in(&cx.pool, &groups, |(_, owned_points)| {
        let (mut sum, mut sweep) = (Merged::default(), Sweep::default());
        let (mut diameters, mut cells_here) = (Diameters::default(), Vec::with_capacity(owned_points.len()));
        for owned in owned_points.clone() {
            let (star, cells) = results.merge_star(owned, &mut diameters, &mut sweep);
            sum.join(&star);
            cells_here.push(cells);
        }
        (sum, sweep, cells_here)
    });
    let mut merged = vec![(Merged::default(), Sweep::default()); leaves.len()];
    for ((at, _), (sum, sweep, cells_here)) in groups.into_iter().zip(sums) {
        facets.extend(cells_here);
        merged[at].0.join(&sum);
        merged[at].1.join(&sweep);
    }
    for (leaf, (_, sweep)) in leaves.iter().zip(&merged) {
        let mut cost = Cost::ZERO;
        cost.swept(*sweep);
        cx.charge(Account::member(pass.payer(), leaf.id), cost, sweep.items());
    }
    merged.into_iter().map(|m| m.0).collect()
}

/// Merges the results of the leaves up the subtree of this rank. None if it has no subtree.
fn merge_subtree<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    leaves: &[Merged],
    pass: Pass,
) -> Option<(NodeId, Merged)> {
    let (root, tree) = subdomain.tree.as_ref()?;
    let mut charges = Vec::new();
    let all = merge_tree(tree, leaves, &mut charges);
    let round = cx.round();
    cx.tally(round).merged += charges.len() as u64;
    for (node, cost) in charges {
        cx.charge(Account::member(pass.payer(), node), cost, 0);
    }
    Some((*root, all))
}

/// Merges a subtree, one charge an inner node.
fn merge_tree<P: Point>(tree: &Tree<P>, leaves: &[Merged], charges: &mut Vec<(NodeId, Cost)>) -> Merged {
    match tree {
        Tree::Leaf(at) => leaves[*at],
        Tree::Node(inner) => {
            let both = [0, 1].map(|side| merge_tree(&inner.children[side], leaves, charges));
            let (cost, all) = joined(both);
            charges.push((inner.id, cost));
            all
        }
    }
}

/// The result of a node from those of its children.
fn joined(both: [Merged; 2]) -> (Cost, Merged) {
    let mut cost = Cost::ZERO;
    let all = cost.reduce(&both, Merged::default(), |mut sum, m| {
        sum.join(m);
        sum
    });
    (cost, all)
}

/// Sends the result of a node to its parent's leader, or of the root to rank 0.
fn send_up<P: Point>(cx: &mut Context<P>, subdomain: &Subdomain<P>, node: NodeId, merged: Merged) {
    let Some(parent) = node.parent() else {
        return cx.send(COORDINATOR, node, 0, Body::Merged(merged));
    };
    if let Some(shared) = subdomain.path.iter().find(|s| s.id == parent) {
        cx.send(shared.leader, node, 0, Body::Merged(merged));
    }
}

/// Takes the results of children.
fn take_merged<P: Point>(cx: &mut Context<P>) -> Vec<Rising<Merged>> {
    cx.take(|m: &mut Message<P>| match m.body {
        Body::Merged(value) => Some(Rising { node: m.node, round: m.round, value }),
        _ => None,
    })
}

/// Joins the results of the children of a node that this rank leads; the last of them was sent in round `sent`.
fn join_results<P: Point>(
    cx: &mut Context<P>,
    pass: Pass,
    group: &Group,
    both: [Merged; 2],
    sent: u32,
) -> Merged {
    let population = group.child.population;
    let _span = cx.site().subproblem(pass.payer(), group.node, "join results", population);
    let (cost, own) = joined(both);
    cx.charge(Account::leader(pass.payer(), group.node), cost, 0);
    cx.tally(sent).merged += 1;
    own
}

/// The decision of the coordinator, if it arrived.
fn take_outcome<P: Point>(cx: &mut Context<P>) -> Option<Outcome> {
    let outcomes = cx.take(|m: &mut Message<P>| match m.body {
        Body::Outcome(outcome) => Some(outcome),
        _ => None,
    });
    outcomes.last().copied()
}

impl<P: Point> Results<'_, P> {
    /// What a star contributes; and a bit for each of its first 64 facets, set where the cell belongs to its vertex.
    pub(crate) fn merge_star(
        &self,
        owned: u32,
        diameters: &mut Diameters,
        sweep: &mut Sweep,
    ) -> (Merged, u64) {
        let Chart { table, stars } = self.chart;
        let (positions, link) = (table.positions.as_slice(), stars.link(owned));
        let (mut finite, mut cells, mut hull_facets) = (0u64, 0u64, 0u64);
        let (mut has_smaller, mut cells_here, mut bit) = (false, 0, 1u64);
        // Of every facet each vertex is looked at.
        sweep.visit_lanes(P::DIM * link.len());
        sweep.each(link, |facet| {
            let Look { is_smallest, is_finite } = look_at_facet(positions, owned, facet);
            has_smaller |= !is_smallest;
            finite += u64::from(is_finite);
            let is_owned = u64::from(is_smallest && is_finite);
            cells += is_owned;
            cells_here |= bit * is_owned;
            // Behind the last there is none.
            bit <<= 1;
            hull_facets += u64::from(is_smallest && !is_finite);
        });
        let repaired = stars.has_changed(owned);
        let known = self.supergraph.separator_radius(table.radii2[owned as usize]);
        let provable =
            !repaired && finite == link.len() as u64 && diameters.are_at_most(positions, owned, link, known);
        let merged = Merged {
            repaired: u64::from(repaired),
            stars: u64::from(finite > 0),
            cells,
            hull_facets,
            minima: u64::from(!has_smaller),
            local: u64::from(provable),
            ..Merged::default()
        };
        (merged, cells_here)
    }
}

/// What a facet of a home point's link says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Look {
    /// Whether no finite vertex of it is lexicographically smaller than the point.
    pub(crate) is_smallest: bool,
    /// Whether all its vertices are finite.
    pub(crate) is_finite: bool,
}

impl Look {
    /// Whether the cell of the facet belongs to the point.
    pub(crate) fn is_owned(self) -> bool {
        self.is_smallest && self.is_finite
    }
}

/// Looks at every vertex of a facet once.
#[inline]
pub(crate) fn look_at_facet<P: Point>(positions: &[P], owned: u32, facet: &P::Facet) -> Look {
    let mut smallest = Smallest::of(owned, positions[owned as usize].coord(0));
    let mut is_finite = true;
    for &v in facet.as_ref() {
        smallest.look(v, positions.get(v as usize).map_or(f64::INFINITY, |x| x.coord(0)));
        is_finite &= v != INFINITE;
    }
    let vertices = || std::iter::once(owned).chain(facet.as_ref().iter().copied());
    let is_smallest = smallest.vertex(|| smallest_of(positions, vertices())) == owned;
    Look { is_smallest, is_finite }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::point::lex_cmp;

    use super::*;

    /// Asks of every facet, infinite ones too, of some points, against what the order of the points says.
    fn facets_say_what_the_order_says<P: Point>(points: &[P], facets: &[P::Facet]) {
        for (owned, at) in (0u32..).zip(points) {
            for facet in facets {
                let finite: Vec<&P> = facet.as_ref().iter().filter_map(|&v| points.get(v as usize)).collect();
                let is_smallest = finite.iter().all(|x| !lex_cmp(*x, at).is_lt());
                let expected = Look { is_smallest, is_finite: finite.len() == P::DIM };
                assert_eq!(look_at_facet(points, owned, facet), expected, "{at:?} {facet:?}");
            }
        }
    }

    /// The corners of the unit cube and infinity: many first coordinates are equal.
    #[test]
    fn facets_in_space() {
        let points: Vec<DVec3> =
            (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
        let vertices = || (0..8u32).chain([INFINITE]);
        let pairs = vertices().flat_map(|a| vertices().map(move |b| (a, b)));
        let facets: Vec<[u32; 3]> = pairs.flat_map(|(a, b)| vertices().map(move |c| [a, b, c])).collect();
        facets_say_what_the_order_says(&points, &facets);
    }

    #[test]
    fn facets_in_the_plane() {
        let points: Vec<DVec2> = (0..4).map(|i| DVec2::new(f64::from(i & 1), f64::from(i >> 1))).collect();
        let vertices = || (0..4u32).chain([INFINITE]);
        let facets: Vec<[u32; 2]> = vertices().flat_map(|a| vertices().map(move |b| [a, b])).collect();
        facets_say_what_the_order_says(&points, &facets);
    }
}
