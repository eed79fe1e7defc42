//! The machine that a run uses.

use std::fmt;

pub use septet_workers::config::cores::cores;
use septet_workers::transport::TransportKind;

use crate::spec::SpecError;
use crate::spec::value::{Setting, Value};

/// The seed of the random draws, unless another is given.
pub const DEFAULT_SEED: u64 = 1;

/// The number of workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workers {
    /// At most one for each thread. `triangulate` takes fewer if the points are few, or if many circumballs are large, because
    /// more workers would then do more work and not end sooner. Other runs take one for each thread.
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
    /// Between processes, which the caller connects ([`crate::run::processes`]). A run in one process uses channels.
    Processes {
        /// Number of processes; by default, the caller decides it.
        processes: Option<u32>,
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

impl Value for Workers {
    fn read(text: &str) -> Result<Self, String> {
        let number = || text.parse().map(Workers::Count);
        match text {
            "auto" => Ok(Workers::Auto),
            "leaves" => Ok(Workers::Leaves),
            _ => number().map_err(|_| "expected a number of workers, `auto` or `leaves`".into()),
        }
    }

    fn setting(&self) -> Setting {
        Setting::Text(self.to_string())
    }
}

/// A transport without its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportName {
    /// [`Transport::Channel`].
    Channel,
    /// [`Transport::Sim`].
    Sim,
    /// [`Transport::Processes`].
    Processes,
}
words!(TransportName {
    Channel "channel" "Channels between threads",
    Sim "sim" "A simulator on one thread",
    Processes "processes" "Sockets between processes, each of which reads and writes its share",
});

impl TransportName {
    /// Returns the transport with its default parameters.
    pub fn transport(self) -> Transport {
        match self {
            TransportName::Channel => Transport::Channel,
            TransportName::Sim => Transport::Sim { delivery_seed: 0 },
            TransportName::Processes => Transport::Processes { processes: None },
        }
    }
}

impl Transport {
    /// Returns the name.
    pub fn kind(self) -> TransportName {
        match self {
            Transport::Channel => TransportName::Channel,
            Transport::Sim { .. } => TransportName::Sim,
            Transport::Processes { .. } => TransportName::Processes,
        }
    }

    /// Returns the seed of the order of delivery of [`Transport::Sim`].
    pub fn delivery_seed(self) -> Option<u64> {
        if let Transport::Sim { delivery_seed } = self { Some(delivery_seed) } else { None }
    }

    /// Returns the number of processes of [`Transport::Processes`], if it is given.
    pub fn processes(self) -> Option<u32> {
        if let Transport::Processes { processes } = self { processes } else { None }
    }

    /// Sets the seed of the order of delivery.
    pub(super) fn set_delivery_seed(&mut self, seed: Option<u64>) -> Result<(), SpecError> {
        match (self, seed) {
            (Transport::Sim { delivery_seed }, Some(seed)) => *delivery_seed = seed,
            (_, None) => {}
            _ => return Err(SpecError::Needs { option: "delivery-seed", needed: "transport", word: "sim" }),
        }
        Ok(())
    }

    /// Sets the number of processes.
    pub(super) fn set_processes(&mut self, number: Option<u32>) -> Result<(), SpecError> {
        match (self, number) {
            (Transport::Processes { processes }, number) => *processes = number,
            (_, None) => {}
            _ => {
                return Err(SpecError::Needs { option: "processes", needed: "transport", word: "processes" });
            }
        }
        Ok(())
    }
}

/// The vector registers of the inner loops. Results are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Registers {
    /// The widest registers of the processor.
    #[default]
    Widest,
    /// The registers that every processor of the architecture has. The whole program then uses them from the first such
    /// run on.
    Baseline,
}
words!(Registers {
    Widest "widest" "The widest registers of the processor",
    Baseline "baseline" "The registers that every processor of the architecture has",
});

/// The machine that a call runs on. Results do not depend on workers, threads and transport.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Machine {
    /// Number of workers; [`Workers::Auto`] by default.
    pub workers: Workers,
    /// Number of threads that run the workers of this process. By default, the number of cores, and 1 in
    /// [`crate::run::distributed`].
    pub threads: Option<usize>,
    /// The vector registers of the inner loops.
    pub registers: Registers,
    /// The transport of messages.
    pub transport: Transport,
    /// Seed of every random draw.
    pub seed: u64,
    /// Name of the run in messages and traces; by default, the seed. Runs that are traced into one file at the same
    /// time need different names.
    pub run: Option<u64>,
    /// The most memory that this process may use, in bytes. A run that needs more stops.
    pub max_memory: Option<u64>,
}

impl Default for Machine {
    fn default() -> Self {
        Machine {
            workers: Workers::Auto,
            threads: None,
            registers: Registers::Widest,
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
            Transport::Channel | Transport::Processes { .. } => {
                TransportKind::Channel { threads: self.thread_count() }
            }
            Transport::Sim { delivery_seed } => TransportKind::Sim { delivery_seed },
        }
    }
}
