//! The lattice of one call: coordinates as multiples of one power of two.
//!
//! **Statement.** Every finite double is an integer times a power of two. Let `2^g` be the largest power of
//! two that divides all coordinates of a call, and `2^b` times that a bound of their differences. In units
//! of `2^g` all differences are integers below `2^b` in size, whatever the sizes of the coordinates: taken
//! modulo `2^w`, `w > b`, coordinates give the differences exactly, although they need not fit themselves.
//! A determinant's sign does not change by the unit, and its width follows from `b` ([`super::integer`]).
//!
//! If `b` is so small that the determinant and all its partial sums are integers below `2^53`, rounded
//! arithmetic has rounded nothing: then the determinant of stage 1 is exact ([`is_exact`]). Whether `x`
//! is a multiple of a power of two `s` is told by adding and subtracting `1.5 * 2^52 s`, which rounds to
//! multiples of `s` where `|x| < 2^51 s` (Dekker 1971).
//!
//! **Work.** A few operations for each coordinate.

use super::wide::Int;
use crate::point::Point;

/// The exponent of a unit that no coordinate needs: above all others.
const NONE: i32 = 1 << 14;

/// The significand of `x` and its exponent: `|x| = significand * 2^exponent`.
#[inline]
fn parts(x: f64) -> (u64, i32) {
    let bits = x.to_bits();
    let biased = (bits >> 52) as i32 & 0x7ff;
    let implicit = u64::from(biased != 0) << 52;
    (bits & ((1 << 52) - 1) | implicit, biased.max(1) - 1075)
}

/// The exponent of the last place of `x`; of zero, [`NONE`].
#[inline]
fn last_place(x: f64) -> i32 {
    let biased = (x.to_bits() >> 52) as i32 & 0x7ff;
    if x == 0.0 { NONE } else { biased.max(1) - 1075 }
}

/// The exponent of the lowest set bit of `x`; of zero, [`NONE`].
#[inline]
fn lowest_bit(x: f64) -> i32 {
    let (significand, exponent) = parts(x);
    if significand == 0 { NONE } else { exponent + significand.trailing_zeros() as i32 }
}

#[inline]
fn lowest<P: Point>(points: &[P], of: impl Fn(f64) -> i32) -> i32 {
    let mut lowest = NONE;
    for p in points {
        for i in 0..P::DIM {
            lowest = lowest.min(of(p.coord(i)));
        }
    }
    lowest
}

/// The exponent of a unit of `points` that is quick to find: the lowest last place of their coordinates.
#[inline]
pub(super) fn quick_unit<P: Point>(points: &[P]) -> i32 {
    lowest(points, last_place)
}

/// The exponent of the largest unit of `points`: the lowest set bit of all their coordinates.
#[inline]
pub(super) fn largest_unit<P: Point>(points: &[P]) -> i32 {
    lowest(points, lowest_bit)
}

/// Bits of differences up to `reach` in units of `2^unit`: they lie below `2^width`. It does not matter that
/// `reach` is rounded: an exact difference at a power of two or above would not have been rounded to below.
#[inline]
pub(super) fn width(reach: f64, unit: i32) -> i32 {
    (reach.to_bits() >> 52) as i32 - 1022 - unit
}

/// `x / 2^unit` modulo `2^(64 D)`, for a `unit` not above the lowest set bit of `x`.
#[inline]
pub(super) fn integer<const D: usize>(x: f64, unit: i32) -> Int<D> {
    let (significand, exponent) = parts(x);
    let mut limbs = [0; D];
    for (i, limb) in (0i32..).zip(&mut limbs) {
        *limb = shifted(significand, exponent - unit - 64 * i);
    }
    // Minus x is the complement plus one: all bits flipped by the sign, the sign added.
    let negative = u64::from(x.is_sign_negative());
    let mut carry = negative;
    for limb in &mut limbs {
        let (sum, over) = (*limb ^ negative.wrapping_neg()).overflowing_add(carry);
        (*limb, carry) = (sum, u64::from(over));
    }
    Int(limbs)
}

/// The same in one limb, for a `unit` not above the last place of `x`.
#[inline]
pub(super) fn quick_integer(x: f64, unit: i32) -> Int<1> {
    let (significand, exponent) = parts(x);
    // Of zero the shift is negative, and so, unsigned, too large.
    let limb = significand.checked_shl((exponent - unit) as u32).unwrap_or(0);
    let negative = (x.to_bits() as i64 >> 63) as u64;
    Int([(limb ^ negative).wrapping_sub(negative)])
}

/// `significand * 2^shift` without what does not fit, above or below.
#[inline]
fn shifted(significand: u64, shift: i32) -> u64 {
    if shift >= 0 {
        significand.checked_shl(shift as u32).unwrap_or(0)
    } else {
        significand.checked_shr(shift.unsigned_abs()).unwrap_or(0)
    }
}

/// Is rounded arithmetic on the differences between `points` exact? `reach` bounds the differences, and
/// `bits` is the width for which the caller's determinant and its partial sums stay below `2^53`.
#[inline]
pub(super) fn is_exact<P: Point>(points: &[P], reach: f64, bits: u64) -> bool {
    let biased = reach.to_bits() >> 52;
    if !(64..1984).contains(&biased) {
        return false;
    }
    // reach < 2^(biased - 1022), in units of 2^(biased - 1022 - bits).
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
