//! The machine that a run uses.

use std::fmt;

use septet_workers::transport::TransportKind;

/// The seed of the random draws, unless another is given.
pub const DEFAULT_SEED: u64 = 1;

/// The number of workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workers {
    /// At most one for each core. `triangulate` takes fewer if the points are few, or if many circumballs are large, because
    /// more workers would then do more work and not end sooner. Other runs take one for each core.
    Auto,
    /// A fixed number, at least one. It is independent of the number of cores.
    Count(u32),
    /// One worker for each leaf of the partition tree. Every split and every merge then sends messages.
    Leaves,
}

/// The transport of messages between workers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Transport {
    /// Over channels between threads.
    #[default]
    Channel,
    /// On one thread, with every message encoded and decoded.
    Sim {
        /// Seed of the order of delivery.
        delivery_seed: u64,
    },
}

impl fmt::Display for Workers {
    /// Writes the value as it is given on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Workers::Auto => f.write_str("auto"),
            Workers::Count(workers) => workers.fmt(f),
            Workers::Leaves => f.write_str("leaves"),
        }
    }
}

impl Transport {
    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Transport::Channel => "channel",
            Transport::Sim { .. } => "sim",
        }
    }

    /// Returns the seed of the order of delivery. Returns `None` for channels.
    pub fn delivery_seed(self) -> Option<u64> {
        match self {
            Transport::Channel => None,
            Transport::Sim { delivery_seed } => Some(delivery_seed),
        }
    }
}

/// The machine that a call runs on. Results do not depend on workers, threads and transport.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Machine {
    /// Number of workers; [`Workers::Auto`] by default.
    pub workers: Workers,
    /// Number of threads that run the workers of this process. By default, the number of cores, and 1 in
    /// [`crate::run::distributed`].
    pub threads: Option<usize>,
    /// The transport of messages.
    pub transport: Transport,
    /// Seed of every random draw.
    pub seed: u64,
    /// Name of the run in messages and traces; by default, the seed. Runs that are traced into one file at the same
    /// time need different names.
    pub run: Option<u64>,
    /// Largest memory forecast that is accepted, in bytes.
    pub max_memory: Option<u64>,
}

/// Returns the number of cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

impl Default for Machine {
    fn default() -> Self {
        Machine {
            workers: Workers::Auto,
            threads: None,
            transport: Transport::Channel,
            seed: DEFAULT_SEED,
            run: None,
            max_memory: None,
        }
    }
}

impl Machine {
    /// Returns the machine after a change.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Machine)) -> Self {
        change(&mut self);
        self
    }

    /// Returns the name of the run in messages and traces.
    pub fn name(&self) -> u64 {
        self.run.unwrap_or(self.seed)
    }

    /// Returns the number of threads that run the workers of the only process.
    pub fn thread_count(&self) -> usize {
        self.threads.unwrap_or_else(cores)
    }

    /// Returns the kind of transport that starts the workers.
    pub fn transport_kind(&self) -> TransportKind {
        match self.transport {
            Transport::Channel => TransportKind::Channel { threads: self.thread_count() },
            Transport::Sim { delivery_seed } => TransportKind::Sim { delivery_seed },
        }
    }
}
