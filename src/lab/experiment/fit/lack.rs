//! Tests of lack of fit.
//!
//! **Statement.** F tests compare the residual of `y = a + b g` over the means at each size with the residuals of two
//! flexible references through the same means:
//! - *steepness*: `y = a + b g + c g ln x`, where c changes the exponent of the law. For g = log n, this is the nested
//!   test of curvature; for log^2 n, it adds log^3 n; for a power of n, it adds the derivative with respect to the
//!   exponent.
//! - *shape*: the cubic in log2 x.
//!
//! A law does not fit if either test rejects it at 0.5 %. The joint level is therefore at most 1 %.
//!
//! **Departure.** In textbooks, a test for lack of fit estimates the error from the spread of repetitions at one size.
//! Here, all seeds at one size have the same position on the sawtooth that the leaf size causes, and many counts do not
//! vary with the seed at all. An error estimated from the seeds would therefore be too small, and every law would be
//! rejected. Instead, the error is the residual of the reference between sizes, which includes both the sawtooth and
//! the seeds.

use super::design::Law;
use super::distribution::f_above;
use super::ols::{Fit, Observation, least_squares};

/// Significance level of each of the two tests.
const SIZE: f64 = 0.005;

/// A size: x, mean y, weight.
type Row = (f64, f64, f64);

/// Returns twice the smaller p-value of the two tests (Bonferroni).
pub(super) fn lack_of_fit(law: Law, fit: &Fit, rows: &[Row], dimension: usize) -> f64 {
    let steep = |x: f64| {
        let g = law.at(x, dimension);
        vec![g, g * x.ln()]
    };
    let (low, high) = rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), row| {
        (low.min(row.0.log2()), high.max(row.0.log2()))
    });
    let cubic = |x: f64| {
        let z = (2.0 * x.log2() - low - high) / (high - low);
        vec![z, z * z, z * z * z]
    };
    let p = against(fit, &columns(rows, steep), rows).min(against(fit, &columns(rows, cubic), rows));
    (2.0 * p).min(1.0)
}

/// Returns `true` if a law with this p-value is rejected.
pub(super) fn rejects(p: f64) -> bool {
    p < 2.0 * SIZE
}

fn columns(rows: &[Row], of: impl Fn(f64) -> Vec<f64>) -> Vec<Observation> {
    rows.iter().map(|&(x, y, weight)| Observation { columns: of(x), y, weight }).collect()
}

/// Returns the p-value of the F test of the law against a reference, or 1 if the reference is not better or not
/// determined.
fn against(law: &Fit, reference: &[Observation], rows: &[Row]) -> f64 {
    let Some(better) = least_squares(reference) else { return 1.0 };
    // Smaller residuals are caused by rounding.
    let rounding = 1e-24 * rows.iter().map(|r| r.2 * r.1 * r.1).sum::<f64>();
    let more = law.freedom - better.freedom;
    if law.rss <= better.rss.max(rounding) || more <= 0.0 {
        return 1.0;
    }
    let error = better.rss.max(rounding) / better.freedom;
    f_above(more, better.freedom, (law.rss - better.rss) / more / error)
}
