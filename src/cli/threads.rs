//! The threads of a command beside those of the machine.

use septet_core::config::{Transport, Workers};
use septet_workers::affinity::Affinity;

/// Reading, preparing and writing keep to so many threads; on a core each, as the hosts of a machine do, if that has as many
/// hosts and there are as many cores. It can be set only once: before any work.
pub fn limit(threads: usize, hosts: usize) {
    let affinity = if hosts == threads { Affinity::for_threads(threads) } else { Affinity::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let _ = pool.start_handler(move |index| affinity.stay(index)).build_global();
}

/// How many threads of a machine are hosts of workers.
pub fn hosts(workers: Workers, transport: Transport) -> usize {
    match (transport, workers) {
        (Transport::Channel { threads }, Workers::Count(workers)) => threads.min(workers as usize),
        (Transport::Channel { threads }, Workers::Leaves) => threads,
        (Transport::Sim { .. }, _) => 1,
    }
}
