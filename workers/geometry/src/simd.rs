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
