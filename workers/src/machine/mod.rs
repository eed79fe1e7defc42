//! The machine as a rank sees it: its context, its host, and the transports between hosts.

pub mod context;
pub mod host;
pub mod outbox;
pub mod profile;
pub mod transport;

pub use context::{Context, Running};
