//! Growth with n: fits all laws and selects the best ones.

use std::collections::BTreeMap;

use serde::Serialize;

use super::data::Measurement;
use super::design::Law;
use super::distribution::t_quantile;
use super::equivalence::LevelRow;
use super::lack::lack_of_fit;
use super::nested::{Curvature, curvature};
use super::ols::{Interval, Observation, least_squares};

/// Smallest number of sizes of a fit. A curve with three coefficients then leaves two degrees of freedom for the error.
pub(super) const LEAST_SIZES: usize = 5;

/// Growth with n.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Growth {
    /// One row per size.
    pub table: Vec<SizeRow>,
    /// The laws, the most likely first.
    pub laws: Vec<LawFit>,
    /// The nested test.
    pub curvature: Curvature,
    /// Slope of ln y against ln x. `None` if one of the y is not positive.
    pub exponent: Option<Interval>,
    /// Change over the range of sizes as a fraction of the mean, with the 90 % interval of two one-sided tests.
    pub change: Interval,
    /// The margin of the request. A smaller change does not count as growth.
    pub margin: f64,
    /// Whether rows are weighted by 1 / y^2.
    #[serde(skip)]
    relative: bool,
}

impl Growth {
    /// Returns x, the mean y and the weight of each size.
    pub(super) fn rows(&self) -> Vec<(f64, f64, f64)> {
        weighted(&self.table, self.relative)
    }
}

/// Returns x, the mean y and the weight of each size.
fn weighted(table: &[SizeRow], relative: bool) -> Vec<(f64, f64, f64)> {
    let relative = relative && table.iter().all(|row| row.mean > 0.0);
    let weight = |row: &SizeRow| {
        let scale = if relative { 1.0 / (row.mean * row.mean) } else { 1.0 };
        row.runs as f64 * scale
    };
    table.iter().map(|row| (row.x, row.mean, weight(row))).collect()
}

/// The runs of one size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SizeRow {
    /// Mean x.
    pub x: f64,
    /// Mean y.
    pub mean: f64,
    /// Smallest y.
    pub low: f64,
    /// Largest y.
    pub high: f64,
    /// Number of runs.
    pub runs: usize,
}

/// The fit of a law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LawFit {
    /// The law g.
    pub law: Law,
    /// The coefficient a of `y = a + b g(x)`.
    pub constant: Interval,
    /// The coefficient b.
    pub slope: Interval,
    /// Fraction of the (weighted) variance that the law explains.
    pub r_squared: f64,
    /// The p-value of the tests for lack of fit: the probability of residuals at least this much larger than those of
    /// more flexible curves if the law holds.
    pub lack_of_fit: f64,
    /// Akaike's criterion minus its value for the best law.
    pub behind: f64,
    /// Quadratic term in log2 x of the fitted values of the law.
    pub bend: f64,
    /// Probability that the nested test would detect the quadratic term `bend` in data with this error.
    pub power: f64,
}

/// Returns the levels of all runs, each with the index of its run.
pub(super) fn level_rows(runs: &[Vec<(f64, f64)>]) -> Vec<LevelRow> {
    let of_run = |(run, levels): (usize, &Vec<(f64, f64)>)| {
        levels.iter().map(|&(x, y)| (run, x, y)).collect::<Vec<_>>()
    };
    runs.iter().enumerate().flat_map(of_run).collect()
}

/// Returns the means over the seeds of each size.
pub(super) fn by_size(values: &[Measurement]) -> Vec<SizeRow> {
    let mut sizes: BTreeMap<u64, Vec<&Measurement>> = BTreeMap::new();
    for value in values {
        sizes.entry(value.asked).or_default().push(value);
    }
    let row = |values: &Vec<&Measurement>| {
        let count = values.len() as f64;
        SizeRow {
            x: values.iter().map(|v| v.x).sum::<f64>() / count,
            mean: values.iter().map(|v| v.y).sum::<f64>() / count,
            low: values.iter().map(|v| v.y).fold(f64::INFINITY, f64::min),
            high: values.iter().map(|v| v.y).fold(f64::NEG_INFINITY, f64::max),
            runs: values.len(),
        }
    };
    sizes.values().map(row).collect()
}

