//! Numbers that are the sum of two floats, without rounding.
//!
//! **Statement.** A number is the sum of a *high* part, which is the number rounded to a float, and a *low* part, the error of
//! that rounding. The order of numbers of equal high parts is that of their low parts, because rounding keeps the order.
//!
//! **Source.** Knuth, *The Art of Computer Programming*, volume 2 (1969), 4.2.2: the error of a rounded sum.
//!
//! **Departures.** Sums that need more than two floats are refused, and so are some whose parts lie far apart.

use std::cmp::Ordering;

/// The sum of two floats. The parts have no negative zeros.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwoParts {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

impl TwoParts {
    /// Returns the sum of two floats. It must not overflow.
    #[inline]
    fn sum(a: f64, b: f64) -> Self {
        let sum = a + b;
        let of_b = sum - a;
        let of_a = sum - of_b;
        // The last addition turns a negative zero into a positive one.
        TwoParts { high: sum + 0.0, low: (a - of_a) + (b - of_b) + 0.0 }
    }

    /// Adds a float. Returns `None` if the sum needs more than two floats. It must not overflow.
    #[inline]
    #[must_use]
    pub fn plus(self, by: f64) -> Option<Self> {
        let sum = TwoParts::sum(self.high, by);
        if self.low == 0.0 {
            return Some(sum);
        }
        let low = TwoParts::sum(sum.low, self.low);
        (low.low == 0.0).then(|| TwoParts::sum(sum.high, low.high))
    }

    /// Adds a whole multiple of a float, with an absolute factor below `2^21`. Returns `None` if a sum needs more than two
    /// floats. Products must not overflow or underflow.
    #[must_use]
    pub fn plus_multiple(self, factor: i32, of: f64) -> Option<Self> {
        // Of the 53 digits, the upper part has 26 and the lower one 27, so both products are floats.
        let upper = f64::from_bits(of.to_bits() & !((1 << 27) - 1));
        let factor = f64::from(factor);
        self.plus(factor * upper)?.plus(factor * (of - upper))
    }

    /// Compares the number with a float.
    #[must_use]
    pub fn compare(self, with: f64) -> Ordering {
        self.high.total_cmp(&(with + 0.0)).then(self.low.total_cmp(&0.0))
    }
}

impl From<f64> for TwoParts {
    fn from(high: f64) -> Self {
        TwoParts { high: high + 0.0, low: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_need_not_be_floats() {
        // Three times the float next to 0.9 needs 54 digits, but three minus it does not.
        let three = TwoParts::from(3.0);
        let rest = three.plus_multiple(-3, 0.9).unwrap();
        let as_integers = 3 * (1i64 << 53) - 3 * (0.9 * 2f64.powi(53)) as i64;
        assert_eq!((rest.high * 2f64.powi(53), rest.low), (as_integers as f64, 0.0));
        assert_eq!(rest.plus_multiple(3, 0.9), Some(three));
        // A coordinate with finer digits.
        let fine = TwoParts::from(0.1).plus_multiple(1_000_000, 0.7).unwrap();
        assert_ne!(fine.low, 0.0);
        assert_eq!(fine.plus_multiple(-1_000_000, 0.7), Some(TwoParts::from(0.1)));
    }

    #[test]
    fn sums_of_three_floats_are_refused() {
        let two = TwoParts::from(1.0).plus(2f64.powi(-80)).unwrap();
        assert_eq!(two.plus(2f64.powi(-200)), None);
        assert_eq!(two.compare(1.0), Ordering::Greater);
        assert_eq!(two.plus(-2f64.powi(-79)).unwrap().compare(1.0), Ordering::Less);
        assert_eq!(TwoParts::from(-0.0).compare(0.0), Ordering::Equal);
    }
}
