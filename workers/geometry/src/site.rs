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
//! **Images.** In a periodic box, the image of a site lies at `x + t` for a translation `t`. The sum is not rounded: its
//! position is the sum of a *high* part, the rounded coordinates, and a *low* part, the error of that rounding
//! ([`crate::two_parts`]). Exact stages add both. Let a rounded difference be `(high - high) + (low - low)`, let `u = 2^-53`, and let `l`
//! be the largest absolute low part.
//! - If the high difference is at most twice the whole one, `d`, it has a relative error of `u`. Otherwise the low difference
//!   is more than half of it, so the two high parts differ by a few units in the last place, and their difference is exact
//!   (Sterbenz). So the difference has an error of at most `3 u |d| + 2 u l`.
//! - Let `m` be the largest absolute difference on an axis. If `2 l <= m` on each axis, every difference has an error of at
//!   most `4 u m`, four times that of a rounded difference. The filter's bounds grow accordingly: 15 roundings more in space
//!   and 12 in the plane, so they are multiplied by 2.5. Otherwise nothing is certain.
//!
//! Separators, boxes and curves use the high part, which differs by at most `u |x|` from the position. Balls and regions are
//! larger by that.
//!
//! **Departures.** [`Weighted`] is itself a [`Point`], with more numbers in memory and in messages. Distances,
//! orders, orientations and separators use its position alone. Only the in-sphere determinant, the spheres of the kernel
//! and conflict regions use its weight.
//!
//! **Source.** Edelsbrunner and Shah, "Incremental topological flipping works for regular triangulations" (1996).

#![expect(clippy::multiple_bound_locations, reason = "the derived implementation of `Pod` repeats a bound")]

use std::ops::{Add, Div, Mul, Sub};

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

use crate::filter::Rounded;
use crate::point::{Point, Position, Vector, sealed};
use crate::two_parts::TwoParts;

/// A position with a weight, which is a squared length.
///
/// In memory: the coordinates, the weight, the low parts of the coordinates, and the largest absolute value of these.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Weighted<P: Position>([P::Lifted; 2]);

impl<P: Position> sealed::Sealed for Weighted<P> {}

impl<P: Position> Default for Weighted<P> {
    fn default() -> Self {
        Weighted([P::Lifted::default(); 2])
    }
}

/// Factor by which the bounds of the filter grow for images: at least `31 / 16`, `23 / 11`, `16 / 7`.
const LOOSER: f64 = 2.5;

/// Bound on the error of an orientation in the plane with images, relative to the product of the largest differences: two
/// products of two differences, with `4 u` for each difference and `u` for the product.
const IMAGES_IN_PLANE: f64 = 24.0 * (f64::EPSILON / 2.0);

impl<P: Position> Weighted<P> {
    /// Creates a site.
    #[inline]
    pub fn new(position: P, weight: f64) -> Self {
        let mut lifted = P::Lifted::default();
        for i in 0..P::DIM {
            lifted.set_coord(i, position.coord(i));
        }
        lifted.set_coord(P::DIM, weight);
        Weighted([lifted, P::Lifted::default()])
    }

    /// Creates the image of a site under a translation, without rounding. Returns `None` if a coordinate needs more than two
    /// floats. The sums must not overflow.
    #[must_use]
    pub fn translated(mut self, by: P) -> Option<Self> {
        for i in 0..P::DIM {
            self.set_parts(i, self.parts(i).plus(by.coord(i))?);
        }
        Some(self)
    }

    /// Returns a coordinate with its low part.
    pub fn parts(&self, i: usize) -> TwoParts {
        TwoParts { high: self.coord(i), low: self.low(i) }
    }

    /// Replaces a coordinate.
    pub fn set_parts(&mut self, i: usize, parts: TwoParts) {
        self.0[0].set_coord(i, parts.high);
        self.0[1].set_coord(i, parts.low);
        let largest = (0..P::DIM).map(|i| self.low(i).abs()).fold(0.0, f64::max);
        self.0[1].set_coord(P::DIM, largest);
    }

    /// Returns the position, rounded for an image.
    #[inline]
    pub fn position(self) -> P {
        first_of(&self.0[0])
    }
}

impl Weighted<DVec2> {
    /// Projects a point of space to two of its axes.
    pub(crate) fn projected<P: Point>(p: &P, axes: [usize; 2]) -> Self {
        let [x, y] = axes.map(|i| p.coord(i));
        let [low_x, low_y] = axes.map(|i| p.low(i));
        let lows = DVec3::new(low_x, low_y, low_x.abs().max(low_y.abs()));
        Weighted([DVec3::new(x, y, 0.0), lows])
    }
}

