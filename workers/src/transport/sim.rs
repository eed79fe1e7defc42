//! The simulator: all workers on the caller's thread, every message encoded and decoded, delivered in an
//! order drawn from a seed.

use std::sync::Arc;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, Transport, TransportError};

use crate::config::WorkerConfig;
use crate::host::step_all;
use crate::worker::Worker;

/// The coordinator's end of a simulated machine; the workers live inside.
pub(crate) struct Sim<P: Point> {
    workers: Vec<Worker<P>>,
    /// What the workers sent in the last round, as bytes.
    wire: Vec<Vec<u8>>,
    order: ChaCha8Rng,
    round: u32,
    phase: Phase,
}

impl<P: Point> Sim<P> {
    pub(crate) fn new(config: &Arc<WorkerConfig>, delivery_seed: u64) -> Self {
        let workers = (1..=config.workers).map(|rank| Worker::new(rank, config.clone(), None));
        Sim {
            workers: workers.collect(),
            wire: Vec::new(),
            order: ChaCha8Rng::seed_from_u64(delivery_seed),
            round: 0,
            phase: Phase::Load,
        }
    }

    fn send(&mut self, messages: Vec<Message<P>>) -> Result<(), TransportError> {
        for message in messages {
            let bytes = message.encode().map_err(|e| bad(message.from, &e))?;
            debug_assert_eq!(bytes.len(), message.encoded_len());
            self.wire.push(bytes);
        }
        Ok(())
    }
}

fn bad(from: u32, error: &dyn std::fmt::Display) -> TransportError {
    TransportError::BadMessage { from, reason: error.to_string() }
}

impl<P: Point> Transport<P> for Sim<P> {
    fn size(&self) -> u32 {
        self.workers.len() as u32 + 1
    }

    fn exchange(&mut self, outbox: Vec<Message<P>>, busy: bool) -> Result<Delivery<P>, TransportError> {
        let busy = busy || self.workers.iter().any(Worker::busy);
        self.send(outbox)?;
        let mut frames = std::mem::take(&mut self.wire);
        frames.shuffle(&mut self.order);
        let active = busy || !frames.is_empty();
        let (mut inbox, mut inner) = (Vec::new(), Vec::new());
        for frame in frames {
            let message = Message::decode(&frame).map_err(|e| bad(0, &e))?;
            if message.to == COORDINATOR { inbox.push(message) } else { inner.push(message) }
        }
        self.round += 1;
        if active {
            let sent = step_all(&mut self.workers, self.round, inner)?;
            self.send(sent)?;
        } else if self.phase != Phase::Done {
            self.phase = self.workers.first().map_or(Phase::Done, Worker::next_phase);
            for i in 0..self.workers.len() {
                let sent = self.workers[i].begin(self.phase, self.round)?;
                self.send(sent)?;
            }
        }
        Ok(Delivery { inbox, active })
    }
}
