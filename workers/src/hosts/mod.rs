//! Hosts of ranks: the loop that polls them, and the transports between hosts.

pub mod host;
pub mod transport;
