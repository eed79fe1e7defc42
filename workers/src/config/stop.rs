//! The request to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use septet_protocol::transport::TransportError;

/// A flag that whoever started a machine may raise: workers look at it within long steps, and end. It
/// carries nothing else.
#[derive(Clone, Debug, Default)]
pub struct Stop(Option<Arc<AtomicBool>>);

impl Stop {
    /// The flag, if there is one.
    pub fn new(flag: Option<Arc<AtomicBool>>) -> Self {
        Stop(flag)
    }

    /// Has it been raised?
    pub fn is_raised(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// An error once it has been raised.
    ///
    /// # Errors
    /// [`TransportError::Stopped`].
    pub fn check(&self) -> Result<(), TransportError> {
        if self.is_raised() { Err(TransportError::Stopped) } else { Ok(()) }
    }
}
