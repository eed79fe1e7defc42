//! The host of ranks: the loop that every thread or process of the machine runs.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};

use crate::config::{Pool, WorkerConfig};
use crate::input::Source;
use crate::machine::context::Running;
use crate::partition::leader::Plan;
use crate::programs::run;
use crate::share::Share;

/// The task of a machine: its parameters, its input and the plan of the placement.
pub struct Job<'a, P> {
    /// The parameters.
    pub config: Arc<WorkerConfig>,
    /// The points, or at least the blocks of the ranks of this host.
    pub source: &'a dyn Source<P>,
    /// Number of leaves below each node, if every leaf has a rank of its own; otherwise empty.
    pub plan: &'a Plan,
}

/// An observer of a host.
pub trait Watch {
    /// Observes the end of a phase on all hosts.
    fn phase_ends(&mut self, _phase: Phase) {}

    /// Observes the first round of a phase, after the ranks have computed.
    fn phase_begins(&mut self, _phase: Phase) {}

    /// Observes each round, after the ranks have computed.
    fn round(&mut self, _round: u32, _phase: Phase) {}
}

/// An observer that does nothing.
pub struct Unwatched;

impl Watch for Unwatched {}

/// The ranks of a host.
pub struct Host<'a, P: Point> {
    ranks: Vec<Running<'a, P, Share<P>>>,
    round: u32,
}

impl<'a, P: Point> Host<'a, P> {
    /// Creates a host of these ranks, ascending with equal steps, without starting them.
    pub fn new(ranks: impl Iterator<Item = Rank>, job: &Job<'a, P>, pool: &Pool) -> Self {
        let (source, plan) = (job.source, job.plan);
        let start =
            |rank| Running::start(rank, job.config.clone(), pool.clone(), move |cx| run(cx, source, plan));
        Host { ranks: ranks.map(start).collect(), round: 0 }
    }

    /// Returns `true` if all ranks are done.
    pub fn is_done(&self) -> bool {
        self.ranks.iter().all(Running::is_done)
    }

    /// Returns `true` if a rank has more to do although it may have sent nothing.
    pub fn busy(&self) -> bool {
        self.ranks.iter().any(Running::busy)
    }

    /// Returns the current phase.
    pub fn phase(&self) -> Phase {
        self.ranks.first().map_or(Phase::Done, Running::phase)
    }

    /// Returns the number of rounds that have ended.
    pub fn round(&self) -> u32 {
        self.round
    }

    /// Returns the shares of the ranks that are done, in the order of the ranks.
    pub fn into_shares(self) -> Vec<Share<P>> {
        self.ranks.into_iter().filter_map(Running::into_result).collect()
    }

    /// Runs all ranks until their first exchange.
    ///
    /// # Errors
    /// Returns the error of the first rank that fails.
    pub fn begin(&mut self) -> Result<Vec<Message<P>>, TransportError> {
        self.step()
    }

    /// Delivers the messages of a round to the ranks and runs each until its next exchange. Returns the messages that
    /// they send.
    ///
    /// # Errors
    /// Returns the error of the first rank that fails, or an error if a message is for a rank of another host.
    pub fn turn(&mut self, delivery: Delivery<P>) -> Result<Vec<Message<P>>, TransportError> {
        self.round += 1;
        let first = self.ranks.first().map_or(0, Running::rank);
        let stride = self.ranks.get(1).map_or(1, |r| r.rank() - first).max(1);
        let mut boxes: Vec<Vec<Message<P>>> = self.ranks.iter().map(|_| Vec::new()).collect();
        for message in delivery.inbox {
            let place = message.to.checked_sub(first).map(|d| d / stride).map(|i| i as usize);
            let place = place.filter(|&i| self.ranks.get(i).is_some_and(|r| r.rank() == message.to));
            if let Some(i) = place {
                boxes[i].push(message);
            } else {
                let reason = format!("rank {} is not on this host", message.to);
                return Err(TransportError::BadMessage { from: message.from, reason });
            }
        }
        for (rank, inbox) in self.ranks.iter_mut().zip(boxes) {
            rank.deliver(self.round, delivery.active.then_some(inbox));
        }
        self.step()
    }

    fn step(&mut self) -> Result<Vec<Message<P>>, TransportError> {
        let mut outbox = Vec::new();
        for rank in &mut self.ranks {
            outbox.extend(rank.step()?);
        }
        Ok(outbox)
    }
}

/// Runs the ranks of a host until they are done, with one exchange per round. An error of a rank also ends the round:
/// the host passes it to the transport as its state.
///
/// # Errors
/// The first error of the machine.
pub fn serve<P: Point>(
    transport: &mut dyn Transport<P>,
    host: &mut Host<'_, P>,
    watch: &mut dyn Watch,
) -> Result<(), TransportError> {
    watch.phase_begins(host.phase());
    let mut sent = host.begin();
    while sent.is_err() || !host.is_done() {
        let (outbox, state) = HostState::after(sent, host.busy());
        let delivery = transport.exchange(outbox, state)?;
        let ended = !delivery.active;
        if ended {
            watch.phase_ends(host.phase());
        }
        sent = host.turn(delivery);
        if ended {
            watch.phase_begins(host.phase());
        }
        watch.round(host.round(), host.phase());
    }
    Ok(())
}
