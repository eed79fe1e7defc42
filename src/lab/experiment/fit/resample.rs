//! Resampling of the seeds, to estimate the reliability of a conclusion.
//!
//! **Statement.** At every size, each repetition draws as many runs as the data have there, with replacement. For
//! levels, it draws from all runs together. It then determines the conclusion from the drawn runs. The fraction of
//! repetitions whose conclusion equals that of the data estimates the power of the test for these sizes and numbers of
//! seeds (Efron 1979).

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::conclusion::Conclusion;
use super::data::Measurement;
use super::equivalence::equivalence;
use super::growth::{How, growth, level_rows};

/// Seed of the draws. It is fixed, so that the result is a function of the request.
const SEED: u64 = 1;

/// The results of the repetitions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Resampled {
    /// Number of repetitions.
    pub times: u32,
    /// Fraction of the repetitions with the conclusion of the data.
    #[serde(rename = "same_verdict")]
    pub same_conclusion: f64,
    /// Fraction of the repetitions that bend upwards relative to log n at 1 %. For levels, the fraction whose interval
    /// lies outside the margin.
    pub bends: f64,
    /// For levels, the fraction of the repetitions that are flat; otherwise 0.
    pub flat: f64,
}

pub(super) fn resample_growth(
    values: &[Measurement],
    how: How,
    conclusion: &Conclusion,
    times: u32,
) -> Resampled {
    let mut sizes: BTreeMap<u64, Vec<Measurement>> = BTreeMap::new();
    for value in values {
        sizes.entry(value.asked).or_default().push(*value);
    }
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let (mut same, mut bends) = (0u32, 0u32);
    for _ in 0..times {
        let drawn: Vec<Measurement> = sizes
            .values()
            .flat_map(|runs| {
                (0..runs.len()).map(|_| runs[rng.random_range(0..runs.len())]).collect::<Vec<_>>()
            })
            .collect();
        if let Some(again) = growth(&drawn, how) {
            same += u32::from(Conclusion::of_growth(&again) == *conclusion);
            bends += u32::from(again.curvature.bends && again.curvature.quadratic.value > 0.0);
        }
    }
    Resampled { times, same_conclusion: share(same, times), bends: share(bends, times), flat: 0.0 }
}

pub(super) fn resample_levels(
    runs: &[Vec<(f64, f64)>],
    margin: f64,
    conclusion: &Conclusion,
    times: u32,
) -> Resampled {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let (mut same, mut bends, mut flat) = (0u32, 0u32, 0u32);
    for _ in 0..times {
        let drawn: Vec<Vec<(f64, f64)>> =
            (0..runs.len()).map(|_| runs[rng.random_range(0..runs.len())].clone()).collect();
        if let Some(again) = equivalence(&level_rows(&drawn), margin) {
            same += u32::from(Conclusion::of_levels(&again) == *conclusion);
            bends += u32::from(again.sloped);
            flat += u32::from(again.flat);
        }
    }
    Resampled {
        times,
        same_conclusion: share(same, times),
        bends: share(bends, times),
        flat: share(flat, times),
    }
}

fn share(count: u32, times: u32) -> f64 {
    f64::from(count) / f64::from(times)
}
