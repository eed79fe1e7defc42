//! Merges the results of all subproblems up the tree.
//!
//! **Statement.** A cell belongs to its lexicographically smallest vertex, so the leaves have disjoint sets of cells
//! and the union of these sets contains every cell. The merged result of a subproblem consists of counts, among them
//! those of the certificate's conditions. Results go from children to parents. Rank 0 decides on the result of the
//! root. The cells themselves stay with the ranks ([`crate::result::collect`]).
//!
//! **Rounds.** One for each level of shared nodes, and those of the decision, which goes down a tree of ranks.
//!
//! **Work and depth.** One vector step over all link facets; O(1) for each node.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::graph::Supergraph;
use septet_geometry::measure::{Diameters, conflict_reach2};
use septet_geometry::point::Point;
use septet_protocol::checksum::row_hash;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Merged, Message, PointSum};
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::machine::collectives::{Reduction, Rising};
use crate::machine::context::Context;
use crate::result::decision::decide;
use crate::stars::check::Agreement;
use crate::stars::owned::StarsView;
use crate::state::cells::{first_coordinate, smallest_vertex, star_cell};
use crate::state::rows::piece_hash;
use crate::state::subdomain::{Group, Subdomain};
use crate::state::tree::{Tree, owned_groups};

/// The subdomain of a rank and its stars, for threads that read both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Results<'a, P: Point> {
    subdomain: &'a Subdomain<P>,
    view: StarsView<'a, P>,
    instance: Instance,
}

impl<'a, P: Point> Results<'a, P> {
    /// Views the results of a rank.
    pub(crate) fn new(subdomain: &'a Subdomain<P>, view: StarsView<'a, P>, instance: Instance) -> Self {
        Results { subdomain, view, instance }
    }

    /// Returns the subdomain.
    pub(super) fn subdomain(&self) -> &'a Subdomain<P> {
        self.subdomain
    }

    /// Returns the stars and the table of their vertices.
    pub(super) fn view(&self) -> StarsView<'a, P> {
        self.view
    }

    /// Returns the radius of the separator ball of an owned point.
    pub(super) fn separator_radius(&self, vertex: u32) -> f64 {
        self.instance.supergraph.separator_radius(self.view.table().radii2()[vertex as usize])
    }
}

/// Properties of the run that are equal on all ranks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instance {
    /// The points of all ranks. Only the coordinator knows the sum of their hashes.
    pub(crate) population: PointSum,
    /// The largest weight; 0 without weights.
    pub(crate) heaviest: f64,
    /// The supergraph of the stars.
    pub(crate) supergraph: Supergraph,
}

/// One pass of splaying and certificate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pass {
    /// The number of earlier passes.
    pub(crate) number: u32,
    /// The last round of splaying in which this rank sent a message; 0 if it sent none.
    pub(crate) rounds: u32,
    /// The run.
    pub(crate) instance: Instance,
}

impl Pass {
    /// Returns the phase to which the pass is charged: `merge` for the first pass, `certificate` for a pass after
    /// gathering. The paper has no gathering.
    fn payer(self) -> Phase {
        if self.number > 0 { Phase::Certificate } else { Phase::Merge }
    }
}

/// The cells that belong to this rank.
#[derive(Debug, Default)]
pub(crate) struct OwnedCells {
    count: u64,
    /// For each owned point, bit `i` is set if the cell of facet `i` belongs to the point. Facets from the 65th on have
    /// no bit. Empty for a subdomain triangulation.
    facets: Vec<u64>,
}

impl OwnedCells {
    /// Returns the number of cells.
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// Returns a bit for each of the first 64 facets in the link of an owned point, set if the cell belongs to the
    /// point.
    pub(super) fn facets_of(&self, vertex: u32) -> u64 {
        self.facets[vertex as usize]
    }
}

/// The outcome of merging.
#[derive(Debug)]
pub(crate) struct MergedResult {
    outcome: Outcome,
    owned_cells: OwnedCells,
    whole: Merged,
}

