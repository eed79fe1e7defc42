//! The lattice of a call: coordinates as multiples of one power of two.
//!
//! **Statement.** Every finite double is an integer times a power of two. Let `2^g` be the largest power of two that
//! divides all coordinates of a call, and let `2^(g+b)` bound their differences. In units of `2^g`, all
//! differences are integers with absolute values below `2^b`, for coordinates of any magnitude. Coordinates are
//! computed modulo `2^w` with `w > b`. Their differences are then exact, even if the coordinates themselves do not fit.
//! The unit does not change the sign of a determinant, and `b` determines its width ([`super::integer`]).
//!
//! If `b` is small, the determinant and all its partial sums are integers below `2^53`. Then rounded arithmetic has no
//! rounding error, and the determinant of stage 1 is exact ([`is_exact`]). To test whether `x` is a multiple of a power
//! of two `s`, add and subtract `1.5 * 2^52 s`. This rounds to a multiple of `s` if `|x| < 2^51 s` (Dekker 1971).
//!
//! **Work.** O(1) operations for each coordinate.

use super::wide::Int;
use crate::point::Point;

/// The exponent that represents zero; it is larger than all others.
const NONE: i32 = 1 << 14;

/// Returns the significand and the exponent of `x`: `|x| = significand * 2^exponent`.
#[inline]
fn parts(x: f64) -> (u64, i32) {
    let bits = x.to_bits();
    let biased = (bits >> 52) as i32 & 0x7ff;
    let implicit = u64::from(biased != 0) << 52;
    (bits & ((1 << 52) - 1) | implicit, biased.max(1) - 1075)
}

/// Returns the exponent of the last place of `x`; [`NONE`] if `x` is zero.
#[inline]
fn last_place(x: f64) -> i32 {
    let biased = (x.to_bits() >> 52) as i32 & 0x7ff;
    if x == 0.0 { NONE } else { biased.max(1) - 1075 }
}

/// Returns the exponent of the lowest set bit of `x`; a number above all exponents if `x` is zero.
#[inline]
pub(super) fn unit_of(x: f64) -> i32 {
    let (significand, exponent) = parts(x);
    if significand == 0 { NONE } else { exponent + significand.trailing_zeros() as i32 }
}

#[inline]
fn lowest<P: Point>(points: &[P], of: impl Fn(f64) -> i32) -> i32 {
    let mut lowest = NONE;
    for p in points {
        for i in 0..P::DIM {
            lowest = lowest.min(of(p.coord(i)));
            if P::IS_WEIGHTED {
                lowest = lowest.min(of(p.low(i)));
            }
        }
    }
    lowest
}

/// Returns the exponent of a unit of `points` that is cheap to compute: the lowest last place of their coordinates.
#[inline]
pub(super) fn quick_unit<P: Point>(points: &[P]) -> i32 {
    lowest(points, last_place)
}

/// Returns the exponent of the largest unit of `points`: the lowest set bit of all their coordinates.
#[inline]
pub(super) fn largest_unit<P: Point>(points: &[P]) -> i32 {
    lowest(points, unit_of)
}

/// Returns the number of bits of differences up to `reach`, in units of `2^unit`: the differences lie below
/// `2^width`. The rounding of `reach` does not matter: an exact difference that is at least a power of two never
/// rounds to a number below that power.
#[inline]
pub(super) fn width(reach: f64, unit: i32) -> i32 {
    (reach.to_bits() >> 52) as i32 - 1022 - unit
}

/// Computes `x / 2^unit` modulo `2^(64 D)`. `unit` must not be above the lowest set bit of `x`.
#[inline]
pub(super) fn integer<const D: usize>(x: f64, unit: i32) -> Int<D> {
    let (significand, exponent) = parts(x);
    let mut limbs = [0; D];
    for (i, limb) in (0i32..).zip(&mut limbs) {
        *limb = shifted(significand, exponent - unit - 64 * i);
    }
    // Negation in two's complement inverts all bits and adds one. Both steps depend on the sign bit.
    let negative = u64::from(x.is_sign_negative());
    let mut carry = negative;
    for limb in &mut limbs {
        let (sum, over) = (*limb ^ negative.wrapping_neg()).overflowing_add(carry);
        (*limb, carry) = (sum, u64::from(over));
    }
    Int(limbs)
}

/// Computes [`integer`] in one limb. `unit` must not be above the last place of `x`.
#[inline]
pub(super) fn quick_integer(x: f64, unit: i32) -> Int<1> {
    let (significand, exponent) = parts(x);
    // For zero the shift is negative, so it is too large as an unsigned number.
    let limb = significand.checked_shl((exponent - unit) as u32).unwrap_or(0);
    let negative = (x.to_bits() as i64 >> 63) as u64;
    Int([(limb ^ negative).wrapping_sub(negative)])
}

/// Computes `significand * 2^shift` without the bits that do not fit at either end.
#[inline]
fn shifted(significand: u64, shift: i32) -> u64 {
    if shift >= 0 {
        significand.checked_shl(shift as u32).unwrap_or(0)
    } else {
        significand.checked_shr(shift.unsigned_abs()).unwrap_or(0)
    }
}

/// Returns `true` if rounded arithmetic on the differences between `points` is exact. `reach` bounds the differences.
/// `bits` is the width for which the caller's determinant and its partial sums stay below `2^53`.
#[inline]
pub(super) fn is_exact<P: Point>(points: &[P], reach: f64, bits: u64) -> bool {
    let biased = reach.to_bits() >> 52;
    if !(64..1984).contains(&biased) {
        return false;
    }
    // `reach < 2^(biased - 1022)`; the unit is `2^(biased - 1022 - bits)`.
    let magic = f64::from_bits((biased + 1 - bits + 52) << 52 | 1 << 51);
    let far = f64::from_bits((biased + 1 - bits + 51) << 52);
    let mut exact = true;
    for p in points {
        for i in 0..P::DIM {
            let x = p.coord(i);
            exact &= x.abs() < far && (x + magic) - magic == x;
        }
    }
    exact
}
