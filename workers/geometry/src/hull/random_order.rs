//! Large stars: random insertion with conflict lists.
//!
//! **Statement.** The candidates that remain are inserted in random order. Every facet has the list of the remaining
//! candidates that it conflicts with, and the first of them is its *pivot*. When the turn of a candidate comes, the
//! facets whose pivot it is are its cavity. A new facet joins a ridge of the cavity's boundary to the candidate. Let
//! `t` and `o` be the facets inside and outside of this ridge. The list `C` of the new facet satisfies
//! `C(t) & C(o) <= C <= C(t) | C(o)`, so only candidates in exactly one of the two lists are tested.
//!
//! **Order.** The rank of a candidate is the hash of its coordinates, then its lexicographic rank. So the order does not
//! depend on the numbering of the points.
//!
//! **Source.** Clarkson and Shor, "Applications of random sampling in computational geometry, II" (1989). Rounds:
//! Blelloch, Gu, Shun and Sun, "Randomized incremental convex hull is highly parallel", SPAA 2020.
//!
//! **Rounds of the star.** A new facet depends on `t` and `o` alone. Its *round* is one more than the later of theirs.
//! The machine creates all facets of a round at once. The program creates them in the order of insertion, and counts
//! the items of each round. The facets are the same, and so are their lists.
//!
//! **Work and depth.** For `m` candidates, the lists have O(m log m) entries in total, expected. The longest chain has
//! O(log m) rounds with high probability, and a round is a constant number of vector steps and scans. With scans of
//! O(log m) steps, the depth is O(log^2 m). The first lists take one vector step over all pairs of a candidate and a
//! facet of the first link, whose size is bounded by a constant.
//!
//! **Departures.**
//! 1. The nearest candidates are added first, by distance ([`super::builder`]).
//! 2. The machine drops a candidate of `C(o)` that conflicts with `t` by one test. The program merges both lists, which
//!    are sorted, without a test.
//! 3. The facets of a cone find each other in a table, as in [`crate::dependence`]. An access counts one step.

use super::builder::{StarBuilder, note_removed};
use super::candidate::{Candidate, candidate};
use super::conflict_lists::{ConflictLists, Support};
use super::corners::Corners;
use super::large::{BATCH, LARGE, LARGE_LINK, LargeStars, MANY, MOST_BY_DISTANCE};
use super::planes::Side;
use crate::cost::Cost;
use crate::hash::hash_of_place;
use crate::point::{Point, lex_cmp};
use crate::simd::widest;

impl<P: Point> StarBuilder<P> {
    /// Creates a builder.
    pub fn new(large: LargeStars) -> Self {
        StarBuilder { large, ..StarBuilder::default() }
    }

    /// Creates a builder for a machine that keeps the complexes of its stars, with the lists of their vertices. So a link that
    /// [`StarBuilder::extend`] loads costs nothing: the program builds its complex again, and the counted machine does not.
    pub fn keeping_stars() -> Self {
        StarBuilder { keeps_stars: true, ..StarBuilder::default() }
    }

    /// Returns `true` if a set of this many candidates is not added by distance.
    pub(super) fn is_large(&self, candidates: usize) -> bool {
        candidates > LARGE && self.large == LargeStars::AtRandom
    }

    /// Returns `true` if this many new candidates of a finished star are not added by distance.
    pub(super) fn are_many(&self, candidates: usize) -> bool {
        if self.keeps_stars { candidates > MANY } else { self.is_large(candidates) }
    }

    /// Returns `true` if the candidates that are not taken must be added at random.
    pub(super) fn needs_lists(&self) -> bool {
        let vertices = if P::DIM == 2 { self.link.len() } else { self.link.len() / 2 + 2 };
        self.is_large(self.order.len() - self.taken)
            && (vertices > LARGE_LINK || self.points.len() > MOST_BY_DISTANCE)
    }

