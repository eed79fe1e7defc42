//! The supergraph leaf by leaf, and the star of every home point from its graph neighbours.
//!
//! **Statement** (paper, Lemma 4.1). If the supergraph contains the Delaunay triangulation, the local hulls
//! of all points from their graph neighbours are its stars. Whether it does is not assumed: stars may
//! disagree, and then they exchange what they miss ([`crate::stars::check`], [`crate::splaying::repair`]).
//!
//! Every star but that of the globally smallest point starts with a lexicographically smaller candidate:
//! its predecessor in its leaf, or for a leaf's first point the smallest point of the nearest node above
//! that has a smaller one. A star whose candidates span no cell gets a frame of the whole set.
//!
//! Where only the answer is wanted, a worker triangulates its home points at once ([`crate::direct::piece`]) and gets
//! what it needs from others ([`crate::direct::halo`], [`crate::direct::interface`]).

use septet_geometry::cost::Cost;
use septet_geometry::graph::{Supergraph, graph_direct};
use septet_geometry::hull::StarBuilder;
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase};
use septet_protocol::message::Body;

use crate::config::{SetRule, map_in};
use crate::direct::piece::Piece;
use crate::graph::edges::{Edges, edges_of};
use crate::state::subdomain::{Leaf, Tree};
use crate::worker::Worker;

/// A star starts with at least this many candidates, if its leaf has them.
const FEWEST_CANDIDATES: usize = 8;

/// Leaves whose stars cores of one worker build before these are put behind each other.
const LEAVES_AT_ONCE: usize = 256;

/// Room for so many facets of each link, at first: uniform points have 27 in space, 6 in the plane.
fn usual_facets(dimension: usize) -> usize {
    if dimension == 2 { 7 } else { 30 }
}

/// The links of all home points.
#[derive(Debug)]
pub(crate) struct Stars<P: Point> {
    facets: Vec<P::Facet>,
    ranges: Vec<(u32, u32)>,
    /// Instead of both, the piece that they are in.
    piece: Option<Piece<P>>,
}

impl<P: Point> Default for Stars<P> {
    fn default() -> Self {
        Stars { facets: Vec::new(), ranges: Vec::new(), piece: None }
    }
}

impl<P: Point> Stars<P> {
    /// The link of a home point: local numbers, infinite facets included.
    pub(crate) fn link(&self, home: u32) -> &[P::Facet] {
        let (start, len) = self.ranges[home as usize];
        &self.facets[start as usize..(start + len) as usize]
    }

    /// Position of the link's first facet in the arena.
    pub(crate) fn start(&self, home: u32) -> u32 {
        self.ranges[home as usize].0
    }

    /// Length of the arena.
    pub(crate) fn arena_len(&self) -> usize {
        self.facets.len()
    }

    /// Makes room for so many links, and for what the exchange appends.
    fn reserve(&mut self, links: usize) {
        self.ranges.reserve_exact(links);
        let facets = links * usual_facets(P::DIM);
        self.facets.reserve_exact(facets + facets / 2);
    }

    /// Appends the links of the next home points, one behind the other, by their lengths.
    pub(crate) fn append(&mut self, links: &[P::Facet], lengths: &[u32]) {
        let mut start = self.facets.len() as u32;
        for &len in lengths {
            self.ranges.push((start, len));
            start += len;
        }
        self.facets.extend_from_slice(links);
    }

    /// Replaces the link of a home point.
    pub(crate) fn replace(&mut self, home: u32, link: &[P::Facet]) {
        self.ranges[home as usize] = (self.facets.len() as u32, link.len() as u32);
        self.facets.extend_from_slice(link);
    }

    /// The piece's own triangulation, while no star has been taken out of it.
    pub(crate) fn piece(&self) -> Option<&Piece<P>> {
        self.piece.as_ref()
    }

    /// The same, to change it.
    pub(crate) fn take_piece(&mut self) -> Option<Piece<P>> {
        self.piece.take()
    }

    /// Keeps the piece's own triangulation, in which the links of all home points stand.
    pub(crate) fn set_piece(&mut self, piece: Option<Piece<P>>) {
        self.piece = piece;
    }

    /// Writes the links of a piece out beside it, to be looked at only.
    pub(crate) fn show(&mut self) {
        if let Some(piece) = &self.piece {
            (self.facets, self.ranges) = piece.links();
        }
    }

    /// Writes the links of a piece out, once, so that they can be looked at and changed one by one.
    pub(crate) fn write_out(&mut self) {
        if let Some(piece) = self.piece.take() {
            (self.facets, self.ranges) = piece.links();
        }
    }
}

/// What one leaf's local hulls give.
struct Hulled<P: Point> {
    links: Vec<P::Facet>,
    lengths: Vec<u32>,
    cost: Cost,
}

impl<P: Point> Worker<P> {
    /// The supergraph of the home points.
    pub(crate) fn begin_graph(&mut self) {
        self.finish_sets();
        let positions = &self.table.positions;
        for leaf in &mut self.subdomain.leaves {
            let rank = |&a: &u32, &b: &u32| lex_cmp(&positions[a as usize], &positions[b as usize]);
            leaf.ghosts.sort_unstable_by(rank);
            leaf.ghosts.dedup();
        }
        if self.config.sets != SetRule::Ghost {
            self.finish_set_recursion();
        } else if matches!(self.supergraph(), Supergraph::Knn { .. }) {
            self.unite_reverse();
        } else {
            self.graph_of_leaves();
        }
        self.measure_graph();
    }

