//! The limit of the memory of a process.
//!
//! **Statement.** Structures whose size the points decide, such as cells and links, count their bytes while they grow:
//! each reports its bytes before it grows by another [`STEP`]. The run stops as soon as one of two figures exceeds the
//! limit: the bytes before the run and the sum of all counts, or the bytes that the system measures. The second figure
//! is missing on some systems. It also contains messages, small structures and the allocator.
//!
//! **Work.** One atomic operation and one measurement for each step of growth, and one measurement for each round. A run
//! without a limit counts and measures nothing.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The most bytes by which a structure grows between two counts.
pub const STEP: u64 = 1 << 20;

/// The memory of a process in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// The memory in use.
    pub now: u64,
    /// The largest memory that was ever in use.
    pub peak: u64,
}

/// Measures the memory of this process, if the system reports it.
pub type Probe = fn() -> Option<MemoryUse>;

/// The limit of the memory of a process, with the counts of its structures.
#[derive(Debug)]
pub struct MemoryLimit {
    limit: u64,
    probe: Probe,
    /// The memory before the run.
    before: MemoryUse,
    /// The sum of the counts of all structures.
    counted: AtomicU64,
    /// This sum at the last measurement.
    measured: AtomicU64,
    /// The bytes that exceeded the limit; 0 before.
    exceeding: AtomicU64,
}

impl MemoryLimit {
    /// Creates a limit in bytes.
    pub fn new(limit: u64, probe: Probe) -> Self {
        let (before, zeros) = (probe().unwrap_or_default(), [0, 0, 0]);
        let [counted, measured, exceeding] = zeros.map(AtomicU64::new);
        MemoryLimit { limit, probe, before, counted, measured, exceeding }
    }

    /// Returns the bytes that exceeded the limit, and the limit, if it is reached.
    pub(super) fn reached(&self) -> Option<(u64, u64)> {
        let used = self.exceeding.load(Ordering::Relaxed);
        (used > 0).then_some((used, self.limit))
    }

    /// Compares the memory in use and `more` bytes with the limit. The largest memory so far counts too, unless it was
    /// above the limit before the run.
    pub(super) fn measure(&self, more: u64) {
        let counted = self.counted.load(Ordering::Relaxed);
        self.measured.store(counted, Ordering::Relaxed);
        let counted = self.before.now.saturating_add(counted);
        let measured = (self.probe)().unwrap_or_default();
        let peak = if self.before.peak > self.limit { 0 } else { measured.peak };
        let used = counted.max(measured.now).saturating_add(more).max(peak);
        if used > self.limit {
            self.exceeding.fetch_max(used, Ordering::Relaxed);
        }
    }
}

/// The count of one structure, which ends with it.
#[derive(Debug, Default)]
pub(crate) struct Growth {
    memory: Option<Arc<MemoryLimit>>,
    bytes: u64,
}

impl Growth {
    pub(super) fn new(memory: Option<Arc<MemoryLimit>>) -> Self {
        Growth { memory, bytes: 0 }
    }

    /// Sets the bytes of the structure, before it grows by at most [`STEP`]. Measures the memory if all structures have
    /// grown by half a step since the last measurement.
    pub(super) fn count(&mut self, bytes: u64) {
        let Some(memory) = &self.memory else { return };
        // The difference wraps around if the structure shrinks, and so does the sum.
        let more = bytes.wrapping_sub(self.bytes);
        let sum = memory.counted.fetch_add(more, Ordering::Relaxed).wrapping_add(more);
        self.bytes = bytes;
        if sum >= memory.measured.load(Ordering::Relaxed).saturating_add(STEP / 2) {
            memory.measure(STEP);
        }
    }
}

impl Drop for Growth {
    fn drop(&mut self) {
        if let Some(memory) = &self.memory {
            memory.counted.fetch_sub(self.bytes, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use septet_protocol::transport::TransportError;

    use super::*;
    use crate::config::Stop;

    #[test]
    fn counts_stop_a_run_at_its_limit() {
        let stop = Stop::new(None, Some(MemoryLimit::new(10 * STEP, || None)));
        let [mut one, mut two] = [stop.growth(), stop.growth()];
        assert!(stop.admits(&mut one, 4 * STEP));
        assert!(stop.admits(&mut two, 4 * STEP));
        assert!(stop.admits(&mut two, 3 * STEP));
        drop(two);
        assert!(stop.admits(&mut one, 9 * STEP));
        assert_eq!(stop.check(), Ok(()));
        let mut two = stop.growth();
        assert!(!stop.admits(&mut two, STEP));
        let error = TransportError::Memory { used: 11 * STEP, limit: 10 * STEP };
        assert_eq!((stop.is_raised(), stop.check()), (true, Err(error)));
    }

    #[test]
    fn measurements_stop_a_run_at_its_limit() {
        let use_of = |limit| {
            let stop =
                Stop::new(None, Some(MemoryLimit::new(limit, || Some(MemoryUse { now: 50, peak: 90 }))));
            stop.measure();
            stop.check()
        };
        assert_eq!(use_of(90), Ok(()));
        // A peak above the limit is older than the run.
        assert_eq!(use_of(89), Ok(()));
        assert_eq!(use_of(49), Err(TransportError::Memory { used: 50, limit: 49 }));
    }

    #[test]
    fn a_run_without_a_limit_counts_nothing() {
        let stop = Stop::default();
        let mut growth = stop.growth();
        assert!(stop.admits(&mut growth, u64::MAX));
        stop.measure();
        assert_eq!((growth.bytes, stop.check()), (0, Ok(())));
    }
}