    /// Moves the vertices of the first facet before all other points, and returns the facet. Only one batch of further
    /// points remains taken. This is for sets whose nearest points span no cell.
    #[cold]
    pub(super) fn bring_forward(&mut self, first: P::Facet) -> P::Facet {
        let is_vertex = |at: usize| first.as_ref().contains(&(at as u32).wrapping_sub(1));
        let (mut vertices, mut others) = (vec![self.points[0]], Vec::new());
        for (at, &point) in self.points.iter().enumerate().skip(1) {
            if is_vertex(at) { vertices.push(point) } else { others.push(point) }
        }
        let (batch, rest) = others.split_at(BATCH.min(others.len()));
        let waiting = self.order[self.taken..].iter().copied();
        let is_new = |id: &u32| vertices.iter().all(|v| v.id != *id);
        self.order = rest.iter().map(|p| p.id).chain(waiting).filter(is_new).collect();
        self.taken = 0;
        let mut sorted = first;
        sorted.as_mut().sort_unstable();
        let mut moved = first;
        for v in moved.as_mut() {
            *v = sorted.as_ref().iter().take_while(|w| *w < v).count() as u32;
        }
        vertices.extend(batch);
        self.points = vertices;
        moved
    }

    /// Sorts `order` by random rank.
    pub(super) fn sort_by_rank(&mut self, table: &[P], cost: &mut Cost) {
        let rank = |i: u32| hash_of_place(table[i as usize]);
        cost.sort_keyed(&mut self.order, &mut self.keys, rank, |&a, &b| {
            let by_place = || lex_cmp(&table[a as usize], &table[b as usize]);
            rank(a).cmp(&rank(b)).then_with(by_place)
        });
    }

    /// Adds the candidates of `order` behind the first `taken`, which are sorted by distance. Those out of reach of
    /// all facets are left out.
    #[cold]
    pub(super) fn add_rest(&mut self, table: &[P], cost: &mut Cost) {
        let from = self.points.len() as u32 - 1;
        let (reach2, centre) = (self.planes.least_reach2(), self.centre);
        let last = self.points.last().map(|last| last.id);
        let mut sweep = cost.sweep();
        let mut within = Vec::new();
        for &id in sweep.visit_all(&self.order[self.taken..]) {
            let length = Candidate::of(table, id, centre).image.length;
            if length * length < reach2 {
                break;
            }
            if Some(id) != last {
                within.push(id);
            }
        }
        cost.charge_sweep(sweep);
        self.order = within;
        self.taken = self.order.len();
        self.sort_by_rank(table, cost);
        self.take_order(table, cost);
        self.insert_at_random(from, cost);
    }

    /// Appends the candidates of `order` to the points, each once.
    fn take_order(&mut self, table: &[P], cost: &mut Cost) {
        let (mut sweep, mut last) = (cost.sweep(), None);
        for &id in sweep.visit_all(&self.order) {
            if last != Some(id) {
                self.points.push(Candidate::of(table, id, self.centre));
                last = Some(id);
            }
        }
        cost.charge_sweep(sweep);
    }

    /// Inserts the points from number `from` on, which are in random order.
    #[cold]
    pub(super) fn insert_at_random(&mut self, from: u32, cost: &mut Cost) {
        let all = self.points.len() as u32 - 1;
        let mut lists = std::mem::take(&mut self.conflicts);
        lists.clear(self.link.slots() as usize, all as usize);
        self.fill_first_lists(&mut lists, from, cost);
        let rest = &self.points[from as usize + 1..];
        let longest = rest.iter().fold(0.0, |most: f64, p| most.max(p.image.length));
        let mut cavity = std::mem::take(&mut self.cavity);
        for q in from..all {
            lists.take_cavity(q, &mut cavity);
            if P::IS_WEIGHTED && cavity.len() == self.link.len() {
                note_removed(&mut self.loaded, &mut self.removed, &cavity);
                self.removers.resize(self.removed.len(), candidate(&self.points, q).id);
                self.hide(q);
                break;
            }
            if !cavity.is_empty() {
                self.replace_cavity(q, &cavity, longest, &mut lists);
            }
        }
        self.cavity = cavity;
        lists.charge(cost);
        self.conflicts = lists;
    }

