//! Local hulls: the star of every owned point from its neighbours in the supergraph.
//!
//! **Statement** (paper, Lemma 4.1). If the supergraph contains the Delaunay triangulation, the star of each point is
//! the local hull of the point and its graph neighbours. The program does not assume this. Stars may disagree;
//! splaying then exchanges the missing cells ([`crate::stars::check`], [`crate::splaying::splay`]).
//!
//! **Candidates.** Every star, except the star of the smallest point, starts with a lexicographically smaller
//! candidate. For the first point of a leaf, this is the smallest point of the nearest ancestor that has a smaller
//! point. For other points, it is the preceding point of the leaf. If the candidates of a star span no cell, the
//! points of the frame are added, which span the space.
//!
//! **Weights.** The candidates of a point may hide it ([`StarBuilder::cover`]). It then has a cover in place of a link.
//!
//! **Rounds.** One, without messages. **Work and depth.** One vector step over the stars of each leaf.
//!
//! `triangulate` does not compute local hulls. There, a worker triangulates its subdomain as a whole
//! ([`crate::direct::subdomain_triangulation`]).

use std::collections::BTreeMap;

use septet_geometry::cost::Cost;
use septet_geometry::hull::{LargeStars, StarBuilder};
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::message::PointBatch;
use septet_protocol::transport::TransportError;

use crate::config::{Fault, Growth, Stop};
use crate::machine::context::Context;
use crate::machine::profile::Site;
use crate::stars::owned::{Stars, usual_facets};
use crate::state::ghosts::Ghosts;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, Tree};

/// Number of candidates below which a star gets its nearest neighbours in the leaf as further candidates.
const FEWEST_CANDIDATES: usize = 8;

/// Number of leaves whose stars the threads of a worker build before the links are appended. It is small so that the memory of
/// the links is reused soon.
const LEAVES_AT_ONCE: usize = 256;

/// The local hulls of one leaf.
struct LeafHulls<P: Point> {
    /// The links, concatenated.
    facets: Vec<P::Facet>,
    /// The number of facets of each link.
    lengths: Vec<u32>,
    /// The hidden points, with their covers.
    covers: Vec<(u32, P::Cell)>,
    cost: Cost,
    /// The bytes of the links.
    growth: Growth,
}

/// Builds the local hulls of all owned points from their neighbours in the supergraph.
pub(crate) async fn local_hulls<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    neighbours: Lists<u32>,
    ghosts: &Ghosts,
    frame: &PointBatch<P>,
) -> Result<Stars<P>, TransportError> {
    cx.enter(Phase::Hulls)?;
    let seeds = leaf_seeds(subdomain, table);
    let frame = table.intern_all(frame);
    let (site, meter) = (cx.site(), cx.own_cost());
    let large = cx.config().fault.map_or(LargeStars::default(), Fault::large_stars);
    let stop = &cx.config().stop.clone();
    let candidates =
        Candidates { table, neighbours: &neighbours, ghosts, frame: &frame, site, meter, large, stop };
    let stars = hulls_of_leaves(cx, subdomain.leaves(), &seeds, &candidates);
    drop(neighbours);
    while cx.exchange().await? {}
    Ok(stars)
}

fn hulls_of_leaves<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    seeds: &[Option<u32>],
    candidates: &Candidates<'_, P>,
) -> Stars<P> {
    let indices: Vec<usize> = (0..leaves.len()).collect();
    let mut stars = Stars::default();
    stars.reserve(candidates.table.owned_len() as usize);
    for group in indices.chunks(if cx.pool().is_some() { LEAVES_AT_ONCE } else { 1 }) {
        let hulled = cx.map(group, |&at| candidates.hulls_of(at, &leaves[at], seeds[at]));
        for (&at, hulls) in group.iter().zip(hulled) {
            cx.charge(Account::member(Phase::Hulls, leaves[at].id()), hulls.cost, leaves[at].owned_len());
            stars.append(&hulls.facets, &hulls.lengths);
            stars.add_covers(hulls.covers);
            drop(hulls.growth);
        }
        if !stars.admits_more(candidates.stop) {
            break;
        }
    }
    stars
}

