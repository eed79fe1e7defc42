//! The surface: its side rule, its crossing test, and its form on the wire and in reports.

use crate::point::Point;
use crate::simd::widest;

/// The two sides of a separator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// Where the separator's function is negative.
    Interior,
    /// Where it is positive or zero: a point on the surface is here.
    Exterior,
}

impl Side {
    /// The other side.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Side::Interior => Side::Exterior,
            Side::Exterior => Side::Interior,
        }
    }
}

/// `S = { x : a |y|^2 + b . y + c = 0 }` with `y = (x - origin) * unit`: a sphere, or a plane if `a = 0`.
///
/// `unit` is a power of two, so the only rounding in `y` is that of one subtraction a coordinate.
/// Coefficients are scaled such that the gradient has length about 1 on `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separator<P> {
    pub(super) origin: P,
    pub(super) unit: f64,
    pub(super) a: f64,
    pub(super) b: P,
    pub(super) c: f64,
}

/// A separator for reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface<P> {
    /// A sphere (circle).
    Sphere {
        /// Its centre.
        centre: P,
        /// Its radius.
        radius: f64,
        /// Is the interior child in the ball, not around it?
        ball_is_interior: bool,
    },
    /// A plane (line): the interior child lies where `normal . x < offset`.
    Plane {
        /// Unit normal.
        normal: P,
        /// Its offset.
        offset: f64,
    },
}

/// Numbers of a separator on the wire, in either dimension (the plane leaves two of them zero).
pub const SEPARATOR_WORDS: usize = 9;

/// Relative slack of the crossing test: 128 units of rounding, derived at [`Separator::crosses`].
const SLACK: f64 = 64.0 * f64::EPSILON;
/// Absolute slack for underflow in products.
const TINY: f64 = 1e-300;

impl<P: Point> Separator<P> {
    /// The axis-aligned cut: a point is interior iff its coordinate `axis` is less than `at`, exactly
    /// (the difference of two floats has an exact sign, and every other term is zero).
    pub fn plane(axis: usize, at: f64) -> Self {
        let (mut origin, mut b) = (P::splat(0.0), P::splat(0.0));
        origin.set_coord(axis, at);
        b.set_coord(axis, 1.0);
        Separator { origin, unit: 1.0, a: 0.0, b, c: 0.0 }
    }

    /// The axis-aligned cut half-way between two coordinates, or at the higher one: that has what is there outside, and what
    /// is at the lower one inside, unless they are equal.
    pub(super) fn between(axis: usize, low: f64, high: f64) -> Self {
        let middle = 0.5 * low + 0.5 * high;
        Self::plane(axis, if low < middle && middle <= high { middle } else { high })
    }

