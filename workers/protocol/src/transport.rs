//! How messages travel: one sparse exchange a round.
//!
//! A *host* is a thread or process that runs one or more ranks. Every host calls
//! [`Transport::exchange`] once a round with what its ranks send, and gets what was sent to them in the
//! same round, in any order. The call is collective: it returns on every host when all have sent, and
//! tells whether anything at all moved. A host of one rank, byte buffers and one sparse exchange (NBX, or
//! counts by all-to-all) with an all-reduce of the activity is all that an implementation over MPI needs:
//! [`crate::message::Message::encode`] gives the buffer.

use thiserror::Error;

use crate::ids::Rank;
use crate::message::Message;

/// What a round brought to one host.
#[derive(Debug)]
pub struct Delivery<P> {
    /// Messages to the ranks of this host, in any order.
    pub inbox: Vec<Message<P>>,
    /// Did any rank of the machine send, or say that it is busy? If not, the phase is over: every host
    /// learns so in the same call.
    pub active: bool,
}

/// Why the machine stopped.
#[derive(Clone, Debug, Error)]
pub enum TransportError {
    /// A worker ended without a result.
    #[error("worker {rank} failed: {reason}")]
    WorkerFailed {
        /// Its rank, 0 if it could not be told.
        rank: Rank,
        /// What it said last.
        reason: String,
    },
    /// A message that does not decode, or names a rank that is not there.
    #[error("bad message from rank {from}: {reason}")]
    BadMessage {
        /// The sender.
        from: Rank,
        /// What is wrong with it.
        reason: String,
    },
    /// The run was given up (interrupt, or another host's error).
    #[error("the run was stopped")]
    Stopped,
}

/// A way to move messages between the ranks of the machine.
pub trait Transport<P> {
    /// Number of ranks, the coordinator included.
    fn size(&self) -> u32;

    /// One round: sends the outbox, returns what was sent to this host's ranks. `busy` says that a rank
    /// here has more to do although it sends nothing.
    ///
    /// # Errors
    /// If a worker or the transport failed; then the machine is over.
    fn exchange(&mut self, outbox: Vec<Message<P>>, busy: bool) -> Result<Delivery<P>, TransportError>;
}
