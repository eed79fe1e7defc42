//! Points with weights: the sites of regular triangulations (power diagrams).
//!
//! **Statement.** A site with the position `x` and the weight `w` has the height `|x|^2 - w`. The regular triangulation
//! is the lower hull of the sites at these heights, projected to the positions. A site strictly above the lower hull is
//! *hidden*; it is no vertex. Equal weights give the Delaunay triangulation. Ties are broken as without weights: by an
//! infinitesimal that raises a site the more, the larger its position ([`crate::predicates`]).
//!
//! **Ties hide no site.** Suppose that a site lies on the lower hull without being a corner of the cell that contains it.
//! Then it lies in the relative interior of a face with at least two corners. One of these corners has a larger
//! position, so it is raised more. Hence the site lies below the raised face, and the perturbed hull has it as a vertex.
//! So the set of hidden sites does not depend on the perturbation.
//!
//! **Conflicts.** A site conflicts with a cell iff it lies below the hyperplane through the lifted corners. Let `c` be
//! the centre and `r^2` the squared radius of the sphere orthogonal to the corners, `|p_i - c|^2 = r^2 + w_i`. The site
//! `(x, w)` conflicts iff `|x - c|^2 < r^2 + w`, so every conflicting site of weight at most `m` lies in the ball of
//! squared radius `r^2 + m`. A site conflicts with an infinite cell by its position, as without weights.
//!
//! **Departures.** [`Weighted`] is itself a [`Point`], with one more number in memory and in messages. Distances,
//! orders, orientations and separators use its position alone. Only the in-sphere determinant, the spheres of the kernel
//! and conflict regions use its weight.
//!
//! **Source.** Edelsbrunner and Shah, "Incremental topological flipping works for regular triangulations" (1996).

#![expect(clippy::multiple_bound_locations, reason = "the derived implementation of `Pod` repeats a bound")]

use std::ops::{Add, Div, Mul, Sub};

use bytemuck::{Pod, Zeroable};

use crate::filter::Rounded;
use crate::point::{Point, Position, Vector};

/// A position with a weight, which is a squared length. In memory, the weight follows the coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Weighted<P: Position>(P::Lifted);

impl<P: Position> Default for Weighted<P> {
    fn default() -> Self {
        Weighted(P::Lifted::default())
    }
}

impl<P: Position> Weighted<P> {
    /// Creates a site.
    #[inline]
    pub fn new(position: P, weight: f64) -> Self {
        let mut lifted = P::Lifted::default();
        for i in 0..P::DIM {
            lifted.set_coord(i, position.coord(i));
        }
        lifted.set_coord(P::DIM, weight);
        Weighted(lifted)
    }

    /// Returns the position.
    #[inline]
    pub fn position(self) -> P {
        let mut position = P::default();
        for i in 0..P::DIM {
            position.set_coord(i, self.0.coord(i));
        }
        position
    }
}

/// Returns the positions of up to four sites. The others are 0.
#[inline]
fn positions<P: Position>(sites: &[Weighted<P>]) -> [P; 4] {
    let mut all = [P::default(); 4];
    for (to, site) in all.iter_mut().zip(sites) {
        *to = site.position();
    }
    all
}

/// Returns the weights of up to four sites, less `base`. The others are 0.
#[inline]
fn weights<P: Position>(sites: &[Weighted<P>], base: f64) -> [f64; 4] {
    let mut all = [0.0; 4];
    for (to, site) in all.iter_mut().zip(sites) {
        *to = site.weight() - base;
    }
    all
}

impl<P: Position> Add for Weighted<P> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Weighted(self.0 + other.0)
    }
}

impl<P: Position> Sub for Weighted<P> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Weighted(self.0 - other.0)
    }
}

impl<P: Position> Mul<f64> for Weighted<P> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Weighted(self.0 * factor)
    }
}

impl<P: Position> Div<f64> for Weighted<P> {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        Weighted(self.0 / divisor)
    }
}

/// Sums and multiples treat the weight as one more coordinate. Inner products do not use it.
impl<P: Position> Vector for Weighted<P> {
    const LEN: usize = P::LEN;
    #[inline]
    fn splat(value: f64) -> Self {
        Weighted::new(P::splat(value), 0.0)
    }
    #[inline]
    fn coord(&self, i: usize) -> f64 {
        self.0.coord(i)
    }
    #[inline]
    fn set_coord(&mut self, i: usize, value: f64) {
        self.0.set_coord(i, value);
    }
    #[inline]
    fn dot(self, other: Self) -> f64 {
        self.position().dot(other.position())
    }
}

impl<P: Position> Point for Weighted<P> {
    const DIM: usize = P::DIM;
    const IS_WEIGHTED: bool = true;
    type Lifted = P::Lifted;
    type Facet = P::Facet;
    type Cell = P::Cell;
    type Row = P::Row;

    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_orientation(cell: &[Self]) -> Rounded {
        P::rounded_orientation(&positions(cell))
    }
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_in_sphere(cell: &[Self], q: Self) -> Rounded {
        P::rounded_power(&positions(cell), q.position(), weights(cell, q.weight()))
    }
    #[inline]
    fn sphere_plane(rel: &[Self]) -> (f64, Self) {
        let at = positions(rel);
        let mut lifts = [0.0; 3];
        for ((lift, p), site) in lifts.iter_mut().zip(at).zip(rel) {
            *lift = p.norm2() - site.weight();
        }
        let (w, v) = P::lifted_plane(&at, lifts);
        (w, Weighted::new(v, 0.0))
    }
    #[inline]
    fn hull_normal(rel: &[Self]) -> Self {
        Weighted::new(P::hull_normal(&positions(rel)), 0.0)
    }
    fn from_coords(coords: &[f64]) -> Self {
        Weighted::new(P::from_coords(coords), 0.0)
    }
    #[inline]
    fn weight(&self) -> f64 {
        self.0.coord(P::DIM)
    }
    #[inline]
    fn set_weight(&mut self, weight: f64) {
        self.0.set_coord(P::DIM, weight);
    }
}
