//! The number of threads of the process.

/// Limits the number of threads for reading, preparation and writing. Only the first call has an effect.
pub(super) fn limit_threads(threads: usize) {
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
}
