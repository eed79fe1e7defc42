//! The reasons to stop a run before its end: the request of the caller, and the limit of memory.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use septet_protocol::transport::TransportError;

use super::memory::{Growth, MemoryLimit};

/// A flag that the caller of a machine may set, and the limit of the memory of the process. Ranks check both at every
/// exchange and during long steps, and stop if the flag is set or the limit is reached.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    flag: Option<Arc<AtomicBool>>,
    memory: Option<Arc<MemoryLimit>>,
}

impl Stop {
    /// Wraps the flag and the limit, if there are any.
    pub fn new(flag: Option<Arc<AtomicBool>>, memory: Option<MemoryLimit>) -> Self {
        Stop { flag, memory: memory.map(Arc::new) }
    }

    /// Returns `true` if the flag is set or the limit is reached.
    pub fn is_raised(&self) -> bool {
        self.flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
            || self.memory.as_ref().is_some_and(|memory| memory.reached().is_some())
    }

    /// Checks the flag and the limit.
    ///
    /// # Errors
    /// Returns [`TransportError::Stopped`] if the flag is set, and [`TransportError::Memory`] if the limit is reached.
    pub fn check(&self) -> Result<(), TransportError> {
        match self.memory.as_ref().and_then(|memory| memory.reached()) {
            Some((used, limit)) => Err(TransportError::Memory { used, limit }),
            None if self.is_raised() => Err(TransportError::Stopped),
            None => Ok(()),
        }
    }

    /// Measures the memory of the process, if it has a limit. The next check fails if it is too large.
    pub fn measure(&self) {
        if let Some(memory) = &self.memory {
            memory.measure(0);
        }
    }

    /// Returns the count of a structure that will grow.
    pub(crate) fn growth(&self) -> Growth {
        Growth::new(self.memory.clone())
    }

    /// Counts the bytes of a structure that grows. Returns `true` if it may grow by another [`super::STEP`].
    pub(crate) fn admits(&self, growth: &mut Growth, bytes: u64) -> bool {
        growth.count(bytes);
        !self.is_raised()
    }
}
