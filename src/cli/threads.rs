//! The number of threads of the process.

/// Makes reading, preparing and writing keep to so many threads. Only the first call counts: it comes before any work.
pub(super) fn limit_threads(threads: usize) {
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
}
