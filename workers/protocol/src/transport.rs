//! The transport of messages: one sparse exchange per round.
//!
//! A *host* is a thread or process that runs one or more ranks. Once per round, every host calls
//! [`Transport::exchange`] with the messages of its ranks and its own state. The call is collective. It returns on every
//! host when all hosts have called it, with the messages to the host's ranks and the state of the machine. If a host has
//! failed or was interrupted, the call returns that error on every host.
//!
//! An implementation over MPI needs hosts of one rank, byte buffers ([`crate::message::Message::encode`]), one sparse
//! exchange (NBX, or counts by all-to-all) and an all-reduce of the states.

use bincode::{Decode, Encode};
use thiserror::Error;

use crate::ids::Rank;
use crate::message::Message;

/// The state of a host at the end of a round.
#[derive(Clone, Debug)]
pub enum HostState {
    /// Every rank of the host waits for messages or is done.
    Idle,
    /// A rank of the host has more to do although it may have sent nothing.
    Busy,
    /// A rank of the host failed, or the host was asked to stop ([`TransportError::Stopped`]).
    Failed(TransportError),
}

impl HostState {
    /// Returns the messages and the state of a host whose ranks sent `sent` and are `busy`.
    pub fn after<P>(
        sent: Result<Vec<Message<P>>, TransportError>,
        busy: bool,
    ) -> (Vec<Message<P>>, HostState) {
        match sent {
            Ok(outbox) if busy => (outbox, HostState::Busy),
            Ok(outbox) => (outbox, HostState::Idle),
            Err(error) => (Vec::new(), HostState::Failed(error)),
        }
    }

    /// Returns `true` if the host is busy.
    ///
    /// # Errors
    /// Returns the error of a host that failed or was interrupted.
    pub fn is_busy(self) -> Result<bool, TransportError> {
        match self {
            HostState::Idle => Ok(false),
            HostState::Busy => Ok(true),
            HostState::Failed(error) => Err(error),
        }
    }
}

/// The result of a round for one host.
#[derive(Debug)]
pub struct Delivery<P> {
    /// Messages to the ranks of this host, in any order.
    pub inbox: Vec<Message<P>>,
    /// Whether any rank of the machine sent a message or was busy. If `false`, the phase is over on all hosts.
    pub active: bool,
}

/// The reason why the machine stopped.
#[derive(Clone, Debug, PartialEq, Eq, Error, Encode, Decode)]
pub enum TransportError {
    /// A worker ended without a result.
    #[error("worker {rank} failed: {reason}")]
    WorkerFailed {
        /// The rank of the worker.
        rank: Rank,
        /// The reason.
        reason: String,
    },
    /// A message does not decode, or it names a rank that does not exist.
    #[error("bad message from rank {from}: {reason}")]
    BadMessage {
        /// The sender.
        from: Rank,
        /// The defect of the message.
        reason: String,
    },
    /// The run was interrupted.
    #[error("the run was stopped")]
    Stopped,
}

/// A way to move messages between the ranks of the machine.
pub trait Transport<P> {
    /// Ends a round: sends the messages of the host's ranks, and returns the messages to them.
    ///
    /// # Errors
    /// Fails if the state of this host or of another is an error, or if the transport failed. The machine has then
    /// ended.
    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError>;
}
