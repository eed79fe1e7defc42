//! The range in which the predicates are exact, and the power of two that scales a set into it.
//!
//! **Statement.** Let every coordinate be a multiple of `2^g` with absolute value below `2^m`. Then every intermediate
//! term of the in-sphere determinant in `d` dimensions is a multiple of `2^((d+2) g)` and below about
//! `2^((d+2) m + 12)`. Shewchuk's expansions are exact if nothing underflows or overflows. This holds if
//! `(d+2) g >= -1074` and `(d+2) m + 12 <= 1023 - 28`, since splitting needs 28 bits. Both dimensions use the bounds of
//! space: `g >= -214` and `m <= 196`. Dimensions 4 to 6 have the same range, which their integers cover ([`crate::predicates`]).
//!
//! The guard therefore tests the *lowest set bit*, not magnitudes. Coordinates are multiplied by one power of two,
//! which is exact and changes no sign. A set whose bits spread over more than 410 positions is rejected with an error.
//!
//! A weight is the square of a length, so it counts as the digits of its square root: a multiple of `2^(2g)` with an
//! absolute value below `2^(2m)` uses the digits from `g` to `m`. It is multiplied by the square of the power of two.
//!
//! **Source.** Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates" (1997).
//!
//! **Work and depth.** O(1) for each coordinate, and a reduction over the points.

use thiserror::Error;

use crate::point::Point;

/// Lowest admissible exponent of a set bit.
pub const LOWEST: i32 = -214;
/// Highest admissible exponent of a power of two that exceeds every coordinate.
pub const HIGHEST: i32 = 196;

/// Rounds the coordinates of a place to the lowest digit of the range. Returns `None` if one is beyond the range or is not finite.
///
/// Sums with a number of the lowest digit round to it. Coordinates that are larger have no lower digits.
pub fn rounded_into<P: Point>(mut place: P) -> Option<P> {
    let two_to = |exponent: i32| f64::from_bits(((1023 + exponent) as u64) << 52);
    let (round, most) = (1.5 * two_to(LOWEST + 52), two_to(HIGHEST - 1));
    for i in 0..P::DIM {
        let x = place.coord(i);
        if x.is_nan() || x.abs() > most {
            return None;
        }
        if x.abs() < two_to(LOWEST + 51) {
            place.set_coord(i, (x + round) - round);
        }
    }
    Some(place)
}

/// The reason why signs cannot be computed exactly.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum RangeError {
    /// A coordinate is infinite or not a number.
    #[error("point {index}: coordinate {value} is not finite")]
    NotFinite {
        /// Position of the point.
        index: usize,
        /// Value of the coordinate.
        value: f64,
    },
    /// The bits of the coordinates spread too far for exact signs.
    #[error(
        "the coordinates spread over {bits} binary digits (point {low} needs the lowest, point {high} the \
         highest), but exact signs are available up to 410"
    )]
    Spread {
        /// Number of binary digits from the lowest set bit to the highest.
        bits: i32,
        /// Position of a point with the lowest set bit.
        low: usize,
        /// Position of a point with the largest coordinate.
        high: usize,
    },
}

/// Returns `(g, m)` of a nonzero finite number: its lowest set bit is `2^g`, and its absolute value is below `2^m`.
fn bit_range(x: f64) -> (i32, i32) {
    let bits = x.to_bits();
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, exponent) =
        if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    let low = exponent + mantissa.trailing_zeros() as i32;
    let high = exponent + 64 - mantissa.leading_zeros() as i32;
    (low, high)
}

/// Returns the digits of a weight, as those of a length: `(g, m)` such that the weight is a multiple of `2^(2g)` and its
/// absolute value is below `2^(2m)`.
fn half_range(weight: f64) -> (i32, i32) {
    let (low, high) = bit_range(weight);
    (low.div_euclid(2), (high + 1).div_euclid(2))
}

/// Returns the digits of each number of a point that is not zero: coordinates, their low parts, and the weight.
fn ranges<P: Point>(p: &P) -> impl Iterator<Item = (i32, i32)> {
    let weight = p.weight();
    let coordinates = (0..P::DIM).map(|i| p.coord(i)).filter(|&x| x != 0.0).map(bit_range);
    let low_parts = (0..if P::IS_WEIGHTED { P::DIM } else { 0 }).map(|i| p.low(i));
    let low_parts = low_parts.filter(|&x| x != 0.0).map(bit_range);
    coordinates.chain(low_parts).chain((P::IS_WEIGHTED && weight != 0.0).then(|| half_range(weight)))
}