/// The parameters of a fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct How {
    pub(super) dimension: usize,
    /// Whether rows are weighted by 1 / y^2.
    pub(super) relative: bool,
    /// Largest change over the range of sizes that does not count as growth, as a fraction of the mean.
    pub(super) margin: f64,
}

/// Fits all laws. Returns `None` if there are too few sizes.
pub(super) fn growth(values: &[Measurement], how: How) -> Option<Growth> {
    let How { dimension, relative, margin } = how;
    let table = by_size(values);
    if table.len() < LEAST_SIZES {
        return None;
    }
    let rows = weighted(&table, relative);
    let curvature = curvature(&rows)?;
    let mut laws: Vec<LawFit> =
        Law::all(dimension).filter_map(|law| law_fit(law, &rows, dimension, &curvature)).collect();
    laws.sort_by(|a, b| a.behind.total_cmp(&b.behind));
    let best = laws.first().map_or(0.0, |fit| fit.behind);
    for fit in &mut laws {
        fit.behind -= best;
    }
    let exponent = exponent(&table);
    let change = change(&rows)?;
    Some(Growth { table, laws, curvature, exponent, change, margin, relative })
}

/// Returns the change over the range of sizes as a fraction of the mean, estimated by a straight line in log2 x.
pub(super) fn change(rows: &[(f64, f64, f64)]) -> Option<Interval> {
    let row = |&(x, y, weight): &(f64, f64, f64)| Observation { columns: vec![x.log2()], y, weight };
    let line = least_squares(&rows.iter().map(row).collect::<Vec<_>>())?;
    let mean = rows.iter().map(|r| r.1).sum::<f64>() / rows.len() as f64;
    let logs = || rows.iter().map(|r| r.0.log2());
    let range = logs().fold(f64::NEG_INFINITY, f64::max) - logs().fold(f64::INFINITY, f64::min);
    // Counts are not negative. If the mean is 0, all counts are 0 and there is no change.
    let share = if mean > 0.0 { range / mean } else { 0.0 };
    let (value, error) = (line.coefficients[1].value * share, line.coefficients[1].error * share);
    let half = t_quantile(line.freedom, 0.95) * error;
    Some(Interval { value, error, low: value - half, high: value + half })
}

pub(super) fn law_fit(
    law: Law,
    rows: &[(f64, f64, f64)],
    dimension: usize,
    curvature: &Curvature,
) -> Option<LawFit> {
    let row =
        |&(x, y, weight): &(f64, f64, f64)| Observation { columns: vec![law.at(x, dimension)], y, weight };
    let observed: Vec<Observation> = rows.iter().map(row).collect();
    let fit = least_squares(&observed)?;
    let own: Vec<(f64, f64, f64)> =
        rows.iter().zip(&observed).map(|(row, o)| (row.0, fit.at(&o.columns), row.2)).collect();
    let (bend, power) = curvature.power_against(&own);
    Some(LawFit {
        law,
        constant: fit.coefficients[0],
        slope: fit.coefficients[1],
        r_squared: fit.r_squared(),
        lack_of_fit: lack_of_fit(law, &fit, rows, dimension),
        behind: fit.aicc(rows.len()),
        bend,
        power,
    })
}

pub(super) fn exponent(table: &[SizeRow]) -> Option<Interval> {
    if table.iter().any(|row| row.mean <= 0.0) {
        return None;
    }
    let row =
        |row: &SizeRow| Observation { columns: vec![row.x.ln()], y: row.mean.ln(), weight: row.runs as f64 };
    Some(least_squares(&table.iter().map(row).collect::<Vec<_>>())?.coefficients[1])
}
