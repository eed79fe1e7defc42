//! Rounded circumspheres, which decide nearly every question whether a point conflicts with a cell.
//!
//! **Statement.** A cell keeps the centre and the radius of its circumsphere in single precision, in
//! coordinates that have the points' median as origin and a power of two as unit. A point lies inside
//! if its distance to the rounded centre is below the rounded radius by more than the bound below,
//! outside if it is above by more; else the exact predicates are asked. A cell without a sphere (one
//! with the infinite vertex, or too flat for the bound) has a radius that is not a number: it answers
//! neither.
//!
//! **Spheres.** Inversion in the unit sphere around a vertex turns the spheres through it into planes: with
//! the inverse images `a, b, c` of the others, `n = (b - a) x (c - a)` (in the plane `b - a` turned) and
//! `g = n . a`, the centre is `n / 2g` from the vertex and the radius its length. A vertex of the border is
//! inverted once for all new cells around it.
//!
//! **Bound.** Let `u = 2^-53`, `h = 2^-24`, `C` and `R` the true centre and radius, `L` the greatest length of an
//! inverse image. The images are computed with a relative error of `8 u` for each coordinate, so `b - a` and
//! `c - a`, at most `2 L` long, are wrong by at most `18 u L`, `n` by `84 u L^2` (the roundings of the product
//! are below `12 u L^2`) and `g` by `128 u L^3`; in the plane by `18 u L` and `38 u L^2`. A sphere is kept only if
//! `|g| > 2^-18 L^3` (in the plane `L^2`); then `|n| >= |g| / L`, and `n / 2g` and its length are wrong by
//! less than `2^-27 R = h R / 8`. Rounding to single precision moves the centre by at most `h` times its
//! distance to the origin, which is at most `|x| + d` for a point `x` at distance `d` from it; the radius by
//! at most `h` of itself, or `3 h` with its last bit cleared; `x` by at most `h |x|`. Hence if `x` is not
//! inside, the rounded distance `d'` is at least `r - t'`, if it is not outside at most `r + t'`, with
//! `t' = 2 h |x| + (4 + 1/4) h r`. So it suffices that `|d'^2 - r^2| > t' (2 r + t')`. The comparison itself
//! is made in single precision, with errors of `3 h d'^2` and `h r^2` in the squares and `2 h (d'^2 + r^2)` in
//! the sums: in all `8.02 h r^2` and `13 h` of the bound. With `t = 2 (1 + 2^-10) h |x| + 10 h r` in the place of
//! `t'` the bound grows by more than `11 h r^2` and that proportion, which covers both. A constant of `2^-140` covers
//! coordinates that are subnormal in single precision. Radii outside `2^-50 .. 2^60` are not kept and points
//! farther than `2^40` from the origin not compared, so that nothing overflows but distances to centres
//! that are farther than any radius; nor are values of `g` below `2^-300` kept, which no underflow then
//! affects.
//!
//! **Departures.** The median is that of a sample: any origin is right, and one where points are
//! dense makes the bound small where cells are.

use glam::Vec4;

use super::cells::Cell;
use crate::point::{Point, Simplex};
use crate::simd::larger;

/// Mark of a cell that is no longer, or soon no longer, in the complex.
pub(super) const REMOVED: u32 = 1 << 31;

/// Mark of a cell that the exact predicates found free of conflict with the present point.
pub(super) const CLEARED: u32 = 1;

/// The radius of a cell without a sphere: not a number.
pub(super) const NO_SPHERE: u32 = 0x7fc0_0000;

/// Rounding of single precision.
const SINGLE: f64 = 1.0 / (1u32 << 24) as f64;

/// The part of the bound that grows with the distance from the origin, the part that grows with the
/// radius, and the constant part.
const FAR: f64 = 2.0 * SINGLE * (1.0 + 1.0 / 1024.0);
const WIDE: f32 = (10.0 * SINGLE) as f32;
const TINY: f64 = power_of_two(-140);

/// The square of the flattest shape that has a sphere, and of the least determinant.
const FLATTEST: f64 = power_of_two(-36);
const LEAST: f64 = power_of_two(-600);

