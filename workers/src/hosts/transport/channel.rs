//! Hosts in threads. Every message goes through the channel of its receiver: buffers move, and their length is billed.
//! The workers share the available threads. A host with more than one core processes its leaves in parallel. The
//! coordinator runs on the thread of the caller.
//!
//! A round ends at a barrier that combines the states of the hosts. The machine cannot deadlock:
//! 1. Sends never block, because channels are unbounded. A channel never holds more than the messages of a round.
//! 2. Receives never wait. All messages of a round are in their channels when the barrier opens.
//! 3. A host that fails opens the barrier with its error.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{Builder, Scope, ScopedJoinHandle};

use crossbeam_channel::{Receiver, Sender, unbounded};
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Rank};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};
use tracing::dispatcher::{self, Dispatch};

use crate::config::Pool;
use crate::hosts::host::{Host, Job, Unwatched, Watch, serve};
use crate::hosts::transport::{Machine, MachineError};
use crate::share::Share;

/// The barrier of all hosts. Hosts share no other data.
pub(super) struct Barrier {
    state: Mutex<Round>,
    open: Condvar,
    hosts: usize,
}

#[derive(Default)]
struct Round {
    number: u64,
    waiting: usize,
    active: bool,
    /// Whether the last completed round was active.
    last: bool,
    failed: Option<TransportError>,
}

impl Barrier {
    /// Creates the barrier of this number of hosts.
    pub(super) fn new(hosts: usize) -> Self {
        Barrier { state: Mutex::default(), open: Condvar::new(), hosts }
    }

    /// Waits for all hosts. Returns `true` if any of them was active.
    pub(super) fn wait(&self, active: bool) -> Result<bool, TransportError> {
        let mut round = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = &round.failed {
            return Err(error.clone());
        }
        round.active |= active;
        round.waiting += 1;
        if round.waiting == self.hosts {
            round.last = round.active;
            round.active = false;
            round.waiting = 0;
            round.number += 1;
            self.open.notify_all();
            return Ok(round.last);
        }
        let number = round.number;
        while round.number == number {
            if let Some(error) = &round.failed {
                return Err(error.clone());
            }
            round = self.open.wait(round).unwrap_or_else(PoisonError::into_inner);
        }
        // The round is complete for all hosts, even if one of them has ended since.
        Ok(round.last)
    }

    /// Opens the barrier with an error. Returns the first error of the machine.
    pub(super) fn fail(&self, error: TransportError) -> TransportError {
        let mut round = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let first = round.failed.get_or_insert(error).clone();
        self.open.notify_all();
        first
    }
}

/// One host's end of the channels.
struct End<P> {
    senders: Arc<Vec<Sender<Message<P>>>>,
    /// The receivers of this host's ranks.
    receivers: Vec<Receiver<Message<P>>>,
    barrier: Arc<Barrier>,
    round: u32,
    /// Messages of a round that this host has not started.
    early: Vec<Message<P>>,
    /// Whether all ranks of this host are done.
    finished: bool,
}

impl<P: Point> End<P> {
    /// Ends a host whose ranks are done.
    fn finish(mut self) {
        self.finished = true;
    }

    fn round(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let active = state.is_busy()? || !outbox.is_empty();
        for message in outbox {
            let Some(sender) = self.senders.get(message.to as usize) else {
                let reason = format!("there is no rank {}", message.to);
                return Err(TransportError::BadMessage { from: message.from, reason });
            };
            sender.send(message).map_err(|_| TransportError::Stopped)?;
        }
        let active = self.barrier.wait(active)?;
        let now = self.round;
        self.round += 1;
        let mut inbox = Vec::new();
        let mut arrived = std::mem::take(&mut self.early);
        for receiver in &self.receivers {
            arrived.extend(receiver.try_iter());
        }
        for message in arrived {
            // A faster host may have started the next round already.
            if message.round <= now { inbox.push(message) } else { self.early.push(message) }
        }
        Ok(Delivery { inbox, active })
    }
}

impl<P: Point> Transport<P> for End<P> {
    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        self.round(outbox, state).map_err(|error| self.barrier.fail(error))
    }
}

impl<P> Drop for End<P> {
    fn drop(&mut self) {
        // A host that ends before its ranks are done must not block the other hosts.
        if !self.finished {
            self.barrier.fail(TransportError::Stopped);
        }
    }
}

/// A machine of threads.
pub(crate) struct Channels {
    threads: usize,
}

impl Channels {
    /// Creates a machine whose workers share this number of threads, at least one.
    pub(crate) fn new(threads: usize) -> Self {
        Channels { threads: threads.max(1) }
    }
}

/// The thread of a host. It returns the shares of its ranks.
type HostThread<'scope, P> = ScopedJoinHandle<'scope, Result<Vec<Share<P>>, TransportError>>;

/// The channels and the barrier of a machine.
struct Wires<P> {
    senders: Arc<Vec<Sender<Message<P>>>>,
    receivers: Vec<Option<Receiver<Message<P>>>>,
    barrier: Arc<Barrier>,
}

