//! Sampled stars, and what each alpha does for them.
//!
//! The candidates of a sampled star are its nearest points, at most [`MOST_CANDIDATES`]. The radius of the ball of a
//! candidate is its distance to the nearest other candidate or to the sampled point. It is exact near the sampled point and
//! an upper bound elsewhere. An alpha certifies a hidden point if its graph joins the point to all corners of its cover, which take
//! the place of the link. Beyond the last candidate, the number of edges is extrapolated by volume.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::Cost;
use septet_geometry::hull::StarBuilder;
use septet_geometry::measure::conflict_reach2;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::{Point, dist2};
use septet_protocol::message::AlphaCounts;

use super::rule::ALPHAS;
use crate::config::Family;
use crate::neighbours::results::Nearest;
use crate::state::cells::finite_cell;
use crate::state::table::Table;

/// The largest number of points that a sampled star searches for, in the plane, in space and in dimensions 4 to 6.
pub(super) const MOST_CANDIDATES: [u32; 5] = [30, 60, 120, 240, 480];

/// Builds the stars of a sample.
pub(super) struct Sampled<'a, P: Point> {
    table: &'a Table<P>,
    family: Family,
    /// The largest weight of all points; 0 without weights.
    heaviest: f64,
    builder: StarBuilder<P>,
    facets: Vec<P::Facet>,
}

/// The candidate of a sampled star, with the smallest alpha whose graph joins it to the sampled point.
struct Candidate {
    point: u32,
    alpha: f64,
}

impl<'a, P: Point> Sampled<'a, P> {
    pub(super) fn new(table: &'a Table<P>, (family, heaviest): (Family, f64)) -> Self {
        Sampled { table, family, heaviest, builder: StarBuilder::default(), facets: Vec::new() }
    }

    /// Returns the counts of a star. `radius2` is the squared radius that was searched.
    pub(super) fn counts(&mut self, nearest: Nearest<'_>, radius2: f64, cost: &mut Cost) -> [AlphaCounts; 4] {
        let positions = self.table.positions();
        let at = positions[nearest.point as usize];
        let distances2 = cost.map(nearest.list, |&q| dist2(positions[q as usize], at));
        let nearest2 = cost.reduce(&distances2, f64::INFINITY, |least, &d2| f64::min(least, d2));
        // A truncated list is complete only up to its last point.
        let is_whole = nearest.list.len() < MOST_CANDIDATES[P::DIM - 2] as usize;
        let known2 = if is_whole { radius2 } else { nearest.kth2 };
        let candidates = self.candidates(nearest, nearest2, cost);
        let spans = self.builder.build(positions, nearest.point, nearest.list, cost);
        self.facets.clear();
        if spans {
            self.builder.facets(&mut self.facets);
        }
        let cover = self.builder.cover();
        let link = cover.map_or_else(|| self.link(), |cover| cover.as_ref().to_vec());
        let needed = if cover.is_some() {
            let of_cover = candidates.iter().filter(|candidate| link.contains(&candidate.point));
            Some(of_cover.fold(0.0, |most: f64, candidate| most.max(candidate.alpha)))
        } else {
            self.certifying_alpha(nearest.point, known2).map(|most2| (most2 / nearest2).sqrt())
        };
        let of_alpha = |alpha: f64| {
            let is_edge = |candidate: &&Candidate| candidate.alpha <= alpha;
            let edges = candidates.iter().filter(is_edge).count() as f64;
            let beyond = (alpha * alpha * nearest2 / known2).max(1.0).powi(P::DIM as i32).sqrt();
            let is_missing =
                |candidate: &&Candidate| !is_edge(candidate) && link.binary_search(&candidate.point).is_ok();
            AlphaCounts {
                certified: u64::from(needed.is_some_and(|needed| needed <= alpha)),
                edges: (edges * beyond.min(1e6)).round() as u64,
                missing: candidates.iter().filter(is_missing).count() as u64,
            }
        };
        cost.map(&ALPHAS, |&alpha| of_alpha(alpha)).try_into().unwrap_or_default()
    }

    /// Returns the candidates with the alphas that join them.
    fn candidates(&self, nearest: Nearest<'_>, nearest2: f64, cost: &mut Cost) -> Vec<Candidate> {
        let positions = self.table.positions();
        let at = positions[nearest.point as usize];
        let all = |_| f64::INFINITY;
        let around = nearest_direct(positions, nearest.list, nearest.list, 1, all, cost);
        let pairs: Vec<(u32, f64)> =
            nearest.list.iter().copied().zip(around.iter().map(|(kth2, _)| kth2)).collect();
        cost.map(&pairs, |&(point, of_others2)| {
            let d2 = dist2(positions[point as usize], at);
            let own2 = of_others2.min(d2);
            let (least, most) = (own2.min(nearest2).sqrt(), own2.max(nearest2).sqrt());
            let alpha = match self.family {
                Family::Density => d2.sqrt() / least,
                Family::Overlap => (d2.sqrt() - most) / least,
            };
            Candidate { point, alpha }
        })
    }

    /// Returns the square of the largest distance at which a point may conflict with the star, if the star is bounded and
    /// proved by the ball of squared radius `known2`.
    fn certifying_alpha(&self, point: u32, known2: f64) -> Option<f64> {
        let mut most2: f64 = 0.0;
        for facet in &self.facets {
            if facet.as_ref().contains(&INFINITE) {
                return None;
            }
            let cell = finite_cell::<P>(point, facet)?;
            let corners: Vec<P> = cell.as_ref().iter().map(|&v| self.table.positions()[v as usize]).collect();
            most2 = most2.max(conflict_reach2(&corners, self.heaviest));
        }
        (!self.facets.is_empty() && most2 <= known2).then_some(most2)
    }

    /// Returns the finite vertices of the link, in order.
    fn link(&self) -> Vec<u32> {
        let mut link: Vec<u32> = self.facets.iter().flat_map(AsRef::as_ref).copied().collect();
        link.sort_unstable();
        link.dedup();
        link.retain(|&v| v != INFINITE);
        link
    }
}
