//! The star builder in dimensions 4 to 6.
//!
//! **Statement.** As in [`super::builder`] and [`super::change`], with the link of [`super::general`]. All candidates are added
//! in order of distance.
//!
//! **Work and depth.** As in [`super::general`], plus a sort of the candidates.

use super::builder::StarBuilder;
use super::change::Extended;
use super::general::CREATED;
use crate::cost::Cost;
use crate::point::{Point, Simplex};
use crate::predicates::ExactTests;

/// Number of candidates between two tests that may end the construction.
const CHECK_INTERVAL: usize = 4;

impl<P: Point> StarBuilder<P> {
    /// Implements [`StarBuilder::build`].
    pub(super) fn build_general(
        &mut self,
        table: &[P],
        centre: u32,
        candidates: &[u32],
        cost: &mut Cost,
    ) -> bool {
        let exact = ExactTests::so_far();
        self.centre = table[centre as usize];
        self.removed.clear();
        self.removers.clear();
        self.order.clear();
        self.order.extend(candidates.iter().filter(|&&i| i != centre));
        self.sort_by_distance(table, cost);
        self.order.dedup();
        let star = &mut self.general;
        star.begin(table, self.centre, self.order.iter().copied());
        let spans = star.start(cost);
        for q in 0..if spans { star.vertices.len() } else { 0 } {
            if star.frame_at_start(q) {
                continue;
            }
            let checks_reach = q.is_multiple_of(CHECK_INTERVAL);
            star.insert(q as u32, checks_reach, cost, |_| {});
            if checks_reach && star.are_out_of_reach(q + 1) {
                break;
            }
        }
        cost.charge_exact_tests(exact.since());
        spans
    }

    /// Implements [`StarBuilder::extend`] for the candidates in `order`. The vertices of the link are numbered by their
    /// positions in `known`, whose first entry is infinity.
    pub(super) fn extend_general(
        &mut self,
        table: &[P],
        (link, places): (&[P::Facet], &[u32]),
        known: &[u32],
        cost: &mut Cost,
    ) -> Extended {
        let exact = ExactTests::so_far();
        self.removed.clear();
        self.removers.clear();
        self.sort_by_distance(table, cost);
        let star = &mut self.general;
        star.begin(table, self.centre, known[1..].iter().chain(&self.order).copied());
        let mut loading = cost.fresh();
        let [mut facets, mut joining] = [loading.sweep(), loading.sweep()];
        facets.visit_all(known);
        facets.visit_lanes(link.len());
        joining.visit_lanes(2 * P::DIM * link.len());
        loading.charge_sweeps([facets, joining]);
        if !self.keeps_stars {
            cost.then(loading);
        }
        for (origin, vertices) in (0u32..).zip(places.chunks_exact(P::DIM)) {
            let mut facet = P::Facet::splat(0);
            for (v, place) in facet.as_mut().iter_mut().zip(vertices) {
                *v = place.wrapping_sub(1);
            }
            star.push(facet, origin);
        }
        if !star.is_closed() {
            star.facets.clear();
            return Extended::Open;
        }
        let (removed, removers) = (&mut self.removed, &mut self.removers);
        for q in known.len() - 1..star.vertices.len() {
            let id = star.vertices[q].id;
            star.insert(q as u32, false, cost, |origin| {
                if origin != CREATED {
                    removed.push(origin);
                    removers.push(id);
                }
            });
        }
        cost.charge_exact_tests(exact.since());
        if self.removed.is_empty() { Extended::Same } else { Extended::Changed }
    }

    /// Implements [`StarBuilder::facets`].
    pub(super) fn general_facets(&self, out: &mut Vec<P::Facet>) {
        out.extend(self.general.facets.iter().map(|facet| self.general.named(&facet.vertices)));
    }

    /// Implements [`StarBuilder::created_facets`].
    pub(super) fn general_created(&self, out: &mut Vec<P::Facet>) {
        let created = self.general.facets.iter().filter(|facet| facet.origin == CREATED);
        out.extend(created.map(|facet| self.general.named(&facet.vertices)));
    }

    /// Implements [`StarBuilder::link_size`].
    pub(super) fn general_size(&self) -> usize {
        self.general.facets.len()
    }
}