/// Returns the first coordinates of a vector.
#[inline]
fn first_of<P: Position>(lifted: &P::Lifted) -> P {
    let mut position = P::default();
    for i in 0..P::DIM {
        position.set_coord(i, lifted.coord(i));
    }
    position
}

/// Returns the largest absolute low part of some sites.
#[inline]
pub(crate) fn largest_low<P: Point>(sites: &[P]) -> f64 {
    sites.iter().map(Point::largest_low).fold(0.0, f64::max)
}

/// The differences of some sites to a base, and whether rounded determinants of them can be certain.
struct Differences<P> {
    rel: [P; 4],
    largest: P,
    /// Largest absolute low part.
    low: f64,
}

impl<P: Position> Differences<P> {
    #[inline]
    fn of(sites: &[Weighted<P>], base: Weighted<P>) -> Self {
        let (mut rel, mut largest) = ([P::default(); 4], P::default());
        let mut low = base.largest_low();
        for (to, &site) in rel.iter_mut().zip(sites) {
            *to = (site - base).position();
            low = low.max(site.largest_low());
            for i in 0..P::DIM {
                largest.set_coord(i, largest.coord(i).max(to.coord(i).abs()));
            }
        }
        Differences { rel, largest, low }
    }

    /// Returns a determinant of the differences with the error of images.
    #[inline]
    fn bounded(&self, rounded: Rounded) -> Rounded {
        if self.low == 0.0 {
            return rounded;
        }
        let is_bounded = (0..P::DIM).all(|i| 2.0 * self.low <= self.largest.coord(i));
        Rounded { bound: if is_bounded { LOOSER * rounded.bound } else { f64::INFINITY }, ..rounded }
    }
}

/// Returns the rounded positions of up to four sites. The others are 0.
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
        Weighted([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl<P: Position> Sub for Weighted<P> {
    type Output = Self;
    /// The difference of positions, rounded, and of weights. It has no low part.
    #[inline]
    fn sub(self, other: Self) -> Self {
        let mut low = self.0[1] - other.0[1];
        low.set_coord(P::DIM, 0.0);
        Weighted([(self.0[0] - other.0[0]) + low, P::Lifted::default()])
    }
}

impl<P: Position> Mul<f64> for Weighted<P> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Weighted([self.0[0] * factor, self.0[1] * factor])
    }
}

impl<P: Position> Div<f64> for Weighted<P> {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        Weighted([self.0[0] / divisor, self.0[1] / divisor])
    }
}

/// Sums and multiples treat the weight as one more coordinate. Inner products use neither it nor low parts.
impl<P: Position> Vector for Weighted<P> {
    const LEN: usize = P::LEN;
    #[inline]
    fn splat(value: f64) -> Self {
        Weighted::new(P::splat(value), 0.0)
    }
    #[inline]
    fn coord(&self, i: usize) -> f64 {
        self.0[0].coord(i)
    }
    /// Replaces a coordinate, but not its low part.
    #[inline]
    fn set_coord(&mut self, i: usize, value: f64) {
        self.0[0].set_coord(i, value);
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
    type Corners = [Self; 4];
    type Axes<T: Clone + std::fmt::Debug + Send + Sync> = P::Axes<T>;
    type SeparatorWords = P::SeparatorWords;

    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_orientation(cell: &[Self]) -> Rounded {
        let differences = Differences::of(cell, cell[P::DIM]);
        let rounded = P::rounded_orientation(&differences.rel);
        let Differences { largest, low, .. } = differences;
        if P::DIM == 2 && low > 0.0 {
            // The filter's bound is relative to the products themselves.
            let bound = IMAGES_IN_PLANE * largest.coord(0) * largest.coord(1);
            return differences.bounded(Rounded { bound, ..rounded });
        }
        differences.bounded(rounded)
    }
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_in_sphere(cell: &[Self], q: Self) -> Rounded {
        let differences = Differences::of(cell, q);
        let rounded = P::rounded_power(&differences.rel, P::default(), weights(cell, q.weight()));
        differences.bounded(rounded)
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
        self.0[0].coord(P::DIM)
    }
    #[inline]
    fn set_weight(&mut self, weight: f64) {
        self.0[0].set_coord(P::DIM, weight);
    }
    #[inline]
    fn low(&self, i: usize) -> f64 {
        self.0[1].coord(i)
    }
    #[inline]
    fn largest_low(&self) -> f64 {
        self.0[1].coord(P::DIM)
    }
}