impl MergedResult {
    /// Returns the decision of the coordinator, the cells that belong to this rank, and the merged result of all
    /// ranks. The merged result is empty except on the coordinator.
    pub(crate) fn into_parts(self) -> (Outcome, OwnedCells, Merged) {
        (self.outcome, self.owned_cells, self.whole)
    }
}

/// Merges the results of all ranks. The coordinator decides on the merged result and broadcasts its decision.
pub(crate) async fn merge<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    view: StarsView<'_, P>,
    agreement: &Agreement,
    pass: Pass,
) -> Result<MergedResult, TransportError> {
    cx.enter(Phase::Merge)?;
    let results = Results { subdomain, view, instance: pass.instance };
    let mut owned_cells = OwnedCells::default();
    let leaves = match view.merged() {
        Some(own) => vec![own],
        None => merge_leaves(cx, results, pass, &mut owned_cells.facets),
    };
    if let Some((root, mut own)) = merge_subtree(cx, subdomain, &leaves, pass) {
        owned_cells.count = own.cells;
        own.disagreements += agreement.count();
        own.point_hash = view.table().owned_sum().hash;
        // The share of a rank without points is empty.
        if view.table().owned_len() > 0 {
            own.cell_hash = piece_hash(cx.rank(), own.cell_hash, view.table().ids());
        }
        own.exchange_rounds = u64::from(pass.rounds);
        send_up(cx, subdomain, root, own);
    }
    let (mut reduction, mut outcome, mut whole) = (Reduction::default(), None, Merged::default());
    while cx.exchange().await? {
        let arrived = take_merged(cx);
        // If one rank holds the root, its result is already complete.
        let root = arrived.iter().find(|rising| rising.node == NodeId::ROOT).map(|rising| rising.value);
        let joined = reduction
            .join(subdomain.led(), arrived, |group, both, sent| join_results(cx, pass, group, both, sent));
        for (node, own) in root.map(|own| (NodeId::ROOT, own)).into_iter().chain(joined) {
            if node == NodeId::ROOT && cx.is_coordinator() {
                let decision = decide(own, pass.instance.population, pass.number);
                cx.send_to_all(|| Body::Outcome(decision));
                whole = own;
            } else {
                send_up(cx, subdomain, node, own);
            }
        }
        if let Some(decision) = take_outcome(cx) {
            cx.pass_on(|| Body::Outcome(decision));
            outcome = Some(decision);
        }
    }
    let outcome = outcome.ok_or_else(|| {
        let reason = "phase merge ended without a decision on the certificate".to_string();
        TransportError::WorkerFailed { rank: cx.rank(), reason }
    })?;
    Ok(MergedResult { outcome, owned_cells, whole })
}

/// Merges the stars of each leaf. Appends the bits of each owned point ([`OwnedCells`]).
fn merge_leaves<P: Point>(
    cx: &mut Context<P>,
    results: Results<'_, P>,
    pass: Pass,
    facets: &mut Vec<u64>,
) -> Vec<Merged> {
    let leaves = results.subdomain.leaves();
    let groups = owned_groups(leaves);
    let sums = cx.map(&groups, |(_, vertices)| {
        let (mut sum, mut sweep) = (Merged::default(), Sweep::default());
        let (mut diameters, mut bits) = (Diameters::default(), Vec::with_capacity(vertices.len()));
        for vertex in vertices.clone() {
            let star = results.merge_star(vertex, &mut diameters, &mut sweep);
            sum.join(&star.merged);
            bits.push(star.owned_facets);
        }
        (sum, sweep, bits)
    });
    let mut merged = vec![(Merged::default(), Sweep::default()); leaves.len()];
    for ((at, _), (sum, sweep, bits)) in groups.into_iter().zip(sums) {
        facets.extend(bits);
        merged[at].0.join(&sum);
        merged[at].1.join(&sweep);
    }
    for (leaf, (_, sweep)) in leaves.iter().zip(&merged) {
        let mut cost = cx.own_cost();
        cost.charge_sweep(*sweep);
        cx.charge(Account::member(pass.payer(), leaf.id()), cost, sweep.items());
    }
    merged.into_iter().map(|m| m.0).collect()
}