/// Returns the first coordinate of a point, or its weight, if it is infinite or not a number.
pub fn not_finite<P: Point>(p: &P) -> Option<f64> {
    (0..P::DIM).map(|i| p.coord(i)).chain([p.weight()]).find(|x| !x.is_finite())
}

/// The binary digits that a set of coordinates uses: from their lowest set bit to the position above their highest
/// set bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digits {
    low: i32,
    high: i32,
}

impl Digits {
    /// The digits of an empty set.
    pub const NONE: Digits = Digits { low: i32::MAX, high: i32::MIN };

    /// Creates the digits between these ends ([`Digits::ends`]).
    pub fn new((low, high): (i32, i32)) -> Self {
        Digits { low, high }
    }

    /// Returns the exponents of the lowest digit and of the digit above the highest.
    pub fn ends(self) -> (i32, i32) {
        (self.low, self.high)
    }

    /// Computes the digits of the coordinates of `points`. Returns `None` if a coordinate is not finite.
    pub fn of<P: Point>(points: &[P]) -> Option<Self> {
        let (mut digits, mut finite) = (Digits::NONE, true);
        for p in points {
            finite &= not_finite(p).is_none();
            for (low, high) in ranges(p) {
                digits.low = digits.low.min(low);
                digits.high = digits.high.max(high);
            }
        }
        finite.then_some(digits)
    }

    /// Computes a superset of the digits of `points` with one comparison for each coordinate: all digits that a
    /// coordinate of its magnitude may use. Returns `None` if a coordinate is not finite.
    pub fn upper_bound<P: Point>(points: &[P]) -> Option<Self> {
        let coordinates = Sizes::of(points, |p, sizes| {
            for i in 0..P::DIM {
                sizes.add(p.coord(i));
                if P::IS_WEIGHTED {
                    sizes.add(p.low(i));
                }
            }
        });
        let (low, high) = coordinates.digits()?;
        if !P::IS_WEIGHTED {
            return Some(Digits { low, high });
        }
        let (weights_low, weights_high) = Sizes::of(points, |p, sizes| sizes.add(p.weight())).digits()?;
        let is_zero = weights_low == i32::MAX;
        let (half_low, half_high) = (weights_low.div_euclid(2), weights_high.saturating_add(1).div_euclid(2));
        let weights = if is_zero { Digits::NONE } else { Digits { low: half_low, high: half_high } };
        Some(Digits { low: low.min(weights.low), high: high.max(weights.high) })
    }

