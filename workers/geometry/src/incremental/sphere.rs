//! Rounded circumspheres, which decide nearly all conflict tests.
//!
//! **Statement.** A cell stores the centre and the radius of its circumsphere in single precision. The coordinates have
//! the median of the points as origin and a power of two as unit. A point lies inside if its distance from the rounded
//! centre is less than the rounded radius by more than the following bound. It lies outside if the distance exceeds the
//! radius by more than the bound. Otherwise the exact predicates decide. A cell may have no sphere, because it has the
//! infinite vertex or is too flat for the bound. Its radius is then NaN, and neither test succeeds.
//!
//! **Spheres.** Inversion in the unit sphere around a vertex maps the spheres through it to planes. Let `a, b, c` be
//! the inverse images of the other vertices. Let `n = (b - a) x (c - a)` (in the plane, `b - a` rotated) and
//! `g = n . a`. The centre is at `n / 2g` from the vertex, and the radius is the length of that vector. A vertex on the
//! boundary of a cavity is inverted once for all new cells that contain it.
//!
//! **Bound.** Let `u = 2^-53` and `h = 2^-24`. Let `C` and `R` be the exact centre and radius, and `L` the greatest
//! length of an inverse image.
//! 1. The images have relative errors of at most `8 u` in each coordinate. So `b - a` and `c - a`, with lengths of at
//!    most `2 L`, have errors of at most `18 u L`.
//! 2. The error of `n` is at most `84 u L^2`, of which the roundings of the product are below `12 u L^2`. The error of
//!    `g` is at most `128 u L^3`. In the plane the bounds are `18 u L` and `38 u L^2`.
//! 3. A sphere is stored only if `|g| > 2^-18 L^3` (in the plane, `L^2`). Then `|n| >= |g| / L`, and `n / 2g` and its
//!    length have errors of less than `2^-27 R = h R / 8`.
//! 4. Rounding to single precision moves the centre by at most `h` times its distance from the origin. That distance is
//!    at most `|x| + d` for a point `x` at distance `d` from the centre. Rounding changes the radius by a relative
//!    error of at most `h`, or `3 h` if its last bit is cleared. It changes `x` by at most `h |x|`.
//! 5. Let `d'` be the rounded distance, `r` the rounded radius and `t' = 2 h |x| + (4 + 1/4) h r`. If `x` is not
//!    inside, `d' >= r - t'`. If `x` is not outside, `d' <= r + t'`. So it suffices that
//!    `|d'^2 - r^2| > t' (2 r + t')`.
//! 6. The comparison is computed in single precision. The errors are `3 h d'^2` and `h r^2` in the squares, and
//!    `2 h (d'^2 + r^2)` in the sums. In total they are at most `8.02 h r^2` plus `13 h` times the bound.
//! 7. Let `t = 2 (1 + 2^-10) h |x| + 10 h r`. If `t` replaces `t'`, the bound grows by more than `11 h r^2` plus `13 h`
//!    times itself, which covers both errors.
//!
//! A constant of `2^-140` covers coordinates that are subnormal in single precision. Only radii in `2^-50 .. 2^60` are
//! stored, and only points within `2^40` of the origin are compared. So nothing overflows except distances to centres
//! that are farther than any radius. Values of `g` below `2^-300` are rejected, so underflow affects no stored sphere.
//!
//! **Weights** ([`crate::site`]). Let `m` be the largest weight. A site at `x` with the weight `w` is a point at the height
//! `s = sqrt(m - w)` above `x`, in one more dimension. Spheres have their centres at height 0, and all the above holds for
//! `(x, s)` in place of `x`, with these changes:
//! - The inverse image of a vertex at `r` from the site is `r / l`, where `l = |r|^2 - d` and `d` is the difference of the
//!   weights. It is used only if `|r|^2 + |d| <= 64 |l|`, and if no coordinate of `r` is less than half the difference of
//!   high parts, so that images have differences with errors of `6 u`. Then `l` has an error of at most `15 u` times 64, and
//!   the inverse image `24 u` times 64. So the constants of steps 1 and 2 grow by `192`, and step 3 asks for
//!   `|g| > 2^-10 L^3`.
//! - The radius is the length of `n / 2g` and `s`.
//! - Squared heights are added after rounding. The errors of step 6 grow by `h d'^2 + h r^2`, to at most `9.02 h r^2` and
//!   `13 h` times the bound, which step 7 covers.
//!
//! A ball contains the sites of weight at most `m` that conflict with its cell. The high part of an image at `x` is within
//! `u |x|` of it. The bound on radii includes this for points in the extent of the frame, and the margin of `32 h` for those
//! beyond.
//!
//! **Work.** O(1) for each sphere and each test.
//!
//! **Departures.** The origin is the median of a sample. Any origin would be correct. If the origin lies where points
//! are dense, the bound is small where cells are small. The unit is the extent of the points. If some points are much farther
//! than nine tenths of the sample, the unit is the distance of those nine tenths, so that one far point does not make all
//! other spheres too small. The cells of an inserted point beyond `2^40` have no spheres.

