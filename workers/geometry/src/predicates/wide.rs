//! Integers of a fixed number of 64-bit limbs, in two's complement, on the stack.
//!
//! **Statement.** All operations are exact modulo `2^(64 N)`. A result with absolute value below `2^(64 N - 1)` is
//! therefore exact. The callers guarantee this bound.
//!
//! **Source.** Schoolbook multiplication (Knuth, *The Art of Computer Programming* 2, section 4.3.1, algorithm M). The
//! product is unsigned and then corrected: a negative factor of `A` limbs with the unsigned value `a` has the value
//! `a - 2^(64 A)`.
//!
//! **Work.** `A B` multiplications of limbs for a product.

#![expect(clippy::needless_range_loop, reason = "loops over limbs unroll by their index; iterators do not")]

use super::sign::Sign;

/// A signed integer of `N` limbs, the lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Int<const N: usize>(pub(super) [u64; N]);

impl<const N: usize> Int<N> {
    #[inline]
    pub fn is_negative(self) -> bool {
        (self.0[N - 1] as i64) < 0
    }

    #[inline]
    pub fn sign(self) -> Sign {
        if self.is_negative() {
            Sign::Negative
        } else if self.0.iter().all(|&limb| limb == 0) {
            Sign::Zero
        } else {
            Sign::Positive
        }
    }

    #[inline]
    pub fn plus(self, other: Self) -> Self {
        let mut out = [0; N];
        let mut carry = false;
        for i in 0..N {
            (out[i], carry) = self.0[i].carrying_add(other.0[i], carry);
        }
        Int(out)
    }

    #[inline]
    pub fn minus(self, other: Self) -> Self {
        self.minus_shifted(other, 0)
    }

    /// Computes `self - other 2^(64 shift)`.
    #[inline]
    fn minus_shifted<const B: usize>(self, other: Int<B>, shift: usize) -> Self {
        let mut out = self.0;
        let mut borrow = false;
        for i in shift..N {
            let subtracted = if i - shift < B { other.0[i - shift] } else { 0 };
            (out[i], borrow) = out[i].borrowing_sub(subtracted, borrow);
        }
        Int(out)
    }

    /// Computes the product modulo `2^(64 R)`.
    #[inline]
    pub fn times<const B: usize, const R: usize>(self, other: Int<B>) -> Int<R> {
        if N == 1 && B == 1 && R == 2 {
            let product = i128::from(self.0[0] as i64) * i128::from(other.0[0] as i64);
            let mut out = [0; R];
            (out[0], out[R - 1]) = (product as u64, (product >> 64) as u64);
            return Int(out);
        }
        let product = self.times_natural::<B, R>(other);
        // Corrects the product if `other` is negative, by a mask instead of a branch.
        product.minus_shifted(self.masked(other.is_negative()), B)
    }

    /// Computes the product with a nonnegative number that may use its sign bit, modulo `2^(64 R)`.
    #[inline]
    pub fn times_natural<const B: usize, const R: usize>(self, other: Int<B>) -> Int<R> {
        const { assert!(R <= N + B && R >= N && R >= B) }
        let mut out = [0; R];
        for i in 0..N {
            let mut carry = 0u64;
            for j in 0..B.min(R - i) {
                (out[i + j], carry) = self.0[i].carrying_mul_add(other.0[j], out[i + j], carry);
            }
            if i + B < R {
                out[i + B] = carry;
            }
        }
        Int(out).minus_shifted(other.masked(self.is_negative()), N)
    }

    /// Computes `self / 2^bits`, rounded down, for `bits < 64`.
    #[inline]
    pub fn shifted_down(self, bits: u32) -> Self {
        let mut out = self.0;
        for i in 0..N - 1 {
            out[i] = out[i] >> bits | (out[i + 1] << 1) << (63 - bits);
        }
        out[N - 1] = (out[N - 1] as i64 >> bits) as u64;
        Int(out)
    }

    /// Returns the number if `keep` is `true`, otherwise 0.
    #[inline]
    fn masked(self, keep: bool) -> Self {
        let mask = u64::from(keep).wrapping_neg();
        Int(self.0.map(|limb| limb & mask))
    }
}
