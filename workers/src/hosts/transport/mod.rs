//! Transports: workers in threads over channels, simulated on one thread, or as processes over pipes.

mod channel;

mod frames;

pub mod pipe;

mod sim;

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::transport::Transport;

use crate::config::WorkerConfig;

/// A kind of transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportKind {
    /// Workers in threads, every message through a channel.
    Channel {
        /// Threads that run workers.
        threads: usize,
    },
    /// All workers on one thread. Every message is encoded, then decoded by its receiver. The order of delivery is drawn
    /// from a seed.
    Sim {
        /// Seed of the order.
        delivery_seed: u64,
    },
}

/// Starts the workers of a machine. Returns the coordinator's end of the transport. Dropping it ends the workers.
///
/// # Errors
/// Fails if threads cannot be started.
pub fn launch<P: Point>(
    kind: TransportKind,
    config: &Arc<WorkerConfig>,
) -> std::io::Result<Box<dyn Transport<P>>> {
    match kind {
        TransportKind::Channel { threads } => Ok(Box::new(channel::Channel::launch(config, threads)?)),
        TransportKind::Sim { delivery_seed } => Ok(Box::new(sim::Sim::new(config, delivery_seed))),
    }
}

#[cfg(test)]
mod tests;
