//! Floats as dyadic numbers, and exact sums of them.
//!
//! **Statement.** A finite `f64` is `m 2^e` with whole numbers `m` and `e`. Multiplying several of them by `2^-low`, where `low`
//! is their lowest exponent, makes them whole.
//!
//! **Work.** O(1) for each number; big integers of about 2,100 bits at most for one `f64`.

use std::cmp::Ordering;

use num_bigint::BigInt;

/// Splits a finite `x` into `(m, e)` with `x = m 2^e` and `m` odd. Zero is `(0, 0)`.
#[inline]
pub(super) fn split(x: f64) -> (i64, i32) {
    if x == 0.0 {
        return (0, 0);
    }
    let raw = x.to_bits();
    let biased = ((raw >> 52) & 0x7ff) as i32;
    let fraction = (raw & ((1 << 52) - 1)) as i64;
    let (m, e) = if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
    let shift = m.trailing_zeros();
    let m = m >> shift;
    (if raw >> 63 == 1 { -m } else { m }, e + shift as i32)
}

/// Returns `2^k` for `k` in `-1022..=1023`.
pub(super) fn power_of_two(k: i32) -> f64 {
    f64::from_bits(((1023 + k) as u64) << 52)
}

/// Returns `2^k` for `k` in `-1074..=1023`.
pub(super) fn two_to(k: i32) -> f64 {
    if k < -1022 { f64::from_bits(1 << (k + 1074)) } else { power_of_two(k) }
}

/// Returns the exact sign of a sum.
pub(super) fn sum_sign(parts: &[f64]) -> Ordering {
    let (low, _) = span(parts.iter().map(|&x| split(x)));
    sign_of(&parts.iter().map(|&x| whole(x, low)).sum())
}

/// Returns the lowest exponent, and the position after the highest bit, of all nonzero coordinates.
#[inline]
pub(super) fn span(parts: impl Iterator<Item = (i64, i32)>) -> (i32, i32) {
    let mut low = i32::MAX;
    let mut high = i32::MIN;
    for (m, e) in parts.filter(|&(m, _)| m != 0) {
        low = low.min(e);
        high = high.max(e + (64 - m.unsigned_abs().leading_zeros()) as i32);
    }
    (low, high)
}

/// Returns `x / 2^low` for a finite `x` that this makes an integer.
pub(super) fn whole(x: f64, low: i32) -> BigInt {
    let (m, e) = split(x);
    if m == 0 { BigInt::ZERO } else { BigInt::from(m) << (e - low) }
}

/// Returns the sign of a big integer.
pub(super) fn sign_of(x: &BigInt) -> Ordering {
    x.cmp(&BigInt::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_every_kind_of_float() {
        for x in [1.0, -3.5, 0.1, f64::MIN_POSITIVE, 5e-324, -f64::MAX, 1e300, 6.0] {
            let (m, e) = split(x);
            assert_eq!(m & 1, 1);
            let half = (e / 2, e - e / 2);
            assert_eq!(m as f64 * 2f64.powi(half.0) * 2f64.powi(half.1), x);
        }
        assert_eq!(split(0.0), (0, 0));
    }

    #[test]
    fn signs_of_sums_are_exact() {
        assert_eq!(sum_sign(&[1e300, 1.0, -1e300]), Ordering::Greater);
        assert_eq!(sum_sign(&[0.1, 0.2, -0.3]), Ordering::Greater);
        assert_eq!(sum_sign(&[-5e-324, 0.0]), Ordering::Less);
        assert_eq!(sum_sign(&[]), Ordering::Equal);
    }
}
