//! Exact tests of the facets of a link.
//!
//! **Statement.** A candidate conflicts with a finite facet iff it lies in the perturbed circumsphere of the centre and
//! the facet. It conflicts with an infinite facet under the rule of [`conflicts_infinite`]. The *cone* of a finite
//! facet is the set of rays from the centre through it.
//!
//! **Work and depth.** O(1) predicates for each test.

use super::candidate::{Candidate, candidate};
use crate::complex::{Complex, INFINITE};
use crate::point::Point;
use crate::predicates::{Sign, conflicts_infinite, in_sphere, orientation};

/// The position of a candidate relative to the cone of a facet.
pub(super) enum Cone {
    /// In the closed cone of a finite facet.
    Inside,
    /// Strictly beyond the hull facet of an infinite facet.
    Beyond,
    Elsewhere,
}

/// The coordinates of the centre and of the link's vertices.
pub(super) struct Corners<'a, P> {
    pub(super) centre: P,
    pub(super) points: &'a [Candidate<P>],
}

impl<P: Point> Corners<'_, P> {
    /// Returns `true` if the candidate conflicts with the facet. Exact.
    #[cold]
    pub(super) fn conflict(&self, link: &Complex<P::Facet>, cell: u32, q: u32) -> bool {
        let q = candidate(self.points, q).at;
        let (points, infinite) = self.of(link, cell);
        let n = P::DIM + 1;
        match infinite {
            None => in_sphere(&points[..n], q),
            Some(slot) => {
                let (next, _) = link.neighbour(cell, slot);
                let (finite, _) = self.of(link, next);
                conflicts_infinite(&points[..n], slot + 1, &finite[..n], q)
            }
        }
    }

    /// Locates a candidate relative to the cone of a facet. Exact.
    pub(super) fn cone(&self, link: &Complex<P::Facet>, cell: u32, q: u32) -> Cone {
        let q = candidate(self.points, q).at;
        let (mut points, infinite) = self.of(link, cell);
        let n = P::DIM + 1;
        if let Some(slot) = infinite {
            points[slot + 1] = q;
            let beyond = orientation(&points[..n]) == Sign::Positive;
            return if beyond { Cone::Beyond } else { Cone::Elsewhere };
        }
        for slot in 1..n {
            let corner = std::mem::replace(&mut points[slot], q);
            if orientation(&points[..n]) == Sign::Negative {
                return Cone::Elsewhere;
            }
            points[slot] = corner;
        }
        Cone::Inside
    }

    /// Returns `true` if the facet is finite, and the ray from the centre away from a candidate lies in its closed cone. Exact.
    pub(super) fn is_opposite(&self, link: &Complex<P::Facet>, cell: u32, q: u32) -> bool {
        let q = candidate(self.points, q).at;
        let (mut points, infinite) = self.of(link, cell);
        let n = P::DIM + 1;
        infinite.is_none()
            && (1..n).all(|slot| {
                let corner = std::mem::replace(&mut points[slot], q);
                let sign = orientation(&points[..n]);
                points[slot] = corner;
                sign != Sign::Positive
            })
    }

    /// Returns the points of `(centre, facet)`, and the slot of infinity in the facet.
    fn of(&self, link: &Complex<P::Facet>, cell: u32) -> ([P; 4], Option<usize>) {
        let mut points = [self.centre; 4];
        let mut infinite = None;
        for (slot, &v) in link.cell(cell).as_ref().iter().enumerate() {
            if v == INFINITE {
                infinite = Some(slot);
            } else {
                points[slot + 1] = candidate(self.points, v).at;
            }
        }
        (points, infinite)
    }
}