/// Merges the results of the leaves up the subtree of this rank. Returns `None` if the rank has no subtree.
fn merge_subtree<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    leaves: &[Merged],
    pass: Pass,
) -> Option<(NodeId, Merged)> {
    let (root, tree) = (subdomain.root(), subdomain.tree()?);
    let mut charges = Vec::new();
    let all = merge_tree(tree, leaves, &cx.own_cost(), &mut charges);
    let round = cx.round();
    cx.tally(round).merged += charges.len() as u64;
    for (node, cost) in charges {
        cx.charge(Account::member(pass.payer(), node), cost, 0);
    }
    Some((root, all))
}

/// Merges a subtree. Appends the charge of each inner node.
fn merge_tree<P: Point>(
    tree: &Tree<P>,
    leaves: &[Merged],
    meter: &Cost,
    charges: &mut Vec<(NodeId, Cost)>,
) -> Merged {
    match tree {
        Tree::Leaf(at) => leaves[*at],
        Tree::Node(inner) => {
            let both = [0, 1].map(|side| merge_tree(&inner.children()[side], leaves, meter, charges));
            let (cost, all) = joined(both, meter);
            charges.push((inner.id(), cost));
            all
        }
    }
}

/// Returns the result of a node from the results of its children, and its cost.
fn joined(both: [Merged; 2], meter: &Cost) -> (Cost, Merged) {
    let mut cost = meter.fresh();
    let all = cost.reduce(&both, Merged::default(), |mut sum, m| {
        sum.join(m);
        sum
    });
    (cost, all)
}

/// Sends the result of a node to the leader of its parent. Sends the result of the root to rank 0.
fn send_up<P: Point>(cx: &mut Context<P>, subdomain: &Subdomain<P>, node: NodeId, merged: Merged) {
    if node == NodeId::ROOT {
        cx.send_to_coordinator(Body::Merged(merged));
    } else {
        cx.contribute_up(subdomain.groups(), node, Body::Merged(merged));
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
    let (cost, own) = joined(both, &cx.own_cost());
    cx.charge(Account::leader(pass.payer(), group.node), cost, 0);
    cx.tally(sent).merged += 1;
    own
}

/// Returns the decision of the coordinator, if it has arrived.
fn take_outcome<P: Point>(cx: &mut Context<P>) -> Option<Outcome> {
    let outcomes = cx.take(|m: &mut Message<P>| match m.body {
        Body::Outcome(outcome) => Some(outcome),
        _ => None,
    });
    outcomes.last().copied()
}

impl<P: Point> Results<'_, P> {
    /// Computes the contribution of an owned star.
    pub(super) fn merge_star(&self, vertex: u32, diameters: &mut Diameters, sweep: &mut Sweep) -> MergedStar {
        let (positions, link) = (self.view.table().positions(), self.view.link(vertex));
        let (mut finite, mut cells, mut hull_facets) = (0u64, 0u64, 0u64);
        let (mut has_smaller, mut owned_facets, mut bit, mut cell_hash) = (false, 0, 1u64, 0u64);
        // Every vertex of every facet is compared.
        sweep.visit_all(bytemuck::cast_slice::<_, u32>(link));
        sweep.each(link, |facet| {
            let class = classify(positions, vertex, facet);
            let FacetClass { is_smallest, is_finite } = class;
            has_smaller |= !is_smallest;
            finite += u64::from(is_finite);
            cells += u64::from(class.is_owned());
            owned_facets |= bit * u64::from(class.is_owned());
            if class.is_owned() {
                cell_hash = cell_hash.wrapping_add(row_hash(star_cell::<P>(vertex, facet).as_ref()));
            }
            // The bit is 0 from the 65th facet on.
            bit <<= 1;
            hull_facets += u64::from(is_smallest && !is_finite);
        });
        let stars = self.view.stars();
        let (repaired, is_hidden) = (stars.has_changed(vertex), stars.cover(vertex).is_some());
        let radius = self.separator_radius(vertex);
        let provable = !repaired
            && !is_hidden
            && finite == link.len() as u64
            && if P::IS_WEIGHTED {
                self.reaches_are_at_most(vertex, radius)
            } else {
                diameters.are_at_most(positions, vertex, link, radius)
            };
        let merged = Merged {
            repaired: u64::from(repaired),
            stars: u64::from(finite > 0 || is_hidden),
            cells,
            cell_hash,
            hull_facets,
            minima: u64::from(!(has_smaller || is_hidden)),
            local: u64::from(provable),
            ..Merged::default()
        };
        MergedStar { merged, owned_facets }
    }

    /// Returns `true` if no cell of an owned star, all of whose cells are finite, conflicts with a point farther from its vertex
    /// than `length`. A hidden point has no cells.
    fn reaches_are_at_most(&self, vertex: u32, length: f64) -> bool {
        let (positions, heaviest) = (self.view.table().positions(), self.instance.heaviest);
        self.view.link(vertex).iter().all(|facet| {
            let mut cell = [positions[vertex as usize]; 4];
            for (corner, &v) in cell[1..].iter_mut().zip(facet.as_ref()) {
                *corner = positions[v as usize];
            }
            conflict_reach2(&cell[..=P::DIM], heaviest) <= length * length
        })
    }
}

