//! Spheres and planes as separators: their side rule, their crossing test, and their encoding for messages and reports.
//!
//! **Statement.** The side of a point is the sign of one floating-point expression, so it is the same on every worker.
//! The crossing test is one-sided: it may report a crossing that does not exist, but never misses one
//! ([`Quadric::crosses`]).
//!
//! **Work and depth.** O(1) for each test.

use crate::point::{Array, Point};
use crate::simd::widest;

/// The two sides of a separator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// The side where the separator's function is negative.
    Interior,
    /// The side where it is positive or zero, including the surface itself.
    Exterior,
}

impl Side {
    /// Returns the other side.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Side::Interior => Side::Exterior,
            Side::Exterior => Side::Interior,
        }
    }
}

/// The surface `S = { x : a |y|^2 + b . y + c = 0 }` with `y = (x - origin) * unit`: a sphere, or a plane if `a = 0`.
///
/// `unit` is a power of two, so computing `y` rounds only in one subtraction for each coordinate. The coefficients are
/// scaled such that the gradient has length about 1 on `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadric<P> {
    pub(super) origin: P,
    pub(super) unit: f64,
    pub(super) a: f64,
    pub(super) b: P,
    pub(super) c: f64,
}

/// A separator in the form used by reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface<P> {
    /// A sphere (in the plane, a circle).
    Sphere {
        /// Centre of the sphere.
        centre: P,
        /// Radius of the sphere.
        radius: f64,
        /// Whether the interior child lies inside the ball.
        ball_is_interior: bool,
    },
    /// A plane (in the plane, a line). The interior child lies where `normal . x < offset`.
    Plane {
        /// Unit normal vector.
        normal: P,
        /// Offset of the plane along the normal.
        offset: f64,
    },
}

/// Number of places for the coordinates of a vector in the encoding of a separator: that of space, also in the plane.
pub(super) const fn places<P: Point>() -> usize {
    if P::DIM > 3 { P::DIM } else { 3 }
}

/// Relative slack of the crossing test: 128 unit roundoffs, derived at [`Quadric::crosses`].
const SLACK: f64 = 64.0 * f64::EPSILON;
/// Absolute slack for underflow in products.
const TINY: f64 = 1e-300;

impl<P: Point> Quadric<P> {
    /// Creates the axis-aligned cut at a coordinate. A point is interior iff its coordinate `axis` is less than `at`.
    /// This test is exact, because the difference of two floats has an exact sign and every other term is zero.
    pub fn plane(axis: usize, at: f64) -> Self {
        let (mut origin, mut b) = (P::splat(0.0), P::splat(0.0));
        origin.set_coord(axis, at);
        b.set_coord(axis, 1.0);
        Quadric { origin, unit: 1.0, a: 0.0, b, c: 0.0 }
    }

    /// Creates the axis-aligned cut half-way between two coordinates, or at the higher one if the midpoint rounds to
    /// the lower one. Points at `high` are exterior. Points at `low` are interior, unless `low` equals `high`.
    pub(super) fn between(axis: usize, low: f64, high: f64) -> Self {
        let middle = 0.5 * low + 0.5 * high;
        Self::plane(axis, if low < middle && middle <= high { middle } else { high })
    }

    /// Creates the surface with these coefficients in the frame `(origin, unit)`, scaled to unit gradient. Returns
    /// `None` if the coefficients do not describe a sphere or plane, or if rounding prevents the scaling.
    pub(super) fn from_coefficients(origin: P, unit: f64, a: f64, b: P, c: f64) -> Option<Self> {
        let gradient = (b.norm2() - 4.0 * a * c).sqrt();
        if gradient > 0.0 && gradient < f64::INFINITY {
            let own = Quadric { origin, unit, a: a / gradient, b: b / gradient, c: c / gradient };
            let gradient2 = own.b.norm2() - 4.0 * own.a * own.c;
            let finite = own.a.is_finite() && own.c.is_finite();
            (finite && gradient2 > 0.5 && gradient2 < 2.0).then_some(own)
        } else {
            None
        }
    }

    #[inline(always)]
    pub(super) fn local(&self, x: P) -> P {
        (x - self.origin) * self.unit
    }

    #[inline(always)]
    pub(super) fn value(&self, y: P) -> f64 {
        let linear = self.b.dot(y);
        // The square may overflow, so a plane must not use it.
        let square = if self.a == 0.0 { 0.0 } else { self.a * y.norm2() };
        square + linear + self.c
    }

