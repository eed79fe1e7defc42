//! The request to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use septet_protocol::transport::TransportError;

/// A flag that the caller of a machine may set. Ranks check it at every exchange and during long steps, and stop if
/// it is set.
#[derive(Clone, Debug, Default)]
pub struct Stop(Option<Arc<AtomicBool>>);

impl Stop {
    /// Wraps the flag, if there is one.
    pub fn new(flag: Option<Arc<AtomicBool>>) -> Self {
        Stop(flag)
    }

    /// Returns `true` if the flag is set.
    pub fn is_raised(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Checks the flag.
    ///
    /// # Errors
    /// Returns [`TransportError::Stopped`] if the flag is set.
    pub fn check(&self) -> Result<(), TransportError> {
        if self.is_raised() { Err(TransportError::Stopped) } else { Ok(()) }
    }
}
