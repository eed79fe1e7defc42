//! Does a law fit at all?
//!
//! **Statement.** The residual of `y = a + b g` over the means at each size is held against those of two flexible
//! references through the same means, by F tests:
//! - *steepness*: `y = a + b g + c g ln x`, where c turns the law's exponent: for g = log n this is the nested test of
//!   curvature, for log^2 n it adds log^3 n, for a power of n its change with the exponent;
//! - *shape*: the cubic in log2 x.
//!
//! A law does not fit if either test rejects it at 0.5 %, so 1 % for both.
//!
//! **Departure.** The textbook's error of a test for lack of fit is the spread of repetitions at one size. Seeds at
//! one size share its place on the saw-tooth that a floor of leaves makes, and many counts do not vary over seeds at
//! all: against that error every law is rejected. The error here is what the reference leaves between sizes: it holds
//! the saw-tooth as well as the seeds.

use super::design::Law;
use super::distribution::f_above;
use super::ols::{Fit, Observation, least_squares};

/// Size of each of the two tests.
const SIZE: f64 = 0.005;

/// A size: x, mean y, weight.
type Row = (f64, f64, f64);

/// The smaller of the two probabilities of so large a residual if the law holds, times two (Bonferroni).
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

/// Is this probability one at which a law is said not to fit?
pub(super) fn rejects(p: f64) -> bool {
    p < 2.0 * SIZE
}

fn columns(rows: &[Row], of: impl Fn(f64) -> Vec<f64>) -> Vec<Observation> {
    rows.iter().map(|&(x, y, weight)| Observation { columns: of(x), y, weight }).collect()
}

/// P of the F test of the law against a reference; 1 if the reference is no better or not determined.
fn against(law: &Fit, reference: &[Observation], rows: &[Row]) -> f64 {
    let Some(better) = least_squares(reference) else { return 1.0 };
    // Below this, a residual is rounding.
    let rounding = 1e-24 * rows.iter().map(|r| r.2 * r.1 * r.1).sum::<f64>();
    let more = law.freedom - better.freedom;
    if law.rss <= better.rss.max(rounding) || more <= 0.0 {
        return 1.0;
    }
    let error = better.rss.max(rounding) / better.freedom;
    f_above(more, better.freedom, (law.rss - better.rss) / more / error)
}
