//! How much memory a run takes: a forecast before it starts, and the peak that was measured.

use crate::config::Config;
use crate::error::Error;

/// Bytes a point of `triangulate`, in space and in the plane: measured peaks at a million uniform points,
/// rounded up.
const BYTES_PER_POINT: [u64; 2] = [1100, 600];

/// The same of `simulate`.
const COUNTED_BYTES_PER_POINT: [u64; 2] = [10_000, 3_000];

/// Expected peak memory of a run over `points` points, in bytes. A counted run that stops before the graph takes
/// less than a triangulation: it is not `counted` here.
pub fn forecast(points: u64, dimension: usize, counted: bool) -> u64 {
    let row = if counted { COUNTED_BYTES_PER_POINT } else { BYTES_PER_POINT };
    points.saturating_mul(row[usize::from(dimension == 2)]).saturating_add(64 << 20)
}

/// Refuses what does not fit into the limit of the configuration, if it has one.
///
/// # Errors
/// [`Error::Memory`] with the forecast.
pub fn admit(config: &Config, points: u64, dimension: usize, counted: bool) -> Result<(), Error> {
    let forecast = forecast(points, dimension, counted);
    match config.max_memory {
        Some(limit) if forecast > limit => Err(Error::Memory { forecast, limit, points }),
        _ => Ok(()),
    }
}

/// Bytes a site of `independent`, likewise.
const SITE_BYTES: [u64; 2] = [700, 500];

/// Expected peak memory of an independent set of so many sites, in bytes.
pub fn forecast_sites(sites: u64, dimension: usize) -> u64 {
    sites.saturating_mul(SITE_BYTES[usize::from(dimension == 2)]).saturating_add(64 << 20)
}

/// Peak resident memory of this process in bytes, where the system tells.
pub fn peak_rss() -> Option<u64> {
    status("VmHWM:")
}

/// Present resident memory of this process in bytes, where the system tells.
pub fn rss() -> Option<u64> {
    status("VmRSS:")
}

/// Memory that could be had now without pushing anything out, in bytes, where the system tells.
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
