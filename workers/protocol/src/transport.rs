//! The transport of messages: one sparse exchange per round.
//!
//! A *host* is a thread or process that runs one or more ranks. Once per round, every host calls
//! [`Transport::exchange`] with the messages of its ranks and its own state. The call is collective. It returns on every
//! host when all hosts have called it, with the messages to the host's ranks and the state of the machine. If a host has
//! failed or was interrupted, the call returns that error on every host.
//!
//! A [`ProcessTransport`] connects processes, each of which is one host. An implementation over MPI needs byte buffers
//! ([`crate::message::Message::encode`]), one sparse exchange (NBX, or counts by all-to-all) and an all-reduce of the states.

use std::ops::Range;

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
    /// A process reached its limit of memory.
    #[error("the run uses {used} bytes of memory, more than the limit of {limit}")]
    Memory {
        /// The bytes that the process uses, or is about to use.
        used: u64,
        /// The limit.
        limit: u64,
    },
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

/// The processes of the ranks of a run. Each process runs a range of workers, and process 0 also runs the coordinator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    workers: u32,
    processes: u32,
}

impl Placement {
    /// Places the workers on the processes in equal shares. Returns `None` if a process would have no worker, or if there
    /// are no processes.
    pub fn new(workers: u32, processes: u32) -> Option<Self> {
        (processes > 0 && workers >= processes).then_some(Placement { workers, processes })
    }

    /// Returns the number of workers.
    pub fn workers(self) -> u32 {
        self.workers
    }

    /// Returns the number of processes.
    pub fn processes(self) -> u32 {
        self.processes
    }

    /// Returns the process that runs a rank.
    pub fn process_of(self, rank: Rank) -> u32 {
        let worker = u64::from(rank.saturating_sub(1));
        (worker * u64::from(self.processes) / u64::from(self.workers)) as u32
    }

    /// Returns `true` if a worker has this rank.
    pub fn has_worker(self, rank: Rank) -> bool {
        (1..=self.workers).contains(&rank)
    }

    /// Returns the ranks of the workers that a process runs. A process after those of the placement runs none.
    pub fn workers_of(self, process: u32) -> Range<Rank> {
        let processes = u64::from(self.processes);
        let first =
            |process: u64| 1 + (process.min(processes) * u64::from(self.workers)).div_ceil(processes) as Rank;
        first(u64::from(process))..first(u64::from(process) + 1)
    }
}

/// A transport between processes. Each process is one host, which runs the ranks of its place.
pub trait ProcessTransport<P>: Transport<P> {
    /// Returns the number of this process, counted from 0.
    fn process(&self) -> u32;

    /// Returns the number of processes.
    fn processes(&self) -> u32;

    /// Begins a run. [`Placement::process_of`] then gives the process that receives a message.
    fn begin(&mut self, placement: Placement);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rank_has_one_process() {
        for (workers, processes) in
            [(1, 1), (5, 1), (5, 5), (7, 3), (8, 5), (1 << 20, 1000), (1 << 20, 1 << 20)]
        {
            let placement = Placement::new(workers, processes).unwrap();
            assert_eq!(placement.process_of(0), 0);
            let mut next = 1;
            for process in 0..processes {
                let ranks = placement.workers_of(process);
                assert!(ranks.start == next && !ranks.is_empty(), "{workers} {processes} {process}");
                assert!([ranks.start, ranks.end - 1].map(|r| placement.process_of(r)) == [process; 2]);
                next = ranks.end;
            }
            assert_eq!(next, workers + 1);
            assert!([processes, u32::MAX].iter().all(|&process| placement.workers_of(process).is_empty()));
        }
        assert_eq!([(3, 4), (3, 0), (0, 0)].map(|(w, p)| Placement::new(w, p)), [None; 3]);
    }
}
