//! Fits, and their results.

use std::collections::BTreeMap;

use serde::Serialize;

use super::conclusion::Conclusion;
use super::data::{self, FitError, FitRequest, Key, Measurement};
use super::equivalence::{Equivalence, equivalence};
use super::excluded::{NotExcluded, not_excluded};
use super::growth::{Growth, How, LEAST_SIZES, by_size, growth, level_rows};
use super::power::{Power, power};
use super::resample::{Resampled, resample_growth, resample_levels};
use crate::experiment::Line;

/// Name and version of the schema of [`FitReport`].
pub const SCHEMA: &str = "septet-fit/2";

/// Number of shares that the conclusion in words names.
const NAMED_SHARES: usize = 2;

/// Number of seeds per size that resampling requires.
const LEAST_SEEDS: usize = 3;

/// The result of a request.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FitReport {
    /// Name and version of this schema.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    pub schema: String,
    /// The request.
    pub request: FitRequest,
    /// The curves, each with the runs that belong to it.
    pub series: Vec<Series>,
}

/// Runs of one curve, which differ in size and seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Series {
    /// The common options of the runs.
    pub name: String,
    /// Number of runs.
    pub runs: usize,
    /// Growth with n; absent for `level-depth`.
    pub growth: Option<Growth>,
    /// Flatness over levels, for `level-depth` only.
    pub levels: Option<Equivalence>,
    /// The conclusion.
    #[serde(rename = "verdict")]
    pub conclusion: Conclusion,
    /// The laws above the conclusion, with the largest share of each that the data do not exclude. The largest share
    /// comes first.
    pub not_excluded: Vec<NotExcluded>,
    /// A power of n with a free exponent. `None` if the sizes do not determine the exponent, and for `level-depth`.
    pub power: Option<Power>,
    /// The conclusion in words, with the largest shares and the exponent.
    pub words: String,
    /// The result of resampling, if requested: how often it gives the same conclusion.
    pub resampled: Option<Resampled>,
}

/// Fits the lines as requested.
///
/// # Errors
/// See [`FitError`].
pub fn fit(lines: &[Line], request: &FitRequest) -> Result<FitReport, FitError> {
    data::check(lines, request)?;
    let mut series = Vec::new();
    for (name, lines) in data::series(lines, request) {
        let answer = if request.y == Key::LevelDepth {
            of_levels(name, &lines, request)
        } else {
            of_growth(name, &lines, request)
        };
        series.extend(answer?);
    }
    if series.is_empty() {
        return Err(FitError::Nothing { key: request.y.name() });
    }
    Ok(FitReport { schema: SCHEMA.to_string(), request: request.clone(), series })
}

fn of_growth(name: String, lines: &[Line], request: &FitRequest) -> Result<Option<Series>, FitError> {
    let values: Vec<Measurement> = lines.iter().filter_map(|line| data::value(line, request)).collect();
    let Some(dimension) = lines.first().map(|line| line.dimension).filter(|_| !values.is_empty()) else {
        return Ok(None);
    };
    let how = How { dimension, relative: request.y.is_relative(), margin: request.margin };
    let table = by_size(&values);
    let Some(growth) = growth(&values, how) else {
        return Err(FitError::TooFewSizes { series: name, sizes: table.len(), least: LEAST_SIZES });
    };
    let conclusion = Conclusion::of_growth(&growth);
    let counts = table.iter().map(|row| (row.x, row.runs));
    enough_seeds(&name, counts, request)?;
    let resampled =
        (request.resamples > 0).then(|| resample_growth(&values, how, &conclusion, request.resamples));
    let not_excluded = not_excluded(&growth, &conclusion, dimension);
    let power = power(&growth.rows());
    let words = words(&conclusion, &not_excluded, power.as_ref());
    Ok(Some(Series {
        name,
        runs: values.len(),
        growth: Some(growth),
        levels: None,
        conclusion,
        not_excluded,
        power,
        words,
        resampled,
    }))
}

/// Returns the conclusion on growth as a sentence, with the two largest shares that are not excluded, and with the free
/// exponent if the count grows.
fn words(conclusion: &Conclusion, shares: &[NotExcluded], power: Option<&Power>) -> String {
    let mut words = conclusion.words();
    let largest: Vec<String> =
        shares.iter().take(NAMED_SHARES).filter(|s| s.share > 0.0).map(NotExcluded::words).collect();
    if !largest.is_empty() {
        words = format!("{words}; at the largest size, up to {} are not excluded", largest.join(" or "));
    }
    let grows = matches!(
        conclusion,
        Conclusion::Law { .. } | Conclusion::CannotTell { .. } | Conclusion::NoneOfThese
    );
    if let Some(power) = power.filter(|_| grows) {
        words = format!("{words}; as a power n^e, e = {}", power.words());
    }
    words
}

fn of_levels(name: String, lines: &[Line], request: &FitRequest) -> Result<Option<Series>, FitError> {
    let phase = request.phase.as_deref().unwrap_or_default();
    let runs: Vec<Vec<(f64, f64)>> =
        lines.iter().map(|line| data::levels(line, phase)).filter(|levels| !levels.is_empty()).collect();
    if runs.is_empty() {
        return Ok(None);
    }
    let rows = level_rows(&runs);
    let Some(test) = equivalence(&rows, request.margin) else {
        return Err(FitError::TooFewLevels { series: name, levels: rows.len(), runs: runs.len() });
    };
    let mut sizes: BTreeMap<u64, usize> = BTreeMap::new();
    for line in lines.iter().filter(|line| !data::levels(line, phase).is_empty()) {
        *sizes.entry(line.asked).or_default() += 1;
    }
    enough_seeds(&name, sizes.into_iter().map(|(n, runs)| (n as f64, runs)), request)?;
    let conclusion = Conclusion::of_levels(&test);
    let resampled = (request.resamples > 0)
        .then(|| resample_levels(&runs, request.margin, &conclusion, request.resamples));
    let words = conclusion.words();
    Ok(Some(Series {
        name,
        runs: runs.len(),
        growth: None,
        levels: Some(test),
        conclusion,
        not_excluded: Vec::new(),
        power: None,
        words,
        resampled,
    }))
}

/// Returns an error if some size has too few seeds for resampling.
fn enough_seeds(
    series: &str,
    mut sizes: impl Iterator<Item = (f64, usize)>,
    request: &FitRequest,
) -> Result<(), FitError> {
    match sizes.find(|size| size.1 < LEAST_SEEDS).filter(|_| request.resamples > 0) {
        Some((size, seeds)) => {
            Err(FitError::TooFewSeeds { series: series.to_string(), size, seeds, least: LEAST_SEEDS })
        }
        None => Ok(()),
    }
}
