//! Updating a star by further candidates.
//!
//! **Statement.** The hull of two sets of candidates is the hull of the first set's hull vertices and the second set. A
//! star can therefore be updated from its link, without rebuilding it. The link is loaded as a complex, and the other
//! candidates are added as in [`super`].
//!
//! **Work and depth.** For `l` facets and `m` further candidates, the link's vertices are found in O(log l) steps, and
//! its facets and adjacency in O(1). Then each of the `m` candidates takes one sweep. Work O((l + m) log(l + m) + m l).

use super::builder::{StarBuilder, enter};
use super::candidate::Candidate;
use super::planes::Side;
use crate::complex::INFINITE;
use crate::cost::Cost;
use crate::point::{Point, Simplex};
use crate::predicates::ExactTests;
use crate::simd::widest;

/// The effect of further candidates on a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extended {
    /// The link is unchanged. Either no candidate conflicts, or no candidate is new. If no candidate is new, the link
    /// was not checked for closedness.
    Same,
    /// Facets were removed and created.
    Changed,
    /// The link is empty, or it is not a closed complex and some candidate is new. The star was not updated.
    Open,
}

impl<P: Point> StarBuilder<P> {
    /// Builds the star of `table[centre]` from `link`, its link among earlier candidates, and from the new candidates
    /// `added`. Candidates are positions in `table` in any order; repetitions and the centre are ignored. If the link
    /// changes, [`StarBuilder::facets`] then returns the facets that [`StarBuilder::build`] would produce: none if the centre
    /// is hidden.
    pub fn extend(
        &mut self,
        table: &[P],
        centre: u32,
        link: &[P::Facet],
        added: &[u32],
        cost: &mut Cost,
    ) -> Extended {
        self.centre = table[centre as usize];
        self.cover = None;
        self.positions.make_room(table.len());
        let mut numbers = Vec::with_capacity(1 + P::DIM * link.len() + added.len());
        numbers.push(INFINITE);
        numbers.extend_from_slice(bytemuck::cast_slice(link));
        let entries = numbers.len();
        numbers.extend(added.iter().filter(|&&v| v != centre));
        let mut loading = cost.fresh();
        let distinct = loading.relabel(&mut numbers, &mut self.positions);
        let known = numbers[..entries].iter().fold(0, |most, &place| most.max(place)) as usize + 1;
        if self.keeps_stars {
            let mut both = cost.sweep();
            both.visit_all(&distinct[1..known]);
            both.visit_all(added);
            cost.charge_distinct(both);
        } else {
            cost.then(loading);
        }
        self.order.clear();
        self.order.extend_from_slice(&distinct[known..]);
        if self.order.is_empty() && !link.is_empty() {
            return Extended::Same;
        }
        if P::DIM > 3 {
            return self.extend_general(table, (link, &numbers[1..entries]), &distinct[..known], cost);
        }
        self.take_points(table, &distinct[..known], cost);
        let mut loading = cost.fresh();
        let is_closed = self.load(link, &numbers[1..entries], &mut loading);
        if !self.keeps_stars {
            cost.then(loading);
        }
        if !is_closed {
            self.link.clear();
            return Extended::Open;
        }
        let exact = ExactTests::so_far();
        if self.are_many(self.order.len()) {
            self.insert_at_random(known as u32 - 1, cost);
        } else {
            self.insert_in_order(known as u32 - 1, cost);
        }
        cost.charge_exact_tests(exact.since());
        if self.removed.is_empty() { Extended::Same } else { Extended::Changed }
    }

    /// Adds the points from number `from` on, one by one.
    fn insert_in_order(&mut self, from: u32, cost: &mut Cost) {
        widest(
            #[inline(always)]
            || {
                for q in from..self.points.len() as u32 - 1 {
                    self.insert(q, false, cost);
                    if P::IS_WEIGHTED && self.link.is_empty() {
                        break;
                    }
                }
            },
        );
    }

    /// Appends to `out` the facets that the last [`StarBuilder::extend`] created.
    pub fn created_facets(&self, out: &mut Vec<P::Facet>) {
        if P::DIM > 3 {
            return self.general_created(out);
        }
        let is_old = |cell: &u32| self.loaded.get(*cell as usize) == Some(&false);
        out.extend(self.link.live_cells().filter(|cell| !is_old(cell)).map(|cell| self.named(cell)));
    }

    /// Returns the candidates that removed the facets, in the same order. Each conflicts with its facet.
    pub fn removers(&self) -> &[u32] {
        &self.removers
    }

    /// Returns the positions, in the given link, of the facets that were removed, in the order of their removal.
    pub fn removed_facets(&self) -> &[u32] {
        &self.removed
    }

    /// Sets `points` to infinity, the link's vertices, and the added candidates by distance or, if
    /// there are many, by random rank.
    fn take_points(&mut self, table: &[P], vertices: &[u32], cost: &mut Cost) {
        if self.are_many(self.order.len()) {
            self.sort_by_rank(table, cost);
        } else {
            self.sort_by_distance(table, cost);
        }
        self.points.clear();
        self.points.push(Candidate::infinity());
        let mut sweep = cost.sweep();
        for &id in &vertices[1..] {
            self.points.push(Candidate::of(table, id, self.centre));
        }
        if !self.keeps_stars {
            sweep.visit_all(&vertices[1..]);
        }
        for &id in &self.order {
            sweep.visit();
            self.points.push(Candidate::of(table, id, self.centre));
        }
        cost.charge_sweep(sweep);
    }

    /// Loads the link as a complex, with the planes of its facets. Returns `false` if it is empty or not closed.
    fn load(&mut self, link: &[P::Facet], positions: &[u32], cost: &mut Cost) -> bool {
        let mut facets = vec![P::Facet::splat(0); link.len()];
        let mut sweep = cost.sweep();
        sweep.visit_lanes(link.len());
        for (v, place) in bytemuck::cast_slice_mut(&mut facets).iter_mut().zip(positions) {
            *v = place.wrapping_sub(1);
        }
        cost.charge_sweep(sweep);
        // The counted machine enters all ridges and then looks up all of them. A processor either enters a ridge or
        // looks it up.
        let mut joining = cost.sweep();
        joining.visit_lanes(2 * P::DIM * link.len());
        cost.charge_sweep(joining);
        if link.is_empty() || !self.link.load(&facets) {
            return false;
        }
        self.loaded.clear();
        self.loaded.resize(link.len(), false);
        self.removed.clear();
        self.removers.clear();
        self.enter_loaded();
        true
    }

    /// Computes the planes of all facets.
    fn enter_loaded(&mut self) {
        let longest =
            |points: &[Candidate<P>]| points.iter().fold(0.0, |most: f64, p| most.max(p.image.length));
        let added = self.points.len() - self.order.len();
        self.planes.clear(longest(&self.points));
        let slots = self.link.slots();
        let room = self.planes.make_room(slots as usize);
        self.sides.clear();
        self.sides.resize(room, Side::Clear);
        let to_come = longest(&self.points[added..]);
        for facet in 0..slots {
            enter(&mut self.planes, &self.points, facet, self.link.cell(facet), to_come);
        }
    }
}