/// Radii that are kept, and the distance from the origin up to which points are compared.
const SMALLEST: f64 = power_of_two(-50);
const LARGEST: f64 = power_of_two(60);
const FARTHEST: f64 = power_of_two(40);

const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// Points looked at for the median.
const SAMPLE: usize = 255;

/// The coordinates of the spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<P> {
    origin: P,
    scale: f64,
    /// No point is farther from the origin.
    farthest: f64,
}

/// A point as it is compared with spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query<P> {
    /// The point in the coordinates of the spheres, and the same in single precision, zeros behind.
    at: P,
    rounded: Vec4,
    /// The part of the bound that does not depend on the sphere; not a number for a point too far away.
    slack: f32,
}

/// The inverse image of a vertex in the unit sphere around another, and its squared distance from
/// there. Not numbers for infinity.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Inverse<P> {
    at: P,
    length2: f64,
}

/// The power of a point with respect to a rounded sphere, and the bound of its error. Not numbers for
/// a cell without a sphere: then no comparison holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Power {
    pub(super) value: f32,
    pub(super) bound: f32,
}

impl Power {
    /// Does the point certainly lie inside the sphere?
    #[inline]
    pub(super) fn is_inside(self) -> bool {
        self.value < -self.bound
    }

    /// Does the point certainly lie outside?
    #[inline]
    pub(super) fn is_outside(self) -> bool {
        self.value > self.bound
    }
}

impl<P: Point> Frame<P> {
    /// The coordinates for a triangulation of `points`, which are finite.
    pub(super) fn over(points: &[P]) -> Self {
        let mut origin = P::default();
        let step = points.len().div_ceil(SAMPLE).max(1);
        for i in 0..P::DIM {
            let mut sample: Vec<f64> = points.iter().step_by(step).map(|p| p.coord(i)).collect();
            if !sample.is_empty() {
                let middle = sample.len() / 2;
                origin.set_coord(i, *sample.select_nth_unstable_by(middle, f64::total_cmp).1);
            }
        }
        let mut extent = 0.0f64;
        for p in points {
            for i in 0..P::DIM {
                extent = extent.max((p.coord(i) - origin.coord(i)).abs());
            }
        }
        let exponent = (extent.to_bits() >> 52).clamp(1, 2045);
        let scale = f64::from_bits((2046 - exponent) << 52);
        // The diagonal of the cube that holds all points, and rounding.
        Frame { origin, scale, farthest: extent * scale * (P::DIM as f64).sqrt() * (1.0 + 1e-9) }
    }

    /// Makes room for one more point.
    pub(super) fn extend(&mut self, q: P) {
        let distance = ((q - self.origin) * self.scale).norm2().sqrt() * (1.0 + 1e-9);
        self.farthest = larger(distance, self.farthest);
    }

    /// No point is farther from the origin, in the coordinates of the points.
    pub(super) fn extent(&self) -> f64 {
        self.farthest / self.scale
    }

    /// A number above the radius of a finite cell's ball, not a number without a sphere. The ball's centre is at
    /// most a radius farther from the origin than a vertex, so with [`Frame::ball`]'s bound a little more of the
    /// radius covers all of its rounding.
    #[inline]
    pub(super) fn radius_bound(&self, sphere: &P::Cell) -> f64 {
        let radius = f64::from(Self::rounded_radius(sphere));
        (radius * (1.0 + 32.0 * SINGLE) + 2.0 * FAR * self.farthest + 2.0 * TINY) / self.scale
    }

    /// The rounded radius of a sphere without its marks; not a number where there is none.
    #[inline]
    pub(super) fn rounded_radius(sphere: &P::Cell) -> f32 {
        f32::from_bits(sphere.as_ref()[P::DIM] & !(REMOVED | CLEARED))
    }

    /// The most that a rounded radius may be if twice its [`Frame::radius_bound`] is not to exceed `across`; 0, which is
    /// no sphere's radius, if there is none. What it is rounded by covers the rounding of either.
    pub(super) fn radius_within(&self, across: f64) -> f32 {
        let aside = (2.0 * FAR * self.farthest + 2.0 * TINY) * (1.0 + SINGLE);
        let most = (0.5 * across * self.scale - aside) / (1.0 + 32.0 * SINGLE);
        ((most * (1.0 - 2.0 * SINGLE)) as f32).max(0.0)
    }