    /// Returns the side of a point: the sign of one floating-point expression, equal on all workers.
    #[inline]
    pub fn side(&self, x: P) -> Side {
        if self.value(self.local(x)) < 0.0 { Side::Interior } else { Side::Exterior }
    }

    /// Returns `true` if the closed ball may cross or touch `S`.
    ///
    /// **Guarantee.** Let `z` be any point whose distance from `x` is at most `radius`, up to 8 unit roundoffs in the
    /// measurement of that distance. If `x` and `z` lie on different sides ([`Quadric::side`]), the function returns
    /// `true`. It also returns `true` if the radius is infinite or NaN.
    ///
    /// **Derivation.** Let `f` be the exact function of the stored coefficients, and `s` the sign of the computed value
    /// at `x`. Let `g = |grad f(y)|`, and let `rho` be the radius in local units.
    ///
    /// 1. By Taylor's formula, which is exact here, a point `z` of the ball at distance `t` has
    ///    `s f(z) >= s f(y) - t g + s a t^2`.
    /// 2. If `s a <= 0` or `2 |a| rho < g`, the right side is at least `m := s f(y) - rho g + s a rho^2`. Otherwise the
    ///    ball contains the centre of the sphere, and the function returns `true`.
    /// 3. The computed side of `z` can differ from that of `x` only if `s f(z)` is at most the rounding error at `z`.
    ///
    /// **Rounding.** Let `u = 2^-53`, `Y = |y|_1 + rho` and `M = |a| Y^2 + sum |b_i| (|y_i| + rho) + |c|`. The errors
    /// are at most:
    ///
    /// - `11 u M` for the value at `y`, and the same for the value at `z`: each term passes at most `d + 5 <= 11`
    ///   roundings;
    /// - `22 u M` for `rho g`: each coordinate of the gradient, and its length, pass at most `d + 5` roundings, and
    ///   `rho g <= 2 M`;
    /// - `2 u M` for `a rho^2`;
    /// - `12 u M` for the sums in `m`.
    ///
    /// The total is `58 u M`. The slack in the distance adds 8 unit roundoffs of `rho g + 2 |a| rho^2 <= 4 M`, that is
    /// `32 u M`. With second-order terms and the rounding of `M`, the error stays below the allowed `128 u M`. An
    /// absolute `1e-300` covers underflow. If anything overflows, the comparison yields "crosses".
    #[inline]
    pub fn crosses(&self, x: P, radius: f64) -> bool {
        let y = self.local(x);
        self.crosses_at(y, self.value(y), radius)
    }

    /// Implements [`Quadric::crosses`] for a ball whose centre is in local units, given the value at the centre.
    #[inline(always)]
    fn crosses_at(&self, y: P, value: f64, radius: f64) -> bool {
        let rho = radius * self.unit;
        let gradient = (y * (2.0 * self.a) + self.b).norm2().sqrt();
        let towards = if value < 0.0 { -self.a } else { self.a };
        let holds_centre = towards > 0.0 && 2.0 * towards * rho >= gradient * (1.0 - SLACK);
        let (mut reach, mut linear) = (rho, 0.0);
        for i in 0..P::DIM {
            reach += y.coord(i).abs();
            linear += self.b.coord(i).abs() * (y.coord(i).abs() + rho);
        }
        let size = self.a.abs() * reach * reach + linear + self.c.abs();
        let least = value.abs() - rho * gradient + towards * rho * rho;
        let clear = least > SLACK * size + TINY;
        holds_centre || !clear
    }

    /// Counts the balls whose centres are interior, and the balls that cross. Balls are pairs of centre and radius.
    pub(super) fn count_inside_and_crossing(&self, balls: &[(P, f64)]) -> [usize; 2] {
        let [inside, across] = widest(
            #[inline(always)]
            || {
                let mut counts = [0u64; 2];
                for &(x, radius) in balls {
                    let y = self.local(x);
                    let value = self.value(y);
                    // The sum never wraps, because it is at most the number of balls.
                    counts[0] = counts[0].wrapping_add(u64::from(value < 0.0));
                    counts[1] = counts[1].wrapping_add(u64::from(self.crosses_at(y, value, radius)));
                }
                counts
            },
        );
        [inside as usize, across as usize]
    }

