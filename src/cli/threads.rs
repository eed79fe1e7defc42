//! The threads of a command beside those of the machine.

use septet::workers::affinity::Affinity;

/// Reading, preparing and writing keep to so many threads, on a core each if there are exactly as many. It can be set only once:
/// before any work.
pub fn limit(threads: usize) {
    let affinity = Affinity::for_threads(threads);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let _ = pool.start_handler(move |index| affinity.stay(index)).build_global();
}
