//! Sums of many measures: with compensated rounding, and exact.

use num_bigint::BigInt;

use crate::exact::rounded;

/// A sum with its accumulated rounding error (Neumaier).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    pub(crate) fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        self.lost += if self.sum.abs() >= x.abs() { (self.sum - sum) + x } else { (x - sum) + self.sum };
        self.sum = sum;
    }

    pub(crate) fn value(self) -> f64 {
        self.sum + self.lost
    }
}

/// Binary digits of a window of an exact sum.
const WINDOW: i32 = 32;

/// Windows that cover the exponents of all finite numbers.
const WINDOWS: usize = 66;

/// The lowest exponent of a number.
const LOWEST: i32 = -1074;

/// A sum without rounding. It does not depend on the order of its terms, so parts of it can be made anywhere and merged.
///
/// **Statement.** A finite number is `m 2^e` with an integer `|m| < 2^53`. Window `i` holds the sum of the terms with
/// `LOWEST + 32 i <= e < LOWEST + 32 (i + 1)` as a multiple of `2^(LOWEST + 32 i)`. Each term adds less than `2^85`, so
/// `2^42` terms fit into 128 bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExactSum {
    windows: Box<[i128; WINDOWS]>,
    /// Number of terms that are infinite or NaN. They are not in the sum.
    pub open: u64,
}

impl Default for ExactSum {
    fn default() -> Self {
        ExactSum { windows: Box::new([0; WINDOWS]), open: 0 }
    }
}

impl ExactSum {
    /// Number of words of [`ExactSum::to_words`].
    pub const WORDS: usize = 2 * WINDOWS + 1;

    /// Adds a term.
    pub fn add(&mut self, x: f64) {
        if !x.is_finite() {
            self.open += 1;
            return;
        }
        let bits = x.to_bits();
        let biased = ((bits >> 52) & 0x7ff) as i32;
        let fraction = (bits & ((1 << 52) - 1)) as i128;
        let (mantissa, above) = if biased == 0 { (fraction, 0) } else { (fraction | 1 << 52, biased - 1) };
        let term = mantissa << (above % WINDOW);
        self.windows[(above / WINDOW) as usize] += if x.is_sign_negative() { -term } else { term };
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &ExactSum) {
        for (own, other) in self.windows.iter_mut().zip(other.windows.iter()) {
            *own += other;
        }
        self.open += other.open;
    }

    /// Returns the sum, rounded once. NaN if a term is not finite.
    pub fn value(&self) -> f64 {
        if self.open > 0 {
            return f64::NAN;
        }
        let mut sum = BigInt::ZERO;
        for window in self.windows.iter().rev() {
            sum = (sum << WINDOW) + BigInt::from(*window);
        }
        rounded(&sum, LOWEST)
    }

    /// Returns the sum as words, to be sent.
    pub fn to_words(&self) -> impl Iterator<Item = u64> + '_ {
        self.windows.iter().flat_map(|&w| [w as u64, (w >> 64) as u64]).chain([self.open])
    }

    /// Takes a sum from words. Returns `None` if there are too few.
    pub fn from_words(words: &mut impl Iterator<Item = u64>) -> Option<Self> {
        let mut sum = ExactSum::default();
        for window in sum.windows.iter_mut() {
            let (low, high) = (words.next()?, words.next()?);
            *window = (u128::from(high) << 64 | u128::from(low)) as i128;
        }
        sum.open = words.next()?;
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_sums_do_not_depend_on_the_order() {
        let terms = [1e300, 3.0, -1e300, 5e-324, 0.1, -3.0, 1e16, 1.0, -1e16, f64::MIN_POSITIVE];
        let mut forward = ExactSum::default();
        for &x in &terms {
            forward.add(x);
        }
        let (mut low, mut high) = (ExactSum::default(), ExactSum::default());
        for &x in terms[..4].iter().rev() {
            low.add(x);
        }
        for &x in terms[4..].iter().rev() {
            high.add(x);
        }
        high.merge(&low);
        assert_eq!(forward, high);
        assert_eq!(forward.value(), 1.1);
        assert_eq!(ExactSum::from_words(&mut forward.clone().to_words()), Some(forward));
        let mut open = ExactSum::default();
        open.add(f64::INFINITY);
        assert!(open.value().is_nan() && ExactSum::default().value() == 0.0);
    }
}