/// Returns, for every leaf, a point smaller than its first point, if there is one. The phase of the separator sets, which
/// goes down the tree, charges for the comparisons ([`crate::graph::supergraph`]).
fn leaf_seeds<P: Point>(subdomain: &Subdomain<P>, table: &mut Table<P>) -> Vec<Option<u32>> {
    let mut seed = None;
    for shared in subdomain.path() {
        let Some(summaries) = shared.summaries() else { continue };
        let (mine, other) = (&summaries[shared.mine()].smallest, &summaries[1 - shared.mine()].smallest);
        let (Some(a), Some(b)) = (mine.positions.first(), other.positions.first()) else { continue };
        if lex_cmp(b, a).is_lt() {
            seed = Some(other);
        }
    }
    let above = seed.and_then(|point| table.intern_all(point).first().copied());
    let mut seeds = vec![above; subdomain.leaves().len()];
    if let Some(tree) = subdomain.tree() {
        let positions = table.positions();
        let less = |a: u32, b: u32| lex_cmp(&positions[a as usize], &positions[b as usize]).is_lt();
        set_seeds(tree, above, &less, &mut seeds);
    }
    seeds
}

/// The candidates for the stars of all leaves.
struct Candidates<'a, P: Point> {
    table: &'a Table<P>,
    neighbours: &'a Lists<u32>,
    ghosts: &'a Ghosts,
    frame: &'a [u32],
    site: Site,
    /// An empty meter.
    meter: Cost,
    large: LargeStars,
    stop: &'a Stop,
}

impl<P: Point> Candidates<'_, P> {
    /// Builds the stars of a leaf. `seed` is a point smaller than its first point. Stars are empty once the run stops.
    fn hulls_of(&self, at: usize, leaf: &Leaf<P>, seed: Option<u32>) -> LeafHulls<P> {
        let _span = self.site.subproblem(Phase::Hulls, leaf.id(), "leaf hulls", leaf.owned_len());
        let mut cost = self.meter.fresh();
        let nearest = self.nearest_members(at, leaf, &mut cost);
        let mut builder = StarBuilder::new(self.large);
        let mut facets = Vec::with_capacity(leaf.owned_len() as usize * usual_facets(P::DIM));
        let mut lengths = Vec::with_capacity(leaf.owned_len() as usize);
        let vertices: Vec<u32> = leaf.owned().collect();
        let (mut candidates, mut covers, mut growth) = (Vec::new(), Vec::new(), self.stop.growth());
        cost.map_nested(&vertices, |&vertex, own| {
            if !self.stop.admits(&mut growth, size_of_val(&facets[..]) as u64) {
                return lengths.push(0);
            }
            candidates.clear();
            candidates.extend_from_slice(&self.neighbours[vertex as usize]);
            if let Some(list) = nearest.get(&vertex) {
                candidates.extend(list);
            }
            candidates.extend(if vertex > leaf.start() { Some(vertex - 1) } else { seed });
            if !builder.build(self.table.positions(), vertex, &candidates, own) {
                candidates.extend_from_slice(self.frame);
                builder.build(self.table.positions(), vertex, &candidates, own);
            }
            let before = facets.len();
            builder.facets(&mut facets);
            lengths.push((facets.len() - before) as u32);
            covers.extend(builder.cover().map(|cover| (vertex, cover)));
        });
        LeafHulls { facets, lengths, covers, cost, growth }
    }

    /// Returns the nearest members of the leaf for each owned point with few graph neighbours.
    fn nearest_members(&self, at: usize, leaf: &Leaf<P>, cost: &mut Cost) -> BTreeMap<u32, Vec<u32>> {
        let few = |v: &u32| self.neighbours[*v as usize].len() < FEWEST_CANDIDATES;
        let rows: Vec<u32> = leaf.owned().filter(few).collect();
        if rows.is_empty() {
            return BTreeMap::new();
        }
        let members = self.ghosts.members(at, leaf);
        let all = |_| f64::INFINITY;
        let positions = self.table.positions();
        let nearest = nearest_direct(positions, &rows, &members, FEWEST_CANDIDATES, all, cost);
        rows.into_iter().zip(nearest.iter()).map(|(row, (_, list))| (row, list.to_vec())).collect()
    }
}

/// Sets the seeds of the leaves of a subtree. `above` is the smallest point of the nearest ancestor with a point that
/// is smaller than all points of the subtree.
fn set_seeds<P: Point>(
    tree: &Tree<P>,
    above: Option<u32>,
    less: &impl Fn(u32, u32) -> bool,
    seeds: &mut [Option<u32>],
) {
    match tree {
        Tree::Leaf(at) => seeds[*at] = above,
        Tree::Node(inner) => {
            let [a, b] = inner.smallest();
            let pick = |own: u32, other: u32| if less(other, own) { Some(other) } else { above };
            set_seeds(&inner.children()[0], pick(a, b), less, seeds);
            set_seeds(&inner.children()[1], pick(b, a), less, seeds);
        }
    }
}
