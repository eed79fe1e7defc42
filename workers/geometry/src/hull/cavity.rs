//! The facets of a link that a candidate conflicts with.
//!
//! **Statement.** Rounded arithmetic decides most facets. If some are undecided, exact tests follow by the rule of
//! [`super`]: one test for each candidate, and tests of the undecided facets at the boundary of the growing cavity.
//!
//! **Work and depth.** One vector step over the facets, and one over the facets that rounded arithmetic leaves uncertain.

use super::builder::StarBuilder;
use super::candidate::candidate;
use super::corners::{Cone, Corners};
use super::planes::Side;
use crate::point::Point;

impl<P: Point> StarBuilder<P> {
    /// Sets `uncertain` and `sides` to the facets that the candidate may conflict with. Returns `true` if some were
    /// undecided; then `cavity` is the cavity, and otherwise `uncertain`.
    #[inline(always)]
    pub(super) fn find_cavity(&mut self, q: u32) -> bool {
        self.uncertain.clear();
        if P::IS_WEIGHTED && candidate(&self.points, q).image.length.is_nan() {
            self.uncertain.extend(self.link.live_cells());
            for &facet in &self.uncertain {
                self.sides[facet as usize] = Side::Undecided;
            }
            self.decide(q, None);
            return true;
        }
        let (mut seed, mut undecided) = (None, false);
        self.planes.each_uncertain(&candidate(&self.points, q).image.at, |facet, side| {
            self.uncertain.push(facet);
            self.sides[facet as usize] = side;
            match side {
                Side::Conflict => seed = Some(facet),
                _ => undecided = true,
            }
        });
        if undecided {
            self.decide(q, seed);
        }
        undecided
    }

    /// Forgets the sides of the last candidate.
    #[inline(always)]
    pub(super) fn clear_sides(&mut self) {
        for &facet in &self.uncertain {
            self.sides[facet as usize] = Side::Clear;
        }
    }

    /// Finds the cavity if some facets are undecided, and marks its undecided facets as conflicts.
    #[cold]
    fn decide(&mut self, q: u32, seed: Option<u32>) {
        self.cavity.clear();
        let Some(seed) = seed.or_else(|| self.conflict_among_undecided(q)) else { return };
        let corners = Corners { centre: self.centre, points: &self.points };
        self.sides[seed as usize] = Side::InCavity;
        self.cavity.push(seed);
        let mut head = 0;
        while let Some(&facet) = self.cavity.get(head) {
            head += 1;
            for slot in 0..P::DIM {
                let (next, _) = self.link.neighbour(facet, slot);
                let side = &mut self.sides[next as usize];
                if *side == Side::Undecided {
                    *side = if corners.conflict(&self.link, next, q) { Side::Conflict } else { Side::Clear };
                }
                if *side == Side::Conflict {
                    *side = Side::InCavity;
                    self.cavity.push(next);
                }
            }
        }
        for &facet in &self.cavity {
            self.sides[facet as usize] = Side::Conflict;
        }
    }

    /// Finds an undecided facet in conflict, if there is one. Requires that no decided facet conflicts.
    #[cold]
    fn conflict_among_undecided(&self, q: u32) -> Option<u32> {
        let corners = Corners { centre: self.centre, points: &self.points };
        for &cell in &self.uncertain {
            match corners.cone(&self.link, cell, q) {
                Cone::Beyond => return Some(cell),
                Cone::Inside => return corners.conflict(&self.link, cell, q).then_some(cell),
                Cone::Elsewhere => {}
            }
        }
        None
    }
}
