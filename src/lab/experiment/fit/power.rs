//! A power of n with a free exponent.
//!
//! **Statement.** `y = a + b x^e` is fitted by weighted least squares over the means at each size, where e is free and
//! e = 0 stands for log n. For fixed e, the fit is linear, with the residual sum R(e). The exponent is the e in [-2, 4]
//! with the smallest R(e). Its 95 % interval contains the e with `R(e) <= R_min (1 + t^2 / f)`, where f is the number
//! of sizes minus 3 and t is Student's quantile at 97.5 % (profile interval; Bates and Watts 1988, Section 6.1). If
//! these e do not form an interval, the interval spans all of them.
//!
//! **Use.** A small power looks like a power of log n: over ten octaves, n^0.1 is fitted well by log^2 n. The interval
//! shows which powers explain the data.

use std::ops::RangeInclusive;

use serde::Serialize;

use super::distribution::t_quantile;
use super::ols::{Observation, least_squares};

/// The exponents of the search.
const RANGE: RangeInclusive<f64> = -2.0..=4.0;

/// Number of steps of the grid over the range.
const STEPS: u32 = 120;

/// Number of iterations of a search within a step of the grid, by golden section or by bisection.
const HALVINGS: u32 = 40;

/// The exponent of `y = a + b x^e`, with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Power {
    /// The exponent with the smallest residual.
    pub exponent: f64,
    /// Lower end of the 95 % interval. `None` if it is below the search range.
    pub low: Option<f64>,
    /// Upper end of the 95 % interval. `None` if it is above the search range.
    pub high: Option<f64>,
}

impl Power {
    /// Returns the exponent and its interval.
    pub(super) fn words(&self) -> String {
        let end = |end: Option<f64>, beyond: String| end.map_or(beyond, |e| format!("{e:.2}"));
        let low = end(self.low, format!("below {}", RANGE.start()));
        let high = end(self.high, format!("above {}", RANGE.end()));
        format!("{:.2} [{low}, {high}]", self.exponent)
    }
}

/// Fits rows of x, mean y and weight. Returns `None` for fewer than 4 sizes, or if the interval is the whole search
/// range.
pub(super) fn power(rows: &[(f64, f64, f64)]) -> Option<Power> {
    let freedom = rows.len().checked_sub(3).filter(|&f| f > 0)? as f64;
    let profile = Profile::of(rows);
    let step = (RANGE.end() - RANGE.start()) / f64::from(STEPS);
    let grid: Vec<f64> = (0..=STEPS).map(|i| RANGE.start() + step * f64::from(i)).collect();
    let residuals: Vec<f64> = grid.iter().map(|&e| profile.residual(e)).collect();
    let lowest = (0..grid.len()).min_by(|&i, &j| residuals[i].total_cmp(&residuals[j]))?;
    let exponent = profile.minimum(grid[lowest] - step, grid[lowest] + step);
    let quantile = t_quantile(freedom, 0.975);
    let limit = profile.residual(exponent) * (1.0 + quantile * quantile / freedom);
    let inside = |i: &usize| residuals[*i] <= limit;
    let first = (0..grid.len()).find(inside).map_or(exponent, |i| grid[i].min(exponent));
    let last = (0..grid.len()).rev().find(inside).map_or(exponent, |i| grid[i].max(exponent));
    let low = (first > *RANGE.start()).then(|| profile.end(first, first - step, limit));
    let high = (last < *RANGE.end()).then(|| profile.end(last, last + step, limit));
    (low.is_some() || high.is_some()).then_some(Power { exponent, low, high })
}

/// The residual sum as a function of the exponent.
struct Profile<'a> {
    rows: &'a [(f64, f64, f64)],
    /// Mean of ln x. Powers are taken of x over its geometric mean.
    middle: f64,
}

impl Profile<'_> {
    fn of(rows: &[(f64, f64, f64)]) -> Profile<'_> {
        let middle = rows.iter().map(|row| row.0.ln()).sum::<f64>() / rows.len() as f64;
        Profile { rows, middle }
    }

    /// Returns the residual sum for this exponent. The column is `(z^e - 1) / e` with z = x over its geometric mean,
    /// and ln z for e = 0.
    fn residual(&self, exponent: f64) -> f64 {
        let column = |x: f64| {
            let log = x.ln() - self.middle;
            if exponent.abs() < 1e-9 { log } else { (exponent * log).exp_m1() / exponent }
        };
        let row = |&(x, y, weight): &(f64, f64, f64)| Observation { columns: vec![column(x)], y, weight };
        let rows: Vec<Observation> = self.rows.iter().map(row).collect();
        // A residual below the rounding error is replaced by the rounding error.
        let rounding = 1e-24 * self.rows.iter().map(|r| r.2 * r.1 * r.1).sum::<f64>();
        least_squares(&rows).map_or(f64::INFINITY, |fit| fit.rss.max(rounding))
    }

    /// Returns the minimum between two exponents, by golden-section search.
    fn minimum(&self, mut low: f64, mut high: f64) -> f64 {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..HALVINGS {
            let (left, right) = (high - golden * (high - low), low + golden * (high - low));
            if self.residual(left) <= self.residual(right) {
                high = right;
            } else {
                low = left;
            }
        }
        f64::midpoint(low, high)
    }

    /// Returns the exponent between `inside` and `outside` at which the residual sum reaches the limit.
    fn end(&self, mut inside: f64, mut outside: f64, limit: f64) -> f64 {
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(inside, outside);
            if self.residual(middle) <= limit {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns `law(x)` at 40 sizes of ten octaves, with a wave of this relative height and weights to match.
    fn rows(law: impl Fn(f64) -> f64, wave: f64) -> Vec<(f64, f64, f64)> {
        (0..40)
            .map(|i| {
                let x = (10.0 + 0.25 * f64::from(i)).exp2();
                let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                (x, law(x) * (1.0 + sign * wave), law(x).powi(-2))
            })
            .collect()
    }

    #[test]
    fn exponents_are_found() {
        for e in [-0.5, 0.1, 0.5, 1.0, 2.0] {
            let found = power(&rows(|x| 7.0 + 3.0 * x.powf(e), 0.0)).unwrap();
            assert!((found.exponent - e).abs() < 1e-5, "{e}: {found:?}");
            let noisy = power(&rows(|x| 3.0 * x.powf(e), 0.01)).unwrap();
            let (low, high) = (noisy.low.unwrap(), noisy.high.unwrap());
            assert!(low < e && e < high && high - low < 0.3, "{e}: {noisy:?}");
        }
        let log = power(&rows(|x| 5.0 + 2.0 * x.ln(), 0.005)).unwrap();
        assert!(log.low.unwrap() < 0.0 && log.high.unwrap() > 0.0, "{log:?}");
    }

    #[test]
    fn constant_counts_have_no_exponent() {
        assert_eq!(power(&rows(|_| 5.0, 0.0)), None);
        assert_eq!(power(&rows(|_| 5.0, 0.1)), None);
        assert_eq!(power(&rows(|x| x, 0.0)[..3]), None);
    }
}