use glam::Vec4;

use super::cells::{CLEARED, Cell, NO_SPHERE, REMOVED};
use crate::point::{Point, Simplex};
use crate::simd::larger;

/// Unit roundoff of single precision.
const SINGLE: f64 = 1.0 / (1u32 << 24) as f64;

/// The part of the bound that is proportional to the distance from the origin.
const FAR: f64 = 2.0 * SINGLE * (1.0 + 1.0 / 1024.0);
/// The part of the bound that is proportional to the radius.
const WIDE: f32 = (10.0 * SINGLE) as f32;
/// The constant part of the bound.
const TINY: f64 = power_of_two(-140);

/// The square of the smallest `|g|` of a stored sphere, relative to `L^3` (in the plane, `L^2`).
const FLATTEST: f64 = power_of_two(-36);
/// The same for points with weights.
const FLATTEST_WEIGHTED: f64 = power_of_two(-20);
/// The largest distance of an image from its high part, relative to the largest coordinate, with a margin.
const LOW: f64 = 4.0 * f64::EPSILON;
/// The largest ratio of `|r|^2 + |d|` to `|l|` for which an inverse image is used.
const CANCELLATION: f64 = 64.0;
/// The square of the smallest `|g|` of a stored sphere.
const LEAST: f64 = power_of_two(-600);

/// Smallest stored radius.
const SMALLEST: f64 = power_of_two(-50);
/// Largest stored radius.
const LARGEST: f64 = power_of_two(60);
/// Largest distance of a compared point from the origin.
const FARTHEST: f64 = power_of_two(40);
/// The extent, in typical distances from the origin, above which the unit is a typical distance.
const FAR_POINTS: f64 = power_of_two(24);

const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// Largest number of points in the sample for the median.
const SAMPLE: usize = 255;

/// The coordinate system of the spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<P> {
    origin: P,
    scale: f64,
    /// Largest distance from the origin of a point that is compared with spheres, or a larger number.
    farthest: f64,
    /// The largest weight; 0 without weights.
    heaviest: f64,
    /// Bound on the distance of an image from its high part; 0 without weights.
    low: f64,
}

/// A point in the form that is compared with spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query<P> {
    /// The point in the coordinates of the spheres.
    at: P,
    /// The point in single precision, padded with zeros.
    rounded: Vec4,
    /// The part of the bound that is independent of the sphere; NaN if the point is too far from the origin, or heavier
    /// than the heaviest site of the frame.
    slack: f32,
    /// The squared height that the weight gives to the point; 0 without weights.
    height2: f64,
}

/// The inverse image of a vertex in the unit sphere around another vertex, and the squared length of the image. NaN for
/// infinity.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Inverse<P> {
    at: P,
    length2: f64,
}

/// The power of a point with respect to a rounded sphere, and the bound on its error. Both are NaN for a cell without a
/// sphere, so that every comparison is false.
#[derive(Clone, Copy, Debug)]
pub(super) struct Power {
    pub(super) value: f32,
    pub(super) bound: f32,
}

impl Power {
    /// Returns `true` if the point certainly lies inside the sphere.
    #[inline]
    pub(super) fn is_inside(self) -> bool {
        self.value < -self.bound
    }

    /// Returns `true` if the point certainly lies outside the sphere.
    #[inline]
    pub(super) fn is_outside(self) -> bool {
        self.value > self.bound
    }
}

