//! The memory of a run: a forecast before it starts, counts while structures grow ([`MemoryLimit`]), and the peak.
//!
//! **Statement.** A limit of memory is that of the process. No run that ends without an error peaks above it, because the
//! peak is compared with the limit in every round and at the end. The forecast refuses most other runs before they start.
//! It is low, so that it refuses no run that would pass.

use septet_geometry::point::Point;
use septet_workers::config::{MemoryLimit, MemoryUse};

use crate::error::Error;
use crate::run::forecast::Forecast;
use crate::spec::{Spec, Task};

/// Checks the memory of points that do not exist yet.
///
/// # Errors
/// Returns [`Error::Memory`] if the points alone exceed the limit of the specification.
pub fn admit_rows(spec: &Spec, points: u64, dimension: usize) -> Result<(), Error> {
    let bytes = points.saturating_mul((size_of::<f64>() * dimension) as u64);
    compare(spec, points, || bytes)
}

/// Checks the forecast of a run against the limit of the specification.
///
/// # Errors
/// Returns [`Error::Memory`] with the forecast.
pub fn admit<P: Point>((spec, task): (&Spec, Task), points: &[P]) -> Result<(), Error> {
    let in_box = spec.input.periodic.is_some();
    let more = || Forecast::of(task, points, in_box).bytes();
    compare(spec, points.len() as u64, || more().saturating_add(rss().unwrap_or(0)))
}

/// Compares a forecast with the limit of the specification. There is no forecast without a limit.
fn compare(spec: &Spec, points: u64, forecast: impl Fn() -> u64) -> Result<(), Error> {
    let Some(limit) = spec.machine.max_memory else { return Ok(()) };
    let forecast = forecast();
    if forecast > limit { Err(Error::Memory { forecast, limit, points }) } else { Ok(()) }
}

/// Compares the peak of this process with the limit of the specification.
///
/// # Errors
/// Returns [`Error::Exceeded`] if the peak is larger.
pub fn check_peak(spec: &Spec) -> Result<(), Error> {
    match (spec.machine.max_memory, peak_rss()) {
        (Some(limit), Some(used)) if used > limit => Err(Error::Exceeded { used, limit }),
        _ => Ok(()),
    }
}

/// Returns the limit of a run.
pub(super) fn limit_of(spec: &Spec) -> Option<MemoryLimit> {
    spec.machine.max_memory.map(|limit| MemoryLimit::new(limit, memory_use))
}

/// Measures the memory of this process, if the system reports it.
fn memory_use() -> Option<MemoryUse> {
    let text = std::fs::read_to_string(STATUS).ok()?;
    Some(MemoryUse { now: entry(&text, "VmRSS:")?, peak: entry(&text, "VmHWM:")? })
}

/// The file in which the system reports the memory of this process.
const STATUS: &str = "/proc/self/status";

/// Returns the peak resident memory of this process in bytes, if the system reports it.
pub fn peak_rss() -> Option<u64> {
    memory_use().map(|memory| memory.peak)
}

/// Returns the current resident memory of this process in bytes, if the system reports it.
pub fn rss() -> Option<u64> {
    memory_use().map(|memory| memory.now)
}

/// Returns the memory that is available without swapping in bytes, if the system reports it.
pub fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    entry(&text, "MemAvailable:")
}

/// Returns the bytes of an entry.
fn entry(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find(|l| l.starts_with(key))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}