    /// Returns the digits of two sets.
    #[must_use]
    pub fn join(self, other: Digits) -> Self {
        Digits { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Returns `true` if the digits lie in the exact range.
    pub fn fits(self) -> bool {
        self == Digits::NONE || (self.low >= LOWEST && self.high <= HIGHEST)
    }

    /// Returns the exponent of the power of two that scales these digits into the exact range.
    ///
    /// # Errors
    /// Returns the number of digits if no scaling brings them into the range.
    pub fn scaling(self) -> Result<i32, i32> {
        if self.fits() {
            return Ok(0);
        }
        let bits = self.high.saturating_sub(self.low);
        if bits > HIGHEST - LOWEST {
            return Err(bits);
        }
        // Centre the digits in the range.
        Ok(i32::midpoint(LOWEST, HIGHEST) - self.low.midpoint(self.high))
    }

    /// Returns the exponent of the power of two that scales `points` into the exact range. The digits must be those
    /// of `points`.
    ///
    /// # Errors
    /// Fails if no scaling brings the spread of bits into the range. The error names the first point with the lowest
    /// bit and the last point with the highest bit.
    pub fn exponent<P: Point>(self, points: &[P]) -> Result<i32, RangeError> {
        self.scaling().map_err(|bits| {
            let has = |p: &P, end: &dyn Fn((i32, i32)) -> bool| ranges(p).any(end);
            let low = points.iter().position(|p| has(p, &|r| r.0 == self.low)).unwrap_or(0);
            let high = points.iter().rposition(|p| has(p, &|r| r.1 == self.high)).unwrap_or(0);
            RangeError::Spread { bits, low, high }
        })
    }
}

/// The smallest and the largest absolute value of some numbers, by their bits.
struct Sizes {
    /// The smallest of those that are not zero, less one.
    least: u64,
    most: u64,
}

impl Sizes {
    #[inline]
    fn of<P>(points: &[P], add: impl Fn(&P, &mut Sizes)) -> Self {
        let mut sizes = Sizes { least: u64::MAX, most: 0 };
        for p in points {
            add(p, &mut sizes);
        }
        sizes
    }

    #[inline]
    fn add(&mut self, x: f64) {
        let size = x.abs().to_bits();
        self.most = self.most.max(size);
        // Zero uses no digits. The subtraction turns it into the largest number.
        self.least = self.least.min(size.wrapping_sub(1));
    }

    /// Returns the ends of all digits that numbers of these sizes may use; those of [`Digits::NONE`] if all are zero.
    /// Returns `None` if a number is not finite.
    fn digits(&self) -> Option<(i32, i32)> {
        if self.most >= f64::INFINITY.to_bits() {
            return None;
        }
        if self.most == 0 {
            return Some(Digits::NONE.ends());
        }
        let biased = |size: u64| (size >> 52).max(1) as i32;
        Some((biased(self.least + 1) - 1075, biased(self.most) - 1022))
    }
}

/// Checks that all coordinates and weights are finite.
///
/// # Errors
/// Returns the first coordinate that is not finite, with the position of its point.
pub fn all_finite<P: Point>(points: &[P]) -> Result<(), RangeError> {
    for (index, p) in points.iter().enumerate() {
        if let Some(value) = not_finite(p) {
            return Err(RangeError::NotFinite { index, value });
        }
    }
    Ok(())
}

/// Returns the exponent of the power of two that scales every coordinate into the exact range; 0 if all coordinates
/// already lie in it.
///
/// # Errors
/// Fails if a coordinate is not finite, or if no scaling brings the spread of bits into the range.
pub fn scale_exponent<P: Point>(points: &[P]) -> Result<i32, RangeError> {
    match Digits::of(points) {
        Some(digits) => digits.exponent(points),
        None => all_finite(points).map(|()| 0),
    }
}

/// Multiplies coordinates by `2^exponent`, and a weight by its square. The products are exact if [`scale_exponent`]
/// returned the exponent.
pub fn scale<P: Point>(p: P, exponent: i32) -> P {
    let half = exponent / 2;
    let two_to = |e: i32| f64::from_bits(((1023 + i64::from(e)) as u64) << 52);
    let factors = [two_to(half), two_to(exponent - half)];
    let mut scaled = p * factors[0] * factors[1];
    if P::IS_WEIGHTED {
        // In this order, no product leaves the range of floats before the last one.
        scaled.set_weight(p.weight() * factors[0] * factors[0] * factors[1] * factors[1]);
    }
    scaled
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn scaled_sets_come_into_range_exactly() {
        for factor in [1e-120, 1.0, 1e120, 1e-300, 1e290] {
            let points = [DVec3::new(0.3, -0.7, 1e-9) * factor, DVec3::ONE * factor];
            let e = scale_exponent(&points).unwrap();
            for &p in &points {
                let q = scale(p, e);
                assert_eq!(scale(q, -e), p);
                for c in q.to_array().into_iter().filter(|&c| c != 0.0) {
                    let (g, m) = bit_range(c);
                    assert!(g >= LOWEST && m <= HIGHEST);
                }
            }
        }
    }

    #[test]
    fn invalid_coordinates_are_rejected() {
        let points = [DVec3::ONE, DVec3::new(1e-200, 0.0, 0.0)];
        assert!(matches!(scale_exponent(&points), Err(RangeError::Spread { low: 1, high: 0, .. })));
        let points = [DVec3::ONE, DVec3::new(0.0, f64::NAN, 0.0)];
        assert!(matches!(scale_exponent(&points), Err(RangeError::NotFinite { index: 1, .. })));
        assert_eq!(scale_exponent(&[DVec3::ZERO]), Ok(0));
    }
}
