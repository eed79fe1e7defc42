//! Threads and cancellation of a call, and the options of a triangulation.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use septet_core::cores::{cores, within};
use septet_core::spec::{DEFAULT_SEED, ProgressFn, Workers};
use septet_core::{Door, Spec};
use septet_queries::QueryError;

use crate::failure::Failure;
use crate::sites::Sites;

/// The most threads for each core. More would only wait for each other.
const OVERSUBSCRIBED: usize = 4;

/// The threads of a call, its cancellation, and the words of its failures.
#[derive(Clone, Debug)]
pub struct Call {
    /// The language of the caller.
    pub door: Door,
    /// Number of threads; by default, that of the cores. With one thread, the call runs on the thread of its caller.
    pub threads: Option<usize>,
    /// A flag that ends the call when it becomes `true`.
    pub cancel: Option<Arc<AtomicBool>>,
}

impl Call {
    /// Creates a call on all cores that is never cancelled.
    pub fn new(door: Door) -> Self {
        Call { door, threads: None, cancel: None }
    }

    /// Returns the call with a number of threads; 0 means all cores.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = (threads > 0).then_some(threads);
        self
    }

    /// Returns the call with a flag that ends it.
    #[must_use]
    pub fn cancel(mut self, flag: Arc<AtomicBool>) -> Self {
        self.cancel = Some(flag);
        self
    }

    /// Returns the number of threads that the call starts, if the caller chose one: at most [`OVERSUBSCRIBED`] for each core.
    pub(crate) fn bounded(&self) -> Option<usize> {
        let most = |threads: usize| {
            if threads > 16 { threads.min((OVERSUBSCRIBED * cores()).max(16)) } else { threads }
        };
        self.threads.map(most)
    }

    /// Runs `f` on the threads of this call.
    ///
    /// # Errors
    /// Fails with [`septet_core::Code::Interrupted`] if the flag was set.
    pub fn within<T>(&self, f: impl FnOnce() -> T) -> Result<T, Failure> {
        if self.cancel.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)) {
            return Err(Failure::interrupted());
        }
        Ok(within(self.bounded().unwrap_or_else(cores), self.cancel.clone(), f)?)
    }

    /// Runs a query on the threads of this call.
    pub(crate) fn ask<T>(&self, query: impl FnOnce() -> Result<T, QueryError>) -> Result<T, Failure> {
        self.within(query)?.map_err(|error| Failure::of_query(&error, self.door))
    }
}

/// The options of a triangulation.
#[derive(Clone)]
pub struct Request {
    /// The threads and the cancellation.
    pub call: Call,
    /// Seed of every random draw. Results do not depend on it.
    pub seed: u64,
    /// Whether points that are not finite are dropped. Otherwise they are an error.
    pub skip_invalid: bool,
    /// The most memory that the process may use, in bytes.
    pub max_memory: Option<u64>,
    /// The weights of the points, and their periodic box.
    pub sites: Sites,
    /// The callback for progress, on the thread of the call.
    pub progress: Option<ProgressFn>,
}

impl Request {
    /// Creates a request with the defaults of the program.
    pub fn new(call: Call) -> Self {
        Request {
            call,
            seed: DEFAULT_SEED,
            skip_invalid: false,
            max_memory: None,
            sites: Sites::default(),
            progress: None,
        }
    }

    /// Returns the specification of the run. On one thread, there is one worker.
    pub fn spec(&self) -> Spec {
        let mut spec = Spec::default();
        spec.input.skip_invalid = self.skip_invalid;
        spec.input.periodic.clone_from(&self.sites.periodic);
        spec.machine.threads = self.call.bounded();
        if self.call.threads == Some(1) {
            spec.machine.workers = Workers::Count(1);
        }
        spec.machine.seed = self.seed;
        spec.machine.max_memory = self.max_memory;
        spec.control.cancel.clone_from(&self.call.cancel);
        spec.control.progress.clone_from(&self.progress);
        spec
    }
}