    /// The surface with these coefficients in the frame `(origin, unit)`, scaled to unit gradient;
    /// nothing if they describe no sphere or plane with a point to spare after rounding.
    pub(super) fn from_coefficients(origin: P, unit: f64, a: f64, b: P, c: f64) -> Option<Self> {
        let gradient = (b.norm2() - 4.0 * a * c).sqrt();
        if gradient > 0.0 && gradient < f64::INFINITY {
            let own = Separator { origin, unit, a: a / gradient, b: b / gradient, c: c / gradient };
            let again = own.b.norm2() - 4.0 * own.a * own.c;
            let finite = own.a.is_finite() && own.c.is_finite();
            (finite && again > 0.5 && again < 2.0).then_some(own)
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
        // A plane must not see the square, which may overflow.
        let square = if self.a == 0.0 { 0.0 } else { self.a * y.norm2() };
        square + linear + self.c
    }

    /// The side of a point: the sign of one fixed floating-point expression, the same everywhere.
    #[inline]
    pub fn side(&self, x: P) -> Side {
        if self.value(self.local(x)) < 0.0 { Side::Interior } else { Side::Exterior }
    }

    /// Does the closed ball cross or touch `S`, rounded towards "crosses"?
    ///
    /// **Guarantee.** If any point `z` whose distance from `x` is at most `radius` (up to 8 units of
    /// rounding in how that was measured) has another [`Separator::side`] than `x`, the answer is true.
    /// A radius that is infinite or not a number crosses.
    ///
    /// **Derivation.** Let `f` be the exact function of the stored coefficients, `s` the sign of the
    /// computed value at `x`, `g = |grad f(y)|` and `rho` the radius in local units. By Taylor,
    /// exactly, every `z` of the ball at distance `t` has
    /// `s f(z) >= s f(y) - t g + s a t^2 >= m := s f(y) - rho g + s a rho^2`, the last step if
    /// `s a <= 0` or `2 |a| rho < g` (otherwise the ball holds the sphere's centre: crosses). The
    /// computed side of `z` differs only if `s f(z)` is at most the rounding error at `z`.
    ///
    /// Rounding, with `u = 2^-53`, `Y = |y|_1 + rho`, `M = |a| Y^2 + sum |b_i| (|y_i| + rho) + |c|`: a
    /// value takes at most `d + 5 <= 8` roundings of each term, error `8 u M` at `y` and at `z` each;
    /// each coordinate of the gradient and its length at most 8, and `rho g <= 2 M`: `16 u M`;
    /// `a rho^2`: `2 u M`; the sums of `m`: `12 u M`. Together `46 u M`. With second-order terms, `M`'s
    /// own rounding and the slack in the distance (8 units of `rho g + 2 |a| rho^2 <= 4 M`: `32 u M`)
    /// this stays below the `128 u M` that is allowed; an absolute `1e-300` covers underflow. Anything
    /// that overflows compares as "crosses".
    #[inline]
    pub fn crosses(&self, x: P, radius: f64) -> bool {
        let y = self.local(x);
        self.crosses_at(y, self.value(y), radius)
    }

    /// The same of a ball by its centre in local units, and the value there.
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

    /// Of balls by their centres and radii: how many have their centres inside, and how many cross.
    pub(super) fn count_inside_and_crossing(&self, balls: &[(P, f64)]) -> [usize; 2] {
        let [inside, across] = widest(
            #[inline(always)]
            || {
                let mut counts = [0u64; 2];
                for &(x, radius) in balls {
                    let y = self.local(x);
                    let value = self.value(y);
                    // At most as many as there are balls.
                    counts[0] = counts[0].wrapping_add(u64::from(value < 0.0));
                    counts[1] = counts[1].wrapping_add(u64::from(self.crosses_at(y, value, radius)));
                }
                counts
            },
        );
        [inside as usize, across as usize]
    }

    /// Of balls by their centres and radii: how many cross with their centres inside, and how many with them outside.
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
                    // At most as many as there are balls.
                    crossing[0] = crossing[0].wrapping_add(crosses & interior);
                    crossing[1] = crossing[1].wrapping_add(crosses & !interior);
                }
                crossing
            },
        )
    }

    /// The radius of a ball around `x` that does not cross: nine tenths of its distance from `S` in rounded
    /// arithmetic, or 0 where [`Separator::crosses`] does not confirm that.
    pub fn clearance(&self, x: P) -> f64 {
        let y = self.local(x);
        let (size, curve) = (self.value(y).abs(), self.a.abs());
        // |f| falls by at most g t + |a| t^2 over a distance t.
        let gradient = (y * (2.0 * self.a) + self.b).norm2().sqrt();
        let least = 2.0 * size / (gradient + (gradient * gradient + 4.0 * curve * size).sqrt());
        let radius = 0.9 * least / self.unit;
        if self.crosses(x, radius) { 0.0 } else { radius }
    }

    /// Must `side` know of this ball: `x` lies there, or the ball crosses?
    #[inline]
    pub fn reaches(&self, x: P, radius: f64, side: Side) -> bool {
        let y = self.local(x);
        let value = self.value(y);
        (value < 0.0) == (side == Side::Interior) || self.crosses_at(y, value, radius)
    }

    /// Is it a sphere, not a plane?
    pub fn is_sphere(&self) -> bool {
        self.a != 0.0
    }

    /// The surface as people draw it, rounded, and where its interior lies; nothing beyond the range of
    /// floats.
    pub fn surface(&self) -> Option<Surface<P>> {
        if let (Some(centre), Some(radius)) = (self.centre(), self.radius()) {
            return Some(Surface::Sphere { centre, radius, ball_is_interior: self.a > 0.0 });
        }
        let length = self.b.norm2().sqrt();
        let normal = self.b / length;
        let offset = normal.dot(self.origin) - self.c / (length * self.unit);
        offset.is_finite().then_some(Surface::Plane { normal, offset })
    }

    /// Centre of a sphere, rounded, for reports; nothing for a plane or beyond the range of floats.
    pub fn centre(&self) -> Option<P> {
        if !self.is_sphere() {
            return None;
        }
        let centre = self.origin + self.b * (-0.5 / self.a) / self.unit;
        (0..P::DIM).all(|i| centre.coord(i).is_finite()).then_some(centre)
    }

    /// Radius of a sphere, rounded, for reports; nothing for a plane or beyond the range of floats.
    pub fn radius(&self) -> Option<f64> {
        if !self.is_sphere() {
            return None;
        }
        let square = self.b.norm2() - 4.0 * self.a * self.c;
        let radius = square.sqrt() / (2.0 * self.a.abs()) / self.unit;
        radius.is_finite().then_some(radius)
    }

    /// The surface as plain numbers: origin (3), unit, a, b (3), c.
    pub fn to_array(&self) -> [f64; SEPARATOR_WORDS] {
        let mut out = [0.0; SEPARATOR_WORDS];
        for i in 0..P::DIM {
            out[i] = self.origin.coord(i);
            out[5 + i] = self.b.coord(i);
        }
        out[3] = self.unit;
        out[4] = self.a;
        out[8] = self.c;
        out
    }

    /// Decodes [`Separator::to_array`]; nothing if the numbers are no separator: all must be finite,
    /// the unit a positive power of two and the surface not empty.
    pub fn from_array(words: &[f64; SEPARATOR_WORDS]) -> Option<Self> {
        let (unit, a, c) = (words[3], words[4], words[8]);
        let (origin, b) = (P::from_coords(&words[..3]), P::from_coords(&words[5..8]));
        let power = unit >= f64::MIN_POSITIVE && unit.to_bits().trailing_zeros() >= 52;
        let surface = b.norm2() - 4.0 * a * c > 0.0;
        let finite = words.iter().all(|w| w.is_finite());
        (finite && power && surface).then_some(Separator { origin, unit, a, b, c })
    }
}