    /// A point as it is compared with spheres.
    #[inline]
    pub(super) fn query(&self, q: P) -> Query<P> {
        let at = (q - self.origin) * self.scale;
        let mut rounded = [0.0; 4];
        for (i, x) in rounded[..P::DIM].iter_mut().enumerate() {
            *x = at.coord(i) as f32;
        }
        let distance = at.norm2().sqrt();
        let slack = if distance < FARTHEST { (FAR * distance + TINY) as f32 } else { f32::NAN };
        Query { at, rounded: Vec4::from_array(rounded), slack }
    }

    /// The inverse image of `to` in the unit sphere around `from`, in the coordinates of the spheres.
    #[inline]
    pub(super) fn inverse(&self, from: P, to: P) -> Inverse<P> {
        let rel = (to - from) * self.scale;
        let length2 = 1.0 / rel.norm2();
        Inverse { at: rel * length2, length2 }
    }

    /// The circumsphere of a cell in the coordinates of the points: the centre, and the square of a
    /// radius that reaches at least as far as the cell's ball does. `None` for a cell without a sphere.
    pub(super) fn ball(&self, sphere: &P::Cell) -> Option<(P, f64)> {
        let mut at = P::default();
        for i in 0..P::DIM {
            at.set_coord(i, f64::from(f32::from_bits(sphere.as_ref()[i])));
        }
        let radius = f64::from(Self::rounded_radius(sphere));
        if radius.is_nan() {
            return None;
        }
        let centre = self.origin + at / self.scale;
        let reach = radius * (1.0 + f64::from(WIDE)) + FAR * at.norm2().sqrt() + TINY;
        let rounding = 4.0 * f64::EPSILON * (centre.norm2().sqrt() + self.origin.norm2().sqrt());
        let reach = reach / self.scale + rounding;
        Some((centre, reach * reach * (1.0 + 4.0 * f64::EPSILON)))
    }
}

impl<P: Point> Query<P> {
    /// The power of the point with respect to a cell's sphere.
    #[inline]
    pub(super) fn power(&self, cell: &Cell<P::Cell>) -> Power {
        let mut sphere = [0; 4];
        sphere[..=P::DIM].copy_from_slice(cell.sphere().as_ref());
        // All together: the radius stands behind the centre, and the query has a zero there.
        let sphere = Vec4::from_array(sphere.map(f32::from_bits));
        let x = sphere - self.rounded;
        let [a, b, c, d] = (x * x).to_array();
        let value = if P::DIM == 2 { (a + b) - c } else { (a + b) + (c - d) };
        let radius = sphere[P::DIM].abs();
        let t = radius * WIDE + self.slack;
        Power { value, bound: t * (radius + radius + t) }
    }

    /// The rounded sphere through this point and those with the inverse images `ends`.
    #[expect(clippy::needless_bitwise_bool, reason = "one branch for all four, of which none is foreseeable")]
    #[inline]
    pub(super) fn sphere(&self, ends: [&Inverse<P>; 3]) -> P::Cell {
        let [a, b, c] = ends;
        let normal = P::hull_normal(&[b.at - a.at, c.at - a.at][..P::DIM - 1]);
        let height = normal.dot(a.at);
        let mut longest2 = larger(a.length2, b.length2);
        if P::DIM == 3 {
            longest2 = larger(longest2, c.length2);
        }
        let half = 0.5 / height;
        let from = normal * half;
        let radius = normal.norm2().sqrt() * half.abs();
        let flat2 = if P::DIM == 2 { FLATTEST * longest2 } else { FLATTEST * longest2 * longest2 };
        let flat2 = flat2 * longest2;
        let height2 = height * height;
        let sound = (height2 > flat2) & (height2 > LEAST) & (radius > SMALLEST) & (radius < LARGEST);
        let at = self.at + from;
        let mut sphere = P::Cell::splat(0);
        for i in 0..P::DIM {
            sphere.as_mut()[i] = (at.coord(i) as f32).to_bits();
        }
        let radius = if sound { (radius as f32).to_bits() & !CLEARED } else { NO_SPHERE };
        sphere.as_mut()[P::DIM] = radius;
        sphere
    }
}