    /// All pairs of every leaf's home points with its members.
    fn graph_of_leaves(&mut self) {
        let (table, rule, site) = (&self.table, self.supergraph(), self.out.site());
        let results = map_in(&self.pool, &self.subdomain.leaves, |leaf| {
            let _span = site.subproblem(Phase::Graph, leaf.id, "leaf graph", leaf.home_len());
            let home: Vec<u32> = leaf.home().collect();
            let members: Vec<u32> = leaf.home().chain(leaf.ghosts.iter().copied()).collect();
            let mut cost = Cost::ZERO;
            let lists = graph_direct(rule, &table.positions, &table.radii2, &home, &members, &mut cost);
            (lists, cost, members.len() as u64)
        });
        let mut adjacency = Lists::default();
        for (leaf, (lists, cost, members)) in self.subdomain.leaves.iter().zip(results) {
            let pairs = members * u64::from(leaf.end - leaf.start);
            self.ledger.charge(Phase::Graph, leaf.id, cost, pairs);
            self.ledger.facts(leaf.id).members += members;
            adjacency.append(lists);
        }
        self.adjacency = adjacency;
    }

    /// Counts edges once, at their smaller end; sends them if asked for.
    fn measure_graph(&mut self) {
        let mut sent = Vec::new();
        for leaf in &self.subdomain.leaves {
            let mut edges = Edges::default();
            for home in leaf.home() {
                let list = &self.adjacency[home as usize];
                edges.take(&self.table, home, list);
                if self.config.collect_graph {
                    let counted = edges_of(&self.table, home, list).filter(|edge| edge.1);
                    sent.extend(counted.flat_map(|edge| edge.0));
                }
            }
            edges.enter(leaf.id, &mut self.ledger);
        }
        if !sent.is_empty() {
            self.out.send(COORDINATOR, NodeId::ROOT, 0, Body::Edges(Bulk(sent)));
        }
    }

    /// For every leaf, the smaller point that its first point starts with.
    fn leaf_seeds(&mut self) -> Vec<Option<u32>> {
        let mut seed = None;
        for shared in &self.subdomain.path {
            let Some(summaries) = &shared.summaries else { continue };
            let (mine, other) = (&summaries[shared.mine].smallest, &summaries[1 - shared.mine].smallest);
            let (Some(a), Some(b)) = (mine.positions.first(), other.positions.first()) else { continue };
            if lex_cmp(b, a).is_lt() {
                seed = Some(other.clone());
            }
        }
        let above = seed.and_then(|point| self.table.intern_all(&point).first().copied());
        let mut seeds = vec![above; self.subdomain.leaves.len()];
        if let Some((_, tree)) = &self.subdomain.tree {
            let positions = &self.table.positions;
            let less = |a: u32, b: u32| lex_cmp(&positions[a as usize], &positions[b as usize]).is_lt();
            hand_down(tree, above, &less, &mut seeds);
        }
        seeds
    }

    /// The local hulls of all home points.
    pub(crate) fn begin_hulls(&mut self) {
        let seeds = self.leaf_seeds();
        let frame = self.table.intern_all(&self.frame);
        let leaves: Vec<(&Leaf<P>, Option<u32>)> = self.subdomain.leaves.iter().zip(seeds).collect();
        self.stars.reserve(self.table.home as usize);
        // Few at a time: their storage is soon used again.
        for group in leaves.chunks(if self.pool.is_some() { LEAVES_AT_ONCE } else { 1 }) {
            let hulled = map_in(&self.pool, group, |(leaf, seed)| self.hulls_of(leaf, *seed, &frame));
            for ((leaf, _), hulls) in group.iter().zip(hulled) {
                self.ledger.charge(Phase::Hulls, leaf.id, hulls.cost, leaf.home_len());
                self.stars.append(&hulls.links, &hulls.lengths);
            }
        }
        self.adjacency = Lists::default();
    }

    /// One vector step over the stars of a leaf.
    fn hulls_of(&self, leaf: &Leaf<P>, seed: Option<u32>, frame: &[u32]) -> Hulled<P> {
        let _span = self.out.site().subproblem(Phase::Hulls, leaf.id, "leaf hulls", leaf.home_len());
        let mut cost = Cost::ZERO;
        let nearest = self.supplement(leaf, &mut cost);
        let mut builder = StarBuilder::default();
        let mut links = Vec::with_capacity(leaf.home_len() as usize * usual_facets(P::DIM));
        let mut lengths = Vec::with_capacity(leaf.home_len() as usize);
        let homes: Vec<u32> = leaf.home().collect();
        let mut candidates = Vec::new();
        cost.map_nested(&homes, |&home, own| {
            candidates.clear();
            candidates.extend_from_slice(&self.adjacency[home as usize]);
            if let Some(list) = nearest.get(&home) {
                candidates.extend(list);
            }
            candidates.extend(if home > leaf.start { Some(home - 1) } else { seed });
            if !builder.build(&self.table.positions, home, &candidates, own) {
                candidates.extend_from_slice(frame);
                builder.build(&self.table.positions, home, &candidates, own);
            }
            let before = links.len();
            builder.facets(&mut links);
            lengths.push((links.len() - before) as u32);
        });
        Hulled { links, lengths, cost }
    }

    /// Nearest members for points with few graph neighbours.
    fn supplement(&self, leaf: &Leaf<P>, cost: &mut Cost) -> std::collections::BTreeMap<u32, Vec<u32>> {
        let few = |h: &u32| self.adjacency[*h as usize].len() < FEWEST_CANDIDATES;
        let rows: Vec<u32> = leaf.home().filter(few).collect();
        if rows.is_empty() {
            return std::collections::BTreeMap::new();
        }
        let members: Vec<u32> = leaf.home().chain(leaf.ghosts.iter().copied()).collect();
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