    /// Counts the balls that cross and have interior centres, and those that cross and have exterior centres.
    pub fn count_crossing(&self, balls: impl Iterator<Item = (P, f64)>) -> [u64; 2] {
        widest(
            #[inline(always)]
            || {
                let mut crossing = [0u64; 2];
                for (x, radius) in balls {
                    let y = self.local(x);
                    let value = self.value(y);
                    let crosses = u64::from(self.crosses_at(y, value, radius));
                    let interior = u64::from(value < 0.0);
                    // The sum never wraps, because it is at most the number of balls.
                    crossing[0] = crossing[0].wrapping_add(crosses & interior);
                    crossing[1] = crossing[1].wrapping_add(crosses & !interior);
                }
                crossing
            },
        )
    }

    /// Returns the radius of a ball around `x` that does not cross: nine tenths of the distance of `x` from `S` in
    /// rounded arithmetic. Returns 0 if [`Quadric::crosses`] does not confirm the radius.
    pub fn clearance(&self, x: P) -> f64 {
        let y = self.local(x);
        let (size, curve) = (self.value(y).abs(), self.a.abs());
        // Over a distance `t`, `|f|` decreases by at most `g t + |a| t^2`.
        let gradient = (y * (2.0 * self.a) + self.b).norm2().sqrt();
        let least = 2.0 * size / (gradient + (gradient * gradient + 4.0 * curve * size).sqrt());
        let radius = 0.9 * least / self.unit;
        if self.crosses(x, radius) { 0.0 } else { radius }
    }

    /// Returns `true` if `x` lies on the given side or the ball may cross.
    #[inline]
    pub fn reaches(&self, x: P, radius: f64, side: Side) -> bool {
        let y = self.local(x);
        let value = self.value(y);
        (value < 0.0) == (side == Side::Interior) || self.crosses_at(y, value, radius)
    }

    /// Returns `true` if the surface is a sphere, and `false` for a plane.
    pub fn is_sphere(&self) -> bool {
        self.a != 0.0
    }

    /// Returns the surface and the location of its interior, rounded, for reports. Returns `None` if it exceeds the
    /// range of floats.
    pub fn surface(&self) -> Option<Surface<P>> {
        if let (Some(centre), Some(radius)) = (self.centre(), self.radius()) {
            return Some(Surface::Sphere { centre, radius, ball_is_interior: self.a > 0.0 });
        }
        let length = self.b.norm2().sqrt();
        let normal = self.b / length;
        let offset = normal.dot(self.origin) - self.c / (length * self.unit);
        offset.is_finite().then_some(Surface::Plane { normal, offset })
    }

    /// Returns the centre of the sphere, rounded, for reports. Returns `None` for a plane and beyond the range of
    /// floats.
    pub fn centre(&self) -> Option<P> {
        if !self.is_sphere() {
            return None;
        }
        let centre = self.origin + self.b * (-0.5 / self.a) / self.unit;
        (0..P::DIM).all(|i| centre.coord(i).is_finite()).then_some(centre)
    }

    /// Returns the radius of the sphere, rounded, for reports. Returns `None` for a plane and beyond the range of
    /// floats.
    pub fn radius(&self) -> Option<f64> {
        if !self.is_sphere() {
            return None;
        }
        let square = self.b.norm2() - 4.0 * self.a * self.c;
        let radius = square.sqrt() / (2.0 * self.a.abs()) / self.unit;
        radius.is_finite().then_some(radius)
    }

    /// Encodes the surface as numbers: origin (3), unit, a, b (3), c. Above three dimensions, `DIM` replaces 3.
    pub fn to_array(&self) -> P::SeparatorWords {
        let n = places::<P>();
        let mut words = P::SeparatorWords::from_fn(|_| 0.0);
        let out = words.as_mut();
        for i in 0..P::DIM {
            out[i] = self.origin.coord(i);
            out[n + 2 + i] = self.b.coord(i);
        }
        out[n] = self.unit;
        out[n + 1] = self.a;
        out[2 * n + 2] = self.c;
        words
    }

    /// Decodes [`Quadric::to_array`]. Returns `None` unless there are as many numbers, all are finite, the unit is a positive
    /// power of two and the surface is not empty.
    pub fn from_array(words: &[f64]) -> Option<Self> {
        let n = places::<P>();
        if words.len() != 2 * n + 3 {
            return None;
        }
        let (unit, a, c) = (words[n], words[n + 1], words[2 * n + 2]);
        let (origin, b) = (P::from_coords(&words[..n]), P::from_coords(&words[n + 2..2 * n + 2]));
        let power = unit >= f64::MIN_POSITIVE && unit.to_bits().trailing_zeros() >= 52;
        let surface = b.norm2() - 4.0 * a * c > 0.0;
        let finite = words.iter().all(|w| w.is_finite());
        (finite && power && surface).then_some(Quadric { origin, unit, a, b, c })
    }
}