impl<P: Point> Wires<P> {
    fn new(ranks: u32, hosts: usize) -> Self {
        let (senders, receivers): (Vec<_>, Vec<_>) = (0..ranks).map(|_| unbounded()).unzip();
        let barrier = Arc::new(Barrier::new(hosts));
        Wires { senders: Arc::new(senders), receivers: receivers.into_iter().map(Some).collect(), barrier }
    }

    /// Returns the end of a host of these ranks.
    fn end(&mut self, ranks: &[Rank]) -> End<P> {
        End {
            senders: self.senders.clone(),
            receivers: ranks.iter().filter_map(|&r| self.receivers[r as usize].take()).collect(),
            barrier: self.barrier.clone(),
            round: 0,
            early: Vec::new(),
            finished: false,
        }
    }
}

/// Starts the thread of a host.
fn spawn<'scope, 'env, P: Point>(
    scope: &'scope Scope<'scope, 'env>,
    job: &'env Job<'env, P>,
    name: String,
    ranks: Vec<Rank>,
    (mut end, pool): (End<P>, Pool),
) -> std::io::Result<HostThread<'scope, P>> {
    // The subscriber of the caller also receives the traces of the workers.
    let listener = dispatcher::get_default(Clone::clone);
    Builder::new().name(name).spawn_scoped(scope, move || {
        dispatcher::with_default(&listener, || {
            let mut host = Host::new(ranks.into_iter(), job, &pool);
            serve(&mut end, &mut host, &mut Unwatched)?;
            end.finish();
            Ok(host.into_shares())
        })
    })
}

impl<P: Point> Machine<P> for Channels {
    fn run(&mut self, job: &Job<'_, P>, watch: &mut dyn Watch) -> Result<Vec<Share<P>>, MachineError> {
        let (threads, workers) = (self.threads, job.config.workers);
        let hosts = threads.min(workers as usize);
        let mut wires = Wires::new(job.config.ranks(), hosts + 1);
        let mut end = wires.end(&[COORDINATOR]);
        let listener = dispatcher::get_default(Clone::clone);
        std::thread::scope(|scope| {
            let mut running = Vec::new();
            for host in 0..hosts {
                let ranks: Vec<Rank> = (1..=workers).filter(|r| (*r as usize - 1) % hosts == host).collect();
                let ends = (wires.end(&ranks), pool(threads, hosts, host, &listener)?);
                running.push(spawn(scope, job, format!("septet-{host}"), ranks, ends)?);
            }
            let mut host = Host::new(std::iter::once(COORDINATOR), job, &None);
            serve(&mut end, &mut host, watch)?;
            end.finish();
            let mut shares = host.into_shares();
            for (first, thread) in (1..).zip(running) {
                let reason = "its host ended before its ranks were done".to_string();
                let ended = |_| TransportError::WorkerFailed { rank: first, reason };
                shares.extend(thread.join().map_err(ended)??);
            }
            shares.sort_by_key(|share| share.rank);
            Ok(shares)
        })
    }
}

/// Creates the threads of a host, which its workers share. If the threads do not divide evenly, the first hosts get
/// one more thread each.
pub(super) fn pool(threads: usize, hosts: usize, host: usize, listener: &Dispatch) -> std::io::Result<Pool> {
    let own = threads / hosts + usize::from(host < threads % hosts);
    if own < 2 {
        return Ok(None);
    }
    let builder = rayon::ThreadPoolBuilder::new().num_threads(own).spawn_handler(|thread| {
        let listener = listener.clone();
        let run = move || dispatcher::with_default(&listener, || thread.run());
        std::thread::Builder::new().spawn(run).map(drop)
    });
    builder.build().map(|p| Some(Arc::new(p))).map_err(std::io::Error::other)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    /// The ends of a machine of two hosts without ranks.
    fn ends() -> [End<DVec2>; 2] {
        let barrier = Arc::new(Barrier::new(2));
        [(); 2].map(|()| End {
            senders: Arc::default(),
            receivers: Vec::new(),
            barrier: barrier.clone(),
            round: 0,
            early: Vec::new(),
            finished: false,
        })
    }

    #[test]
    fn a_host_that_ends_early_ends_the_others() {
        let [mut stays, leaves] = ends();
        let waiting = std::thread::spawn(move || stays.exchange(Vec::new(), HostState::Busy).map(drop));
        drop(leaves);
        assert_eq!(waiting.join().unwrap(), Err(TransportError::Stopped));
    }

    #[test]
    fn a_host_whose_ranks_are_done_does_not_fail_the_machine() {
        let [mut stays, leaves] = ends();
        let round = std::thread::spawn(move || {
            let mut leaves = leaves;
            let delivery = leaves.exchange(Vec::new(), HostState::Idle).unwrap();
            leaves.finish();
            delivery.active
        });
        assert!(!stays.exchange(Vec::new(), HostState::Idle).unwrap().active);
        assert!(!round.join().unwrap());
        assert!(stays.barrier.state.lock().unwrap().failed.is_none());
    }
}