/// The contribution of a star to the merged result.
pub(super) struct MergedStar {
    pub(super) merged: Merged,
    /// Bit `i` is set if the cell of facet `i` belongs to the vertex of the star. Facets from the 65th on have no bit.
    owned_facets: u64,
}

/// A facet in the link of an owned point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FacetClass {
    /// Whether the point is lexicographically smaller than all finite vertices of the facet.
    is_smallest: bool,
    /// Whether all vertices of the facet are finite.
    is_finite: bool,
}

impl FacetClass {
    /// Returns `true` if the cell of the facet belongs to the point.
    pub(super) fn is_owned(self) -> bool {
        self.is_smallest && self.is_finite
    }
}

/// Classifies a facet in the link of `vertex`.
#[inline]
pub(super) fn classify<P: Point>(positions: &[P], vertex: u32, facet: &P::Facet) -> FacetClass {
    let cell = star_cell::<P>(vertex, facet);
    let first = |v: u32| first_coordinate(positions, v);
    let is_smallest = smallest_vertex(positions, cell.as_ref(), first) == vertex;
    let is_finite = facet.as_ref().iter().all(|&v| v != INFINITE);
    FacetClass { is_smallest, is_finite }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::point::lex_cmp;

    use super::*;

    /// Classifies all facets of some points, infinite ones included, and compares with the order of the points.
    fn facets_follow_the_order<P: Point>(points: &[P], facets: &[P::Facet]) {
        for (vertex, at) in (0u32..).zip(points) {
            for facet in facets {
                let finite: Vec<&P> = facet.as_ref().iter().filter_map(|&v| points.get(v as usize)).collect();
                let is_smallest = finite.iter().all(|x| !lex_cmp(*x, at).is_lt());
                let expected = FacetClass { is_smallest, is_finite: finite.len() == P::DIM };
                assert_eq!(classify(points, vertex, facet), expected, "{at:?} {facet:?}");
            }
        }
    }

    /// The points are the corners of the unit cube and infinity, so many first coordinates are equal.
    #[test]
    fn facets_in_space() {
        let points: Vec<DVec3> =
            (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
        let vertices = || (0..8u32).chain([INFINITE]);
        let pairs = vertices().flat_map(|a| vertices().map(move |b| (a, b)));
        let facets: Vec<[u32; 3]> = pairs.flat_map(|(a, b)| vertices().map(move |c| [a, b, c])).collect();
        facets_follow_the_order(&points, &facets);
    }

    #[test]
    fn facets_in_the_plane() {
        let points: Vec<DVec2> = (0..4).map(|i| DVec2::new(f64::from(i & 1), f64::from(i >> 1))).collect();
        let vertices = || (0..4u32).chain([INFINITE]);
        let facets: Vec<[u32; 2]> = vertices().flat_map(|a| vertices().map(move |b| [a, b])).collect();
        facets_follow_the_order(&points, &facets);
    }
}
