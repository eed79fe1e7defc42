//! The host of ranks: the loop that every thread or process of workers runs.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};

use crate::config::{Pool, WorkerConfig};
use crate::machine::context::Running;
use crate::programs::work;

/// The ranks of a host.
pub struct Host<P: Point> {
    ranks: Vec<Running<'static, P>>,
    round: u32,
}

impl<P: Point> Host<P> {
    /// Creates a host of the workers with these ranks, without starting them.
    pub fn new(ranks: impl Iterator<Item = Rank>, config: &Arc<WorkerConfig>, pool: &Pool) -> Self {
        let start = |rank| Running::start(rank, config.clone(), pool.clone(), work);
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
pub fn serve<P: Point>(transport: &mut dyn Transport<P>, host: &mut Host<P>) -> Result<(), TransportError> {
    let mut sent = host.begin();
    while sent.is_err() || !host.is_done() {
        let (outbox, state) = HostState::after(sent, host.busy());
        let delivery = transport.exchange(outbox, state)?;
        sent = host.turn(delivery);
    }
    Ok(())
}
