//! The memory of a run: a forecast before it starts, and the measured peak.

use crate::error::Error;
use crate::spec::Spec;

/// Bytes per point of `triangulate`, in space and in the plane: measured peaks at a million uniform points,
/// rounded up.
const BYTES_PER_POINT: [u64; 2] = [1100, 600];

/// Bytes per point of `simulate`, measured in the same way.
const COUNTED_BYTES_PER_POINT: [u64; 2] = [10_000, 3_000];

/// Bytes per site of `independent`, measured in the same way.
const BYTES_PER_SITE: [u64; 2] = [700, 500];

/// Returns the expected peak in bytes: a constant plus `bytes_per_point` for each point.
fn forecast(points: u64, dimension: usize, bytes_per_point: [u64; 2]) -> u64 {
    points.saturating_mul(bytes_per_point[usize::from(dimension == 2)]).saturating_add(64 << 20)
}

/// Checks the expected peak of a run against the memory limit of the configuration. `counted` states whether the whole
/// recursion runs.
///
/// # Errors
/// Returns [`Error::Memory`] with the forecast.
pub fn admit(spec: &Spec, points: u64, dimension: usize, counted: bool) -> Result<(), Error> {
    let row = if counted { COUNTED_BYTES_PER_POINT } else { BYTES_PER_POINT };
    compare(spec, points, forecast(points, dimension, row))
}

/// Checks the expected peak of an independent set against the memory limit of the configuration.
///
/// # Errors
/// Returns [`Error::Memory`] with the forecast.
pub(crate) fn admit_sites(spec: &Spec, sites: u64, dimension: usize) -> Result<(), Error> {
    compare(spec, sites, forecast(sites, dimension, BYTES_PER_SITE))
}

fn compare(spec: &Spec, points: u64, forecast: u64) -> Result<(), Error> {
    match spec.machine.max_memory {
        Some(limit) if forecast > limit => Err(Error::Memory { forecast, limit, points }),
        _ => Ok(()),
    }
}

/// Returns the peak resident memory of this process in bytes, if the system reports it.
pub fn peak_rss() -> Option<u64> {
    status("VmHWM:")
}

/// Returns the current resident memory of this process in bytes, if the system reports it.
pub fn rss() -> Option<u64> {
    status("VmRSS:")
}

/// Returns the memory that is available without swapping in bytes, if the system reports it.
pub fn available() -> Option<u64> {
    entry("/proc/meminfo", "MemAvailable:")
}

fn status(key: &str) -> Option<u64> {
    entry("/proc/self/status", key)
}

fn entry(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find(|l| l.starts_with(key))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}
