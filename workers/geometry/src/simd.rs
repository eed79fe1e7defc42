//! Loops over lanes, compiled for the registers of several processors and run with the widest at hand.
//!
//! **Statement.** The instructions differ, the results do not: each lane does the same additions, subtractions,
//! products and comparisons in double or single precision in the same order, rounded alike (IEEE 754), and no
//! product and addition are fused, since the compiler does that only where it is told to.
//!
//! The choice is made once, when it is first asked for (of x86-64: its baseline, AVX2, AVX-512).

#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

use std::sync::atomic::{AtomicBool, Ordering};

use pulp::Arch;

static BASELINE: AtomicBool = AtomicBool::new(false);

/// From now on this process uses the registers that every processor of its kind has: to compare, and to count
/// instructions that do not depend on the machine. Results are the same.
pub fn use_baseline_registers() {
    BASELINE.store(true, Ordering::Relaxed);
}

/// Runs `f` compiled for the widest registers at hand: `f` and what it calls gain only if they are inlined, so both want
/// `#[inline(always)]`.
#[inline]
pub(crate) fn widest<R>(f: impl FnOnce() -> R) -> R {
    if BASELINE.load(Ordering::Relaxed) { f() } else { Arch::new().dispatch(f) }
}

/// The larger of two numbers, or the second if one is not a number: one instruction.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The lanes that are no larger than a limit, as the bits of a number. Not inlined: in the loop that computes the lanes
/// it would turn them into eight single numbers.
#[inline(never)]
pub(crate) fn up_to(lanes: &[f64; 8], limit: f64) -> u32 {
    let bits: [u64; 8] = std::array::from_fn(|lane| if lanes[lane] <= limit { 1 << lane } else { 0 });
    bits.iter().fold(0, |all, bit| all | bit) as u32
}

/// The lanes that are not below their limits, as the bits of a number. Not inlined, like [`up_to`].
#[inline(never)]
pub(crate) fn not_below(lanes: &[f32; 8], limits: &[f32; 8]) -> u32 {
    let bits: [u32; 8] = std::array::from_fn(|lane| if lanes[lane] < limits[lane] { 0 } else { 1 << lane });
    bits.iter().fold(0, |all, bit| all | bit)
}

/// The numbers of the bits that are set, in order.
#[inline(always)]
pub(crate) fn each_bit(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = (bits != 0).then(|| bits.trailing_zeros() as usize);
            bits &= bits.wrapping_sub(1);
            lane
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of products whose last digits show whether anything was fused.
    #[inline(always)]
    fn products(x: &[f64], y: &[f64], z: &[f64]) -> Vec<u64> {
        x.iter().zip(y).zip(z).map(|((x, y), z)| (x * x + y * y + z * z - x * y).to_bits()).collect()
    }

    #[inline(always)]
    fn single_products(x: &[f32], y: &[f32]) -> Vec<u32> {
        x.iter().zip(y).map(|(x, y)| (x * x + y * y - x * y).to_bits()).collect()
    }

    #[test]
    fn lanes_are_told_by_bits() {
        let x = [0.0, 2.0, -1.0, f64::NAN, 1.0, f64::INFINITY, 1.5, -0.0];
        assert_eq!(each_bit(up_to(&x, 1.0)).collect::<Vec<_>>(), [0, 2, 4, 7]);
        assert_eq!(each_bit(up_to(&x, f64::INFINITY)).collect::<Vec<_>>(), [0, 1, 2, 4, 5, 6, 7]);
        let (x, limits) = (x.map(|x| x as f32), [0.0, 3.0, -1.0, 0.0, f32::NAN, 1.0, f32::INFINITY, 1.0]);
        assert_eq!(each_bit(not_below(&x, &limits)).collect::<Vec<_>>(), [0, 2, 3, 4, 5]);
        assert_eq!(each_bit(0).count(), 0);
        assert_eq!(each_bit(u32::MAX).collect::<Vec<_>>(), (0..32).collect::<Vec<_>>());
    }

    #[test]
    fn the_widest_registers_give_the_same_bits() {
        let at = |i: u32, k: u32| f64::from(i.wrapping_mul(2_654_435_769) ^ k) / 3.0 - 2e8;
        let [x, y, z] = [1, 2, 3].map(|k| (0..1000).map(|i| at(i, k)).collect::<Vec<f64>>());
        assert_eq!(
            widest(
                #[inline(always)]
                || products(&x, &y, &z)
            ),
            products(&x, &y, &z)
        );
        let [x, y] = [x, y].map(|v| v.into_iter().map(|x| x as f32).collect::<Vec<f32>>());
        assert_eq!(
            widest(
                #[inline(always)]
                || single_products(&x, &y)
            ),
            single_products(&x, &y)
        );
        let fused =
            x.iter().zip(&y).filter(|&(&x, &y)| (x.mul_add(x, y * y) - x * x - y * y).abs() > 0.0).count();
        assert!(fused > 0, "the numbers would not show it");
    }
}