    /// Tests each candidate against each facet of the link.
    fn fill_first_lists(&mut self, lists: &mut ConflictLists, from: u32, cost: &mut Cost) {
        let (mut pairs, mut exact, mut found) = (cost.sweep(), cost.sweep(), cost.sweep());
        let mut ridges = cost.sweep();
        widest(
            #[inline(always)]
            || {
                for q in from..self.points.len() as u32 - 1 {
                    pairs.visit_lanes(self.link.len());
                    let undecided = self.find_cavity(q);
                    exact.visit_all(&self.uncertain);
                    let cavity = if undecided { &self.cavity } else { &self.uncertain };
                    for &facet in found.visit_all(cavity) {
                        lists.lists[facet as usize].push(q);
                    }
                    self.clear_sides();
                }
            },
        );
        for facet in self.link.live_cells() {
            lists.enter(facet);
            ridges.visit_lanes(P::DIM);
        }
        cost.charge_pairs(pairs);
        cost.charge_sweeps([exact, found, ridges]);
    }

    /// Replaces the facets whose pivot is `q`, and computes the lists of the new ones.
    fn replace_cavity(&mut self, q: u32, cavity: &[u32], longest: f64, lists: &mut ConflictLists) {
        let mut supports = Vec::with_capacity(cavity.len() + 2);
        for (inner, &facet) in cavity.iter().enumerate() {
            for slot in 0..P::DIM {
                let (outer, _) = self.link.neighbour(facet, slot);
                if !lists.is_pivot(outer, q) {
                    let round = lists.rounds[facet as usize].max(lists.rounds[outer as usize]) + 1;
                    supports.push(Support { inner, outer, round });
                }
            }
        }
        note_removed(&mut self.loaded, &mut self.removed, cavity);
        self.removers.resize(self.removed.len(), candidate(&self.points, q).id);
        self.link.replace(q, cavity, |facet| lists.is_pivot(facet, q));
        let taken: Vec<Vec<u32>> =
            cavity.iter().map(|&facet| std::mem::take(&mut lists.lists[facet as usize])).collect();
        for &facet in cavity.iter().skip(self.link.created().len()) {
            self.planes.remove(facet);
        }
        self.enter_created(longest);
        lists.make_room(self.link.slots() as usize);
        for (&facet, support) in self.link.created().iter().zip(&supports) {
            self.fill_list(facet, *support, &taken[support.inner], lists);
        }
        lists.spare.extend(taken.into_iter().filter(|list| list.capacity() > 0));
    }

    /// Selects the conflicts of a new facet from the lists of the facets inside and outside of its ridge. The first
    /// entry of the list `inner` is the candidate that was inserted.
    fn fill_list(&self, facet: u32, support: Support, inner: &[u32], lists: &mut ConflictLists) {
        let mut kept = lists.spare.pop().unwrap_or_default();
        kept.clear();
        let (a, b) = (&inner[1..], lists.lists[support.outer as usize].as_slice());
        let (mut i, mut j) = (0, 0);
        loop {
            let (q, is_common) = match (a.get(i), b.get(j)) {
                (None, None) => break,
                (Some(&x), Some(&y)) => {
                    (i, j) = (i + usize::from(x <= y), j + usize::from(y <= x));
                    (x.min(y), x == y)
                }
                (Some(&x), None) => {
                    i += 1;
                    (x, false)
                }
                (None, Some(&y)) => {
                    j += 1;
                    (y, false)
                }
            };
            if is_common || self.is_conflict(facet, q) {
                kept.push(q);
            }
        }
        let entries = a.len() + b.len();
        let count = lists.round_mut(support.round);
        count.entries.visit_lanes(entries);
        count.kept.visit_all(&kept);
        count.facets.visit();
        count.ridges.visit_lanes(P::DIM);
        lists.rounds[facet as usize] = support.round;
        lists.lists[facet as usize] = kept;
        lists.enter(facet);
    }

    /// Returns `true` if the candidate conflicts with the facet. Exact.
    #[inline]
    fn is_conflict(&self, facet: u32, q: u32) -> bool {
        match self.planes.side(facet as usize, &candidate(&self.points, q).image.at) {
            Side::Clear => false,
            Side::Conflict | Side::InCavity => true,
            Side::Undecided => {
                let corners = Corners { centre: self.centre, points: &self.points };
                corners.conflict(&self.link, facet, q)
            }
        }
    }
}
