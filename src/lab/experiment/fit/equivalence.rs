//! Two one-sided tests of whether the depth of a level is independent of its size.

use std::collections::BTreeMap;

use serde::Serialize;

use super::distribution::{t_above, t_quantile};
use super::ols::{Interval, Observation, least_squares};

/// Significance level of each one-sided test.
const SIZE: f64 = 0.05;

/// The slope of depth against log2 of the size, and whether it is within the margin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Equivalence {
    /// Steps per doubling of the size, with the 90 % interval of the two tests.
    pub slope: Interval,
    /// Mean depth.
    pub mean: f64,
    /// The margin as a fraction of the mean per doubling, stated in advance.
    pub margin: f64,
    /// The margin in steps.
    pub margin_steps: f64,
    /// The larger p-value of the two tests: the probability of data at least this flat if the slope were at the nearer
    /// end of the margin.
    pub p: f64,
    /// Whether the depth is flat: p is below 5 %.
    pub flat: bool,
    /// Whether the whole interval lies outside the margin.
    pub sloped: bool,
    /// The smallest margin, as a fraction of the mean, with which these data would be flat.
    pub smallest_margin: f64,
    /// Number of levels.
    pub rows: usize,
    /// Number of runs.
    pub runs: usize,
}

/// A level of a run: the index of the run, log2 of the mean size, and the mean depth.
pub(super) type LevelRow = (usize, f64, f64);

/// Tests `depth = a + s log2 m` for s within the margin. The error treats runs as clusters (CR1). Returns `None` for
/// fewer than 3 runs, or if all levels have the same size.
pub(super) fn equivalence(levels: &[LevelRow], margin: f64) -> Option<Equivalence> {
    let rows: Vec<Observation> =
        levels.iter().map(|&(_, x, y)| Observation { columns: vec![x], y, weight: 1.0 }).collect();
    let fit = least_squares(&rows)?;
    // The scores of each run are the sums of the residuals, and of the residuals times x.
    let mut scores: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
    for &(run, x, y) in levels {
        let residual = y - fit.at(&[x]);
        let score = scores.entry(run).or_default();
        score[0] += residual;
        score[1] += residual * x;
    }
    let runs = scores.len();
    if runs < 3 {
        return None;
    }
    let (g, n) = (runs as f64, levels.len() as f64);
    let row = &fit.bread[1];
    let meat: f64 = scores.values().map(|s| row[0] * s[0] + row[1] * s[1]).map(|v| v * v).sum();
    let error = (meat * g / (g - 1.0) * (n - 1.0) / (n - 2.0)).sqrt();
    let freedom = g - 1.0;
    let (value, mean) = (fit.coefficients[1].value, levels.iter().map(|l| l.2).sum::<f64>() / n);
    let steps = margin * mean;
    let beyond = |distance: f64| {
        if error > 0.0 {
            return t_above(freedom, distance / error);
        }
        // If all depths are 0, they do not depend on the size, and p is 0.
        f64::from(u8::from(distance < 0.0 || (distance == 0.0 && mean != 0.0)))
    };
    let p = beyond(steps - value).max(beyond(steps + value));
    let half = t_quantile(freedom, 1.0 - SIZE) * error;
    let slope = Interval { value, error, low: value - half, high: value + half };
    Some(Equivalence {
        slope,
        mean,
        margin,
        margin_steps: steps,
        p,
        flat: p < SIZE,
        sloped: slope.low > steps || slope.high < -steps,
        smallest_margin: if mean > 0.0 { slope.low.abs().max(slope.high.abs()) / mean } else { 0.0 },
        rows: levels.len(),
        runs,
    })
}
