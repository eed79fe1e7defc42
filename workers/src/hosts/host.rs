//! A host runs ranks: the loop that every thread or process of workers runs.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, Transport, TransportError};

use crate::config::{Pool, WorkerConfig};
use crate::machine::context::Running;
use crate::programs::work;

/// The ranks of a host.
pub struct Host<P: Point> {
    ranks: Vec<Running<'static, P>>,
    round: u32,
}

impl<P: Point> Host<P> {
    /// Workers of these ranks, which have not begun.
    pub fn new(ranks: impl Iterator<Item = Rank>, config: &Arc<WorkerConfig>, pool: &Pool) -> Self {
        let start = |rank| Running::start(rank, config.clone(), pool.clone(), work);
        Host { ranks: ranks.map(start).collect(), round: 0 }
    }

    /// Are all of them done?
    pub fn is_done(&self) -> bool {
        self.ranks.iter().all(Running::is_done)
    }

    /// Has one of them more to do although it sends nothing?
    pub fn busy(&self) -> bool {
        self.ranks.iter().any(Running::busy)
    }

    /// The phase they are in.
    pub fn phase(&self) -> Phase {
        self.ranks.first().map_or(Phase::Done, Running::phase)
    }

    /// Runs all of them until their first exchange.
    ///
    /// # Errors
    /// What a rank reports.
    pub fn begin(&mut self) -> Result<Vec<Message<P>>, TransportError> {
        self.step()
    }

    /// Hands each its messages of a round and runs it until its next exchange. Returns what they send.
    ///
    /// # Errors
    /// What a rank reports.
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
                let reason = format!("it is for rank {}, which is not here", message.to);
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

/// Runs workers until they are done: one exchange a round.
///
/// # Errors
/// What the transport or a worker reports.
pub fn serve<P: Point>(transport: &mut dyn Transport<P>, host: &mut Host<P>) -> Result<(), TransportError> {
    let mut outbox = host.begin()?;
    while !host.is_done() {
        let delivery = transport.exchange(std::mem::take(&mut outbox), host.busy())?;
        outbox = host.turn(delivery)?;
    }
    Ok(())
}
