//! Workers in threads. Every message goes through the receiver's crossbeam channel; the buffers move, and
//! their length is billed. Any number of workers runs on the threads there are; a worker that has more than one core
//! to itself maps its leaves over them.
//!
//! A round ends at a barrier that sums what was sent. Sends never block (the channels are unbounded; a
//! round's messages bound them), receives never wait (everything sent in a round is in its channel when the
//! barrier opens), so no order of threads can lock up; a thread that fails opens the barrier with its error.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;

use crossbeam_channel::{Receiver, Sender, unbounded};
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Rank};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, Transport, TransportError};
use tracing::dispatcher::{self, Dispatch};

use crate::config::{Pool, WorkerConfig};
use crate::hosts::host::{Host, serve};

/// What all hosts of the machine share: a barrier, and no data.
struct Barrier {
    state: Mutex<Round>,
    open: Condvar,
    hosts: usize,
}

#[derive(Default)]
struct Round {
    number: u64,
    waiting: usize,
    active: bool,
    /// The outcome of the round that was completed last.
    last: bool,
    failed: Option<TransportError>,
}

impl Barrier {
    /// Waits for all hosts; tells whether any was active.
    fn wait(&self, active: bool) -> Result<bool, TransportError> {
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
        while round.number == number && round.failed.is_none() {
            round = self.open.wait(round).unwrap_or_else(PoisonError::into_inner);
        }
        match &round.failed {
            Some(error) => Err(error.clone()),
            None => Ok(round.last),
        }
    }

    fn fail(&self, error: TransportError) {
        let mut round = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        round.failed.get_or_insert(error);
        self.open.notify_all();
    }
}

/// One host's end of the channels.
struct End<P> {
    senders: Arc<Vec<Sender<Message<P>>>>,
    /// Receivers of this host's ranks.
    receivers: Vec<Receiver<Message<P>>>,
    barrier: Arc<Barrier>,
    round: u32,
    /// Messages of a round that has not begun here yet.
    early: Vec<Message<P>>,
}

impl<P: Point> Transport<P> for End<P> {
    fn size(&self) -> u32 {
        self.senders.len() as u32
    }

    fn exchange(&mut self, outbox: Vec<Message<P>>, busy: bool) -> Result<Delivery<P>, TransportError> {
        let active = busy || !outbox.is_empty();
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
            // A faster host may have begun the next round already.
            if message.round <= now { inbox.push(message) } else { self.early.push(message) }
        }
        Ok(Delivery { inbox, active })
    }
}

/// The coordinator's end of a machine of threads.
pub(crate) struct Channel<P> {
    end: End<P>,
    threads: Vec<JoinHandle<()>>,
}

impl<P: Point> Channel<P> {
    pub(crate) fn launch(config: &Arc<WorkerConfig>, threads: usize) -> std::io::Result<Self> {
        let threads = threads.max(1);
        let hosts = threads.min(config.workers as usize);
        let (mut senders, mut receivers) = (Vec::new(), Vec::new());
        for _ in 0..=config.workers {
            let (sender, receiver) = unbounded();
            senders.push(sender);
            receivers.push(Some(receiver));
        }
        let senders = Arc::new(senders);
        let barrier = Arc::new(Barrier { state: Mutex::default(), open: Condvar::new(), hosts: hosts + 1 });
        let mut end = |ranks: &[Rank]| End {
            senders: senders.clone(),
            receivers: ranks.iter().filter_map(|&r| receivers[r as usize].take()).collect(),
            barrier: barrier.clone(),
            round: 0,
            early: Vec::new(),
        };
        let coordinator = end(&[COORDINATOR]);
        // Who listens to the caller listens to its workers.
        let listener = dispatcher::get_default(Clone::clone);
        let mut channel = Channel { end: coordinator, threads: Vec::new() };
        for host in 0..hosts {
            let pool = pool(threads, hosts, host, &listener)?;
            let ranks: Vec<Rank> =
                (1..=config.workers).filter(|r| (*r as usize - 1) % hosts == host).collect();
            let end = end(&ranks);
            let config = config.clone();
            let name = format!("septet-{host}");
            let listener = listener.clone();
            let thread = std::thread::Builder::new().name(name).spawn(move || {
                dispatcher::with_default(&listener, || host_thread(end, &ranks, &config, &pool));
            })?;
            channel.threads.push(thread);
        }
        Ok(channel)
    }
}

/// The threads of a host, which are shared by its workers: those that are left over go to the first hosts.
fn pool(threads: usize, hosts: usize, host: usize, listener: &Dispatch) -> std::io::Result<Pool> {
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

fn host_thread<P: Point>(mut end: End<P>, ranks: &[Rank], config: &Arc<WorkerConfig>, pool: &Pool) {
    let barrier = end.barrier.clone();
    let run =
        std::panic::AssertUnwindSafe(|| serve(&mut end, &mut Host::new(ranks.iter().copied(), config, pool)));
    match std::panic::catch_unwind(run) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => barrier.fail(error),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            let reason = text.unwrap_or("it panicked").to_string();
            barrier.fail(TransportError::WorkerFailed { rank: ranks.first().copied().unwrap_or(0), reason });
        }
    }
}

impl<P: Point> Transport<P> for Channel<P> {
    fn size(&self) -> u32 {
        self.end.size()
    }

    fn exchange(&mut self, outbox: Vec<Message<P>>, busy: bool) -> Result<Delivery<P>, TransportError> {
        let result = self.end.exchange(outbox, busy);
        if let Err(error) = &result {
            self.end.barrier.fail(error.clone());
        }
        result
    }
}

impl<P> Drop for Channel<P> {
    fn drop(&mut self) {
        self.end.barrier.fail(TransportError::Stopped);
        for thread in self.threads.drain(..) {
            // A panic in a worker has been reported by the barrier already.
            let _ = thread.join();
        }
    }
}
