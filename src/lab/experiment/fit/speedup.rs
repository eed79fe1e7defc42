//! Speed-up relative to the best serial program, and never relative to the parallel program with one worker.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::line::{Line, Program};
use super::data::FitError;

/// The runs with one kind and size of set, one number of workers and one number of threads.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SpeedupRow {
    /// Kind and dimension.
    pub set: String,
    /// Number of points requested.
    pub n: u64,
    /// The requested number of workers.
    pub workers: String,
    /// Number of threads that ran the workers.
    pub threads: usize,
    /// Number of seeds.
    pub runs: usize,
    /// Median seconds of `triangulate`.
    pub seconds: f64,
    /// Median over seeds of the best serial run on the same points, in seconds.
    pub serial_seconds: f64,
    /// Median over seeds of serial seconds over parallel seconds.
    pub speedup: f64,
    /// The smallest and largest speed-up.
    pub spread: (f64, f64),
    /// Speed-up divided by the number of threads, because the workers share the threads.
    pub efficiency: f64,
}

/// A point set: kind, dimension, Lipschitz constant, number of points requested, seed.
type Set = (String, usize, u64, u64);

/// The key of a row: set, requested number of points, actual and requested workers, threads.
type Group = (String, u64, u32, String, usize);

fn set_of(line: &Line) -> Set {
    let lipschitz = line.settings.lipschitz.map_or_else(String::new, |l| format!(", lipschitz {l}"));
    (format!("{}, {}D{lipschitz}", line.kind, line.dimension), line.dimension, line.asked, line.seed)
}

/// Computes the speed-up of every timed run, by set size, workers and threads.
///
/// # Errors
/// Returns [`FitError::NoRuns`] without lines, [`FitError::NotTimed`] without a timed run, and [`FitError::NoSerial`]
/// without a serial run on the points of a timed run.
pub fn speedup(lines: &[Line]) -> Result<Vec<SpeedupRow>, FitError> {
    let mut serial: BTreeMap<Set, f64> = BTreeMap::new();
    for line in lines.iter().filter(|line| line.program == Program::Serial) {
        let best = serial.entry(set_of(line)).or_insert(f64::INFINITY);
        *best = best.min(line.seconds);
    }
    let mut timed: BTreeMap<Group, Vec<(f64, f64)>> = BTreeMap::new();
    for line in lines.iter().filter(|line| line.program == Program::Triangulate) {
        let set = set_of(line);
        let Some(&best) = serial.get(&set) else {
            let set = format!("{}, {} points, seed {}", set.0, set.2, set.3);
            return Err(FitError::NoSerial { set });
        };
        let settings = &line.settings;
        let key = (set.0, line.asked, line.workers, settings.workers.clone(), settings.threads);
        timed.entry(key).or_default().push((line.seconds, best));
    }
    if lines.is_empty() {
        return Err(FitError::NoRuns);
    }
    if timed.is_empty() {
        return Err(FitError::NotTimed);
    }
    Ok(timed
        .into_iter()
        .map(|((set, n, _, workers, threads), pairs)| row(set, n, workers, threads, &pairs))
        .collect())
}

fn row(set: String, n: u64, workers: String, threads: usize, pairs: &[(f64, f64)]) -> SpeedupRow {
    let ratios: Vec<f64> = pairs.iter().map(|(own, serial)| serial / own).collect();
    let speedup = median(&ratios);
    let low = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let high = ratios.iter().copied().fold(0.0, f64::max);
    SpeedupRow {
        set,
        n,
        workers,
        threads,
        runs: pairs.len(),
        seconds: median(&pairs.iter().map(|p| p.0).collect::<Vec<_>>()),
        serial_seconds: median(&pairs.iter().map(|p| p.1).collect::<Vec<_>>()),
        speedup,
        spread: (low, high),
        efficiency: speedup / threads.max(1) as f64,
    }
}

/// Returns the median of the values. There must be at least one.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { f64::midpoint(sorted[middle - 1], sorted[middle]) }
}
