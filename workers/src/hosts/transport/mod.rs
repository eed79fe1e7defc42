//! Machines: hosts in threads over channels, one host on the thread of the caller, or processes that each call the library.

mod alone;

mod channel;

mod frames;

pub mod over_wire;

pub mod process;

mod sim;

#[cfg(unix)]
pub mod socket;

use septet_geometry::point::Point;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::transport::{Transport, TransportError};
use thiserror::Error;

use crate::hosts::host::{Host, Job, Watch, serve};
use crate::share::Share;

/// The reason why a machine has no result.
#[derive(Debug, Error)]
pub enum MachineError {
    /// A host did not start.
    #[error("a host of the machine does not start: {0}")]
    Start(#[from] std::io::Error),
    /// A rank or the transport failed, or the run was interrupted.
    #[error(transparent)]
    Transport(#[from] TransportError),
}

/// The hosts that run the ranks of a job.
pub trait Machine<P: Point> {
    /// Runs all ranks to their end. `watch` observes the host of the coordinator. Returns the shares of the ranks in the
    /// order of the ranks.
    ///
    /// # Errors
    /// Fails if a host does not start, or with the first error of a rank or of the transport.
    fn run(&mut self, job: &Job<'_, P>, watch: &mut dyn Watch) -> Result<Vec<Share<P>>, MachineError>;
}

/// A machine of one host, on the thread of the caller. The transport moves the messages between its ranks.
pub struct OneHost<T>(pub T);

impl<P: Point, T: Transport<P>> Machine<P> for OneHost<T> {
    fn run(&mut self, job: &Job<'_, P>, watch: &mut dyn Watch) -> Result<Vec<Share<P>>, MachineError> {
        let mut host = Host::new(COORDINATOR..job.config.ranks(), job, &None);
        serve(&mut self.0, &mut host, watch)?;
        Ok(host.into_shares())
    }
}

/// A kind of machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportKind {
    /// Hosts in threads, every message through a channel. A single thread is that of the caller, and needs no channels.
    Channel {
        /// Threads that run workers.
        threads: usize,
    },
    /// All ranks on one thread. Every message is encoded, then decoded by its receiver. The order of delivery is drawn
    /// from a seed.
    Sim {
        /// Seed of the order.
        delivery_seed: u64,
    },
}

/// Returns a machine of a kind.
pub fn machine<P: Point>(kind: TransportKind) -> Box<dyn Machine<P>> {
    match kind {
        TransportKind::Channel { threads: 0 | 1 } => Box::new(OneHost(alone::Alone)),
        TransportKind::Channel { threads } => Box::new(channel::Channels::new(threads)),
        TransportKind::Sim { delivery_seed } => Box::new(OneHost(sim::Sim::<P>::new(delivery_seed))),
    }
}

#[cfg(test)]
mod tests;
