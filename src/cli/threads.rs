//! The number of threads of the process.

/// Limits the threads that read, prepare and write. Only the first call has an effect.
pub(super) fn limit_threads(threads: usize) {
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
}
