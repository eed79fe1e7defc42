//! Local hulls: the star of every home point from its neighbours in the supergraph.
//!
//! **Statement** (paper, Lemma 4.1). If the supergraph contains the Delaunay triangulation, the local hulls
//! of all points from their graph neighbours are its stars. Whether it does is not assumed: stars may
//! disagree, and then they exchange what they miss ([`crate::stars::check`], [`crate::splaying::splay`]).
//!
//! Every star but that of the globally smallest point starts with a lexicographically smaller candidate:
//! its predecessor in its leaf, or for a leaf's first point the smallest point of the nearest node above
//! that has a smaller one. A star whose candidates span no cell gets a frame of the whole set.
//!
//! **Rounds.** One, without messages. **Work and depth.** One vector step over the stars of each leaf.
//!
//! Where only the answer is wanted, a worker triangulates its home points at once ([`crate::direct::subdomain_triangulation`]) and gets
//! what it needs from others ([`crate::direct::ghost_layer`], `crate::direct::interface`).

use std::collections::BTreeMap;

use septet_geometry::cost::Cost;
use septet_geometry::hull::StarBuilder;
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::message::PointBatch;
use septet_protocol::transport::TransportError;

use crate::config::map_in;
use crate::machine::context::Context;
use crate::machine::profile::Site;
use crate::stars::owned::{Stars, usual_facets};
use crate::state::subdomain::{Ghosts, Leaf, Subdomain, Tree};
use crate::state::table::Table;

/// A star starts with at least this many candidates, if its leaf has them.
const FEWEST_CANDIDATES: usize = 8;

/// Leaves whose stars cores of one worker build before these are put behind each other.
const LEAVES_AT_ONCE: usize = 256;

/// What one leaf's local hulls give.
struct Hulled<P: Point> {
    links: Vec<P::Facet>,
    lengths: Vec<u32>,
    cost: Cost,
}

/// The local hulls of all home points, from their neighbours in the supergraph.
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
    let view = View { table, neighbours: &neighbours, ghosts, frame: &frame, site: cx.site() };
    let stars = hulls_of_leaves(cx, &subdomain.leaves, &seeds, &view);
    drop(neighbours);
    while cx.exchange().await? {}
    Ok(stars)
}

fn hulls_of_leaves<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    seeds: &[Option<u32>],
    view: &View<'_, P>,
) -> Stars<P> {
    let places: Vec<usize> = (0..leaves.len()).collect();
    let mut stars = Stars::default();
    stars.reserve(view.table.owned as usize);
    // Few at a time: their storage is soon used again.
    for group in places.chunks(if cx.pool.is_some() { LEAVES_AT_ONCE } else { 1 }) {
        let hulled = map_in(&cx.pool, group, |&at| view.hulls_of(at, &leaves[at], seeds[at]));
        for (&at, hulls) in group.iter().zip(hulled) {
            cx.charge(Account::member(Phase::Hulls, leaves[at].id), hulls.cost, leaves[at].owned_len());
            stars.append(&hulls.links, &hulls.lengths);
        }
    }
    stars
}

/// For every leaf, the smaller point that its first point starts with.
fn leaf_seeds<P: Point>(subdomain: &Subdomain<P>, table: &mut Table<P>) -> Vec<Option<u32>> {
    let mut seed = None;
    for shared in &subdomain.path {
        let Some(summaries) = &shared.summaries else { continue };
        let (mine, other) = (&summaries[shared.mine].smallest, &summaries[1 - shared.mine].smallest);
        let (Some(a), Some(b)) = (mine.positions.first(), other.positions.first()) else { continue };
        if lex_cmp(b, a).is_lt() {
            seed = Some(other);
        }
    }
    let above = seed.and_then(|point| table.intern_all(point).first().copied());
    let mut seeds = vec![above; subdomain.leaves.len()];
    if let Some((_, tree)) = &subdomain.tree {
        let positions = &table.positions;
        let less = |a: u32, b: u32| lex_cmp(&positions[a as usize], &positions[b as usize]).is_lt();
        hand_down(tree, above, &less, &mut seeds);
    }
    seeds
}

/// What the hulls of a leaf are made of.
struct View<'a, P: Point> {
    table: &'a Table<P>,
    neighbours: &'a Lists<u32>,
    ghosts: &'a Ghosts,
    frame: &'a [u32],
    site: Site,
}

impl<P: Point> View<'_, P> {
    /// One vector step over the stars of a leaf.
    fn hulls_of(&self, at: usize, leaf: &Leaf<P>, seed: Option<u32>) -> Hulled<P> {
        let _span = self.site.subproblem(Phase::Hulls, leaf.id, "leaf hulls", leaf.owned_len());
        let mut cost = Cost::ZERO;
        let nearest = self.supplement(at, leaf, &mut cost);
        let mut builder = StarBuilder::default();
        let mut links = Vec::with_capacity(leaf.owned_len() as usize * usual_facets(P::DIM));
        let mut lengths = Vec::with_capacity(leaf.owned_len() as usize);
        let owned_points: Vec<u32> = leaf.owned().collect();
        let mut candidates = Vec::new();
        cost.map_nested(&owned_points, |&owned, own| {
            candidates.clear();
            candidates.extend_from_slice(&self.neighbours[owned as usize]);
            if let Some(list) = nearest.get(&owned) {
                candidates.extend(list);
            }
            candidates.extend(if owned > leaf.start { Some(owned - 1) } else { seed });
            if !builder.build(&self.table.positions, owned, &candidates, own) {
                candidates.extend_from_slice(self.frame);
                builder.build(&self.table.positions, owned, &candidates, own);
            }
            let before = links.len();
            builder.facets(&mut links);
            lengths.push((links.len() - before) as u32);
        });
        Hulled { links, lengths, cost }
    }

    /// Nearest members for points with few graph neighbours.
    fn supplement(&self, at: usize, leaf: &Leaf<P>, cost: &mut Cost) -> BTreeMap<u32, Vec<u32>> {
        let few = |h: &u32| self.neighbours[*h as usize].len() < FEWEST_CANDIDATES;
        let rows: Vec<u32> = leaf.owned().filter(few).collect();
        if rows.is_empty() {
            return BTreeMap::new();
        }
        let members = self.ghosts.members(at, leaf);
        let all = |_| f64::INFINITY;
        let positions = &self.table.positions;
        let nearest = nearest_direct(positions, &rows, &members, FEWEST_CANDIDATES, all, cost);
        rows.into_iter().zip(nearest.iter()).map(|(row, (_, list))| (row, list.to_vec())).collect()
    }
}

/// Hands the nearest smaller point above down to every leaf.
fn hand_down<P: Point>(
    tree: &Tree<P>,
    above: Option<u32>,
    less: &impl Fn(u32, u32) -> bool,
    seeds: &mut [Option<u32>],
) {
    match tree {
        Tree::Leaf(at) => seeds[*at] = above,
        Tree::Node(inner) => {
            let [a, b] = inner.smallest;
            let pick = |own: u32, other: u32| if less(other, own) { Some(other) } else { above };
            hand_down(&inner.children[0], pick(a, b), less, seeds);
            hand_down(&inner.children[1], pick(b, a), less, seeds);
        }
    }
}
