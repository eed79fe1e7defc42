//! The threads of a command beside those of the machine.

use septet::workers::cores::Cores;

/// Reading, preparing and writing keep to so many threads, on a core each if there are as many. It can be set only once: before
/// any work.
pub fn limit(threads: usize) {
    let cores = Cores::for_threads(threads);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let _ = pool.start_handler(move |index| cores.stay(index)).build_global();
}
