//! Processes that each call the library, and hold a part of the points.
//!
//! A process is one host, which runs a range of workers on the thread of the caller. The transport between processes
//! belongs to the caller. [`channels`] connects threads of one program in the same way.

use std::sync::Arc;

use crossbeam_channel::{Receiver, Sender, unbounded};
use septet_geometry::point::Point;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::message::Message;
use septet_protocol::transport::{
    Delivery, HostState, Placement, ProcessTransport, Transport, TransportError,
};
use tracing::dispatcher;

use crate::hosts::host::{Host, Job, Watch, serve};
use crate::hosts::transport::channel::{Barrier, pool};
use crate::hosts::transport::{Machine, MachineError};
use crate::share::Share;

/// The machine of one process: its ranks, and the transport to the other processes. It returns the shares of its own ranks
/// only.
pub struct OneProcess<'a, P> {
    /// The transport.
    pub transport: &'a mut dyn ProcessTransport<P>,
    /// The places of the ranks.
    pub placement: Placement,
    /// Number of threads on which the ranks of this process compute.
    pub threads: usize,
}

impl<P: Point> Machine<P> for OneProcess<'_, P> {
    fn run(&mut self, job: &Job<'_, P>, watch: &mut dyn Watch) -> Result<Vec<Share<P>>, MachineError> {
        let process = self.transport.process();
        let workers = self.placement.workers_of(process);
        self.transport.begin(self.placement);
        let pool = match pool(self.threads, 1, 0, &dispatcher::get_default(Clone::clone)) {
            Ok(pool) => pool,
            Err(error) => {
                let reason = format!("the threads of process {process} do not start: {error}");
                let failed = TransportError::WorkerFailed { rank: workers.start, reason };
                self.transport.exchange(Vec::new(), HostState::Failed(failed))?;
                return Err(error.into());
            }
        };
        let coordinator = (process == 0).then_some(COORDINATOR);
        let mut host = Host::new(coordinator.into_iter().chain(workers), job, &pool);
        serve(self.transport, &mut host, watch)?;
        Ok(host.into_shares())
    }
}

/// A message with the number of the exchange in which it was sent.
type Numbered<P> = (u64, Message<P>);

/// The end of one process of the channels between processes.
struct End<P> {
    process: usize,
    placement: Option<Placement>,
    senders: Arc<Vec<Sender<Numbered<P>>>>,
    receiver: Receiver<Numbered<P>>,
    barrier: Arc<Barrier>,
    /// Number of exchanges of all runs.
    exchanges: u64,
    /// Messages of an exchange that this process has not started.
    early: Vec<Numbered<P>>,
}

/// Returns the ends of channels between threads of one program, one for each process of a run. A process whose end is
/// dropped during a run ends the run with an error.
pub fn channels<P: Point>(processes: u32) -> Vec<impl ProcessTransport<P> + Send> {
    let (senders, receivers): (Vec<_>, Vec<_>) = (0..processes).map(|_| unbounded()).unzip();
    let (senders, barrier) = (Arc::new(senders), Arc::new(Barrier::new(processes as usize)));
    let end = |(process, receiver)| End {
        process,
        placement: None,
        senders: senders.clone(),
        receiver,
        barrier: barrier.clone(),
        exchanges: 0,
        early: Vec::new(),
    };
    receivers.into_iter().enumerate().map(end).collect()
}

impl<P: Point> End<P> {
    fn round(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let active = state.is_busy()? || !outbox.is_empty();
        let now = self.exchanges;
        self.exchanges += 1;
        for message in outbox {
            let process = self.placement.map(|placement| placement.process_of(message.to) as usize);
            let Some(sender) = process.and_then(|process| self.senders.get(process)) else {
                let reason = format!("there is no rank {}", message.to);
                return Err(TransportError::BadMessage { from: message.from, reason });
            };
            sender.send((now, message)).map_err(|_| TransportError::Stopped)?;
        }
        let active = self.barrier.wait(active)?;
        let mut arrived = std::mem::take(&mut self.early);
        arrived.extend(self.receiver.try_iter());
        // A faster process may have started the next exchange already.
        let (early, inbox) = arrived.into_iter().partition(|(sent, _)| *sent > now);
        self.early = early;
        let inbox: Vec<Numbered<P>> = inbox;
        Ok(Delivery { inbox: inbox.into_iter().map(|(_, message)| message).collect(), active })
    }
}

impl<P: Point> Transport<P> for End<P> {
    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        self.round(outbox, state).map_err(|error| self.barrier.fail(error))
    }
}

impl<P: Point> ProcessTransport<P> for End<P> {
    fn process(&self) -> u32 {
        self.process as u32
    }

    fn processes(&self) -> u32 {
        self.senders.len() as u32
    }

    fn begin(&mut self, placement: Placement) {
        self.placement = Some(placement);
    }
}

impl<P> Drop for End<P> {
    fn drop(&mut self) {
        // All processes end a run in the same exchange, so this ends only a run that is not complete.
        self.barrier.fail(TransportError::Stopped);
    }
}