impl<P: Point> Frame<P> {
    /// Creates the coordinate system for a triangulation of `points`, which are finite. Balls contain conflicting points
    /// of weight at most `heaviest`.
    pub(super) fn over(points: &[P], heaviest: f64) -> Self {
        let (mut origin, mut typical) = (P::default(), 0.0f64);
        let step = points.len().div_ceil(SAMPLE).max(1);
        for i in 0..P::DIM {
            let mut sample: Vec<f64> = points.iter().step_by(step).map(|p| p.coord(i)).collect();
            if !sample.is_empty() {
                let middle = sample.len() / 2;
                let origin_here = *sample.select_nth_unstable_by(middle, f64::total_cmp).1;
                origin.set_coord(i, origin_here);
                let most = sample.len() * 9 / 10;
                let distance = |x: &f64| (x - origin_here).abs();
                sample.sort_unstable_by(|a, b| distance(a).total_cmp(&distance(b)));
                typical = typical.max(distance(&sample[most]));
            }
        }
        let (mut extent, mut largest) = (0.0f64, 0.0f64);
        for p in points {
            for i in 0..P::DIM {
                extent = extent.max((p.coord(i) - origin.coord(i)).abs());
                if P::IS_WEIGHTED {
                    largest = largest.max(p.coord(i).abs());
                }
            }
        }
        let unit = if extent > typical * FAR_POINTS { typical } else { extent };
        let exponent = (unit.to_bits() >> 52).clamp(1, 2045);
        let scale = f64::from_bits((2046 - exponent) << 52);
        // This is half the diagonal of the cube that contains the points, with a margin for rounding.
        let farthest = extent * scale * (P::DIM as f64).sqrt() * (1.0 + 1e-9);
        Frame { origin, scale, farthest: farthest.min(FARTHEST), heaviest, low: LOW * largest }
    }

    /// Extends the system to contain one more point.
    pub(super) fn extend(&mut self, q: P) {
        let distance = ((q - self.origin) * self.scale).norm2().sqrt() * (1.0 + 1e-9);
        self.farthest = larger(distance, self.farthest).min(FARTHEST);
    }

    /// Returns the largest distance of a point from the origin, in the coordinates of the points.
    pub(super) fn extent(&self) -> f64 {
        self.farthest / self.scale
    }

    /// Returns an upper bound on the radius of a finite cell's ball; NaN without a sphere. The centre of the ball is
    /// at most a radius farther from the origin than a vertex. So the bound of [`Frame::ball`] plus a small multiple
    /// of the radius covers all roundings.
    #[inline]
    pub(super) fn radius_bound(&self, sphere: &P::Cell) -> f64 {
        let radius = f64::from(Self::rounded_radius(sphere));
        let bound = (radius * (1.0 + 32.0 * SINGLE) + 2.0 * FAR * self.farthest + 2.0 * TINY) / self.scale;
        if P::IS_WEIGHTED { bound + self.low } else { bound }
    }

    /// Returns the rounded radius of a sphere without its marks; NaN for a cell without a sphere.
    #[inline]
    pub(super) fn rounded_radius(sphere: &P::Cell) -> f32 {
        f32::from_bits(sphere.as_ref()[P::DIM] & !(REMOVED | CLEARED))
    }

    /// Returns the largest rounded radius for which twice [`Frame::radius_bound`] is at most `across`, or 0 if there
    /// is no such radius. No stored radius is 0. The margin covers the roundings of both.
    pub(super) fn radius_within(&self, across: f64) -> f32 {
        let margin = (2.0 * FAR * self.farthest + 2.0 * TINY) * (1.0 + SINGLE);
        let across = if P::IS_WEIGHTED { across - 2.0 * self.low } else { across };
        let most = (0.5 * across * self.scale - margin) / (1.0 + 32.0 * SINGLE);
        ((most * (1.0 - 2.0 * SINGLE)) as f32).max(0.0)
    }

