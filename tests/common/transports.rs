//! The transports of the machine within one process, so that one list of cases runs over all of them.

use septet_core::spec::Transport;
use septet_core::{Error, Outcome, Spec, simulate, triangulate};
use septet_geometry::point::Point;

/// A way to start the machine.
#[derive(Clone, Copy, Debug)]
pub enum TestTransport {
    /// Workers on this number of threads, with messages over channels.
    Channel(usize),
    /// All workers on one thread, with this seed of the order of delivery.
    Sim(u64),
}

impl TestTransport {
    /// Returns the configuration for this transport.
    pub fn configure(self, spec: &Spec) -> Spec {
        spec.clone().with(|c| match self {
            TestTransport::Channel(threads) => {
                c.machine.threads = Some(threads);
                c.machine.transport = Transport::Channel;
            }
            TestTransport::Sim(delivery_seed) => c.machine.transport = Transport::Sim { delivery_seed },
        })
    }

    /// Runs `simulate` (`counted`) or `triangulate` over this transport.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn run<P: Point>(self, points: &[P], spec: &Spec, counted: bool) -> Result<Outcome, Error> {
        let spec = self.configure(spec);
        if counted { simulate(points, &spec) } else { triangulate(points, &spec) }
    }
}

/// Calls `check` with each transport: channels with 1, 2 and 4 threads, and the simulator with three orders of delivery.
pub fn each_transport(check: impl FnMut(TestTransport)) {
    let channels = [1, 2, 4].map(TestTransport::Channel);
    let orders = [0, 1, 77].map(TestTransport::Sim);
    channels.into_iter().chain(orders).for_each(check);
}
