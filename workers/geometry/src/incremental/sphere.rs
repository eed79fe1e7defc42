//! Rounded circumspheres, which decide nearly every question whether a point conflicts with a cell.
//!
//! **Statement.** A cell keeps the centre and the radius of its circumsphere in single precision, in
//! coordinates that have the points' median as origin and a power of two as unit. A point lies inside
//! if its distance to the rounded centre is below the rounded radius by more than the bound below,
//! outside if it is above by more; else the exact predicates are asked. A cell without a sphere (one
//! with the infinite vertex, or too flat for the bound) has a radius that is not a number: it answers
//! neither.
//!
//! **Bound.** Let `u = 2^-53`, `h = 2^-24`, `C` and `R` the true centre and radius of a cell with a
//! vertex at the origin and vectors `a, b, c` to the others, `A` the product of their lengths, `(w, v)` as
//! computed by [`Point::sphere_plane`], so that the centre is `v / 2w`. As in [`crate::hull`], `w` is
//! wrong by at most `42 u A` and `v` by at most `42 u A (|a| + |b| + |c|) <= 42 u A 6 R`, a chord being at
//! most a diameter. So with `t = 42 u A / |w|` the computed centre is wrong by at most
//! `3 t R + t R = 4 t R`. A sphere is kept only if `|w| > 2^-18 A`: then `4 t < 2^-27`. Rounding to
//! single precision moves the centre by at most `h` times its distance to the origin, and the radius by
//! at most `h` of itself, or `3 h` with its last bit cleared. For a point `x`, at rounded distance `d`
//! from the rounded centre, that distance to the origin is at most `|x| + d`. Together, `x` is inside if
//! `d < r - h (|x| + r) - (3 + 1/8) h r`, and outside if `d > r + h (|x| + d) + (3 + 1/8) h r`. Both follow
//! from the distance of `d` to `r` being more than `t = (1 + 2^-10) h |x| + 5 h r`, and this from
//! `|d^2 - r^2| > t (2 r + t)`. What is left of `5 h r` (more than `h r / 2`) covers the roundings of the
//! comparison, which are below `16 u` of `d^2` and `r^2`; a constant of `2^-140` covers the centres so
//! near the origin that their coordinates are subnormal. Radii outside `2^-100 .. 2^60` are not kept, so
//! nothing overflows; nor are determinants below `2^-300`, so no underflow matters.
//!
//! **Departures.** The median is that of a sample: any origin is right, and one where points are
//! dense makes the bound small where cells are.

use super::cells::Cell;
use crate::point::{Point, Simplex};

/// Mark of a cell that is no longer, or soon no longer, in the complex.
pub(super) const REMOVED: u32 = 1 << 31;

/// Mark of a cell that the exact predicates found free of conflict with the present point.
pub(super) const KEPT: u32 = 1;

/// The radius of a cell without a sphere: not a number.
pub(super) const NO_SPHERE: u32 = 0x7fc0_0000;

/// Rounding of single precision.
const SINGLE: f64 = 1.0 / (1u32 << 24) as f64;

/// The part of the bound that grows with the distance from the origin, the part that grows with the
/// radius, and the constant part.
const FAR: f64 = SINGLE * (1.0 + 1.0 / 1024.0);
const WIDE: f64 = SINGLE * 5.0;
const TINY: f64 = 1.0 / (1u128 << 70) as f64 / (1u128 << 70) as f64;

/// The square of the flattest shape that has a sphere, `2^-36`, and of the least determinant, `2^-600`.
const FLATTEST: f64 = 1.0 / (1u64 << 36) as f64;
const LEAST: f64 = f64::from_bits((1023 - 600) << 52);

/// Radii that are kept.
const RADII: std::ops::Range<f64> = f64::from_bits((1023 - 100) << 52)..f64::from_bits((1023 + 60) << 52);

/// Points looked at for the median.
const SAMPLE: usize = 255;

/// The coordinates of the spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<P> {
    origin: P,
    scale: f64,
}

/// A point as it is compared with spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query<P> {
    /// The point in the coordinates of the spheres.
    pub(super) at: P,
    /// The part of the bound that does not depend on the sphere.
    slack: f64,
}

/// The power of a point with respect to a rounded sphere, and the bound of its error. Not numbers for
/// a cell without a sphere: then no comparison holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Power {
    pub(super) value: f64,
    pub(super) bound: f64,
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
        Frame { origin, scale: f64::from_bits((2046 - exponent) << 52) }
    }

    /// A point as it is compared with spheres.
    #[inline]
    pub(super) fn query(&self, q: P) -> Query<P> {
        let at = (q - self.origin) * self.scale;
        Query { at, slack: FAR * at.norm2().sqrt() + TINY }
    }

    /// The vector between two points in the coordinates of the spheres.
    #[inline]
    pub(super) fn between(&self, from: P, to: P) -> P {
        (to - from) * self.scale
    }

    /// The circumsphere of a cell in the coordinates of the points: the centre, and the square of a
    /// radius that reaches at least as far as the cell's ball does. `None` for a cell without a sphere.
    pub(super) fn ball(&self, sphere: &P::Cell) -> Option<(P, f64)> {
        let at = centre::<P>(sphere);
        let radius = f64::from(f32::from_bits(sphere.as_ref()[P::DIM] & !(REMOVED | KEPT)));
        if radius.is_nan() {
            return None;
        }
        let centre = self.origin + at / self.scale;
        let reach = radius * (1.0 + WIDE) + FAR * at.norm2().sqrt() + TINY;
        let reach =
            reach / self.scale + 4.0 * f64::EPSILON * (centre.norm2().sqrt() + self.origin.norm2().sqrt());
        Some((centre, reach * reach * (1.0 + 4.0 * f64::EPSILON)))
    }
}

#[inline]
fn centre<P: Point>(sphere: &P::Cell) -> P {
    let mut at = P::default();
    for i in 0..P::DIM {
        at.set_coord(i, f64::from(f32::from_bits(sphere.as_ref()[i])));
    }
    at
}

impl<P: Point> Query<P> {
    /// The power of the point with respect to a cell's sphere. The cell is not marked as removed.
    #[inline]
    pub(super) fn power(&self, cell: &Cell<P::Cell>) -> Power {
        let distance2 = (centre::<P>(&cell.sphere) - self.at).norm2();
        let radius = f64::from(f32::from_bits(cell.radius()));
        let t = radius * WIDE + self.slack;
        Power { value: distance2 - radius * radius, bound: t * (radius + radius + t) }
    }

    /// The rounded sphere through this point and the ends of `rel`, vectors from it (as by
    /// [`Frame::between`]); the cell is positive in this order. `lengths2` is the product of their squares.
    #[inline]
    pub(super) fn sphere(&self, rel: &[P], lengths2: f64) -> P::Cell {
        let (w, v) = P::sphere_plane(rel);
        let from = v * (0.5 / w);
        let radius = from.norm2().sqrt();
        let sound = w * w > FLATTEST * lengths2 && w * w > LEAST && RADII.contains(&radius);
        let at = self.at + from;
        let mut sphere = P::Cell::splat(0);
        for i in 0..P::DIM {
            sphere.as_mut()[i] = (at.coord(i) as f32).to_bits();
        }
        sphere.as_mut()[P::DIM] = if sound { (radius as f32).to_bits() & !KEPT } else { NO_SPHERE };
        sphere
    }
}