    /// Converts a point to the form that is compared with spheres.
    #[inline]
    pub(super) fn query(&self, q: P) -> Query<P> {
        let at = (q - self.origin) * self.scale;
        let mut rounded = [0.0; 4];
        for (i, x) in rounded[..P::DIM].iter_mut().enumerate() {
            *x = at.coord(i) as f32;
        }
        let height2 =
            if P::IS_WEIGHTED { (self.heaviest - q.weight()) * self.scale * self.scale } else { 0.0 };
        let distance = if P::IS_WEIGHTED { (at.norm2() + height2).sqrt() } else { at.norm2().sqrt() };
        let is_near = distance < FARTHEST && (!P::IS_WEIGHTED || height2 >= 0.0);
        let slack = if is_near { (FAR * distance + TINY) as f32 } else { f32::NAN };
        Query { at, rounded: Vec4::from_array(rounded), slack, height2 }
    }

    /// Returns the inverse image of `to` in the unit sphere around `from`, in the coordinates of the spheres.
    #[inline]
    pub(super) fn inverse(&self, from: P, to: P) -> Inverse<P> {
        let rel = (to - from) * self.scale;
        if P::IS_WEIGHTED {
            let cancels =
                |i: usize| (to.coord(i) - from.coord(i)).abs() * self.scale > 2.0 * rel.coord(i).abs();
            let is_accurate = from.largest_low().max(to.largest_low()) == 0.0 || !(0..P::DIM).any(cancels);
            let drop = if is_accurate { to.weight() - from.weight() } else { f64::NAN };
            return self.weighted_inverse(rel, drop);
        }
        let length2 = 1.0 / rel.norm2();
        Inverse { at: rel * length2, length2 }
    }

    /// Returns the inverse image of a vertex at `rel`, in the coordinates of the spheres, whose weight is larger by `drop`.
    #[inline]
    fn weighted_inverse(&self, rel: P, drop: f64) -> Inverse<P> {
        let (square, drop) = (rel.norm2(), drop * self.scale * self.scale);
        let lift = square - drop;
        let is_accurate = square + drop.abs() <= CANCELLATION * lift.abs();
        let factor = if is_accurate { 1.0 / lift } else { f64::NAN };
        Inverse { at: rel * factor, length2: square * factor * factor }
    }

    /// Returns the circumsphere of a cell in the coordinates of the points: the centre, and the square of a radius
    /// that is at least the radius of the cell's ball. Returns `None` for a cell without a sphere.
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
    /// Computes the power of the point with respect to a cell's sphere.
    #[inline]
    pub(super) fn power(&self, cell: &Cell<P::Cell>) -> Power {
        let mut sphere = [0; 4];
        sphere[..=P::DIM].copy_from_slice(cell.sphere().as_ref());
        // One vector operation suffices: the radius follows the centre, and the query has a zero in its position.
        let sphere = Vec4::from_array(sphere.map(f32::from_bits));
        let x = sphere - self.rounded;
        let [a, b, c, d] = (x * x).to_array();
        let planar = if P::IS_WEIGHTED { (a + b) + self.height2 as f32 } else { a + b };
        let value = if P::DIM == 2 { planar - c } else { planar + (c - d) };
        let radius = sphere[P::DIM].abs();
        let t = radius * WIDE + self.slack;
        Power { value, bound: t * (radius + radius + t) }
    }

    /// Computes the rounded sphere through this point and those with the inverse images `ends`.
    #[expect(clippy::needless_bitwise_bool, reason = "one branch replaces four unpredictable ones")]
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
        let radius = if P::IS_WEIGHTED {
            (from.norm2() + self.height2).sqrt()
        } else {
            normal.norm2().sqrt() * half.abs()
        };
        let flattest = if P::IS_WEIGHTED { FLATTEST_WEIGHTED } else { FLATTEST };
        let flat2 = if P::DIM == 2 { flattest * longest2 } else { flattest * longest2 * longest2 };
        let flat2 = flat2 * longest2;
        let height2 = height * height;
        let is_valid = (height2 > flat2) & (height2 > LEAST) & (radius > SMALLEST) & (radius < LARGEST);
        // The bounds on radii hold for spheres through a point that is not far.
        let is_valid = is_valid & (self.slack < f32::INFINITY);
        let at = self.at + from;
        let mut sphere = P::Cell::splat(0);
        for i in 0..P::DIM {
            sphere.as_mut()[i] = (at.coord(i) as f32).to_bits();
        }
        let radius = if is_valid { (radius as f32).to_bits() & !CLEARED } else { NO_SPHERE };
        sphere.as_mut()[P::DIM] = radius;
        sphere
    }
}
