//! The simulator: all workers run on the caller's thread. Every message is encoded and decoded. The order of delivery is
//! drawn from a seed.

use std::sync::Arc;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use septet_geometry::point::Point;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};

use crate::config::WorkerConfig;
use crate::hosts::host::Host;

/// The coordinator's end of a simulated machine, which contains the workers.
pub(crate) struct Sim<P: Point> {
    host: Host<P>,
    size: u32,
    begun: bool,
    /// The messages of the last round, as bytes.
    wire: Vec<Vec<u8>>,
    order: ChaCha8Rng,
}

impl<P: Point> Sim<P> {
    pub(crate) fn new(config: &Arc<WorkerConfig>, delivery_seed: u64) -> Self {
        Sim {
            host: Host::new(1..=config.workers, config, &None),
            size: config.workers + 1,
            begun: false,
            wire: Vec::new(),
            order: ChaCha8Rng::seed_from_u64(delivery_seed),
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
        self.size
    }

    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let busy = state.is_busy()?;
        if !std::mem::replace(&mut self.begun, true) {
            let sent = self.host.begin()?;
            self.send(sent)?;
        }
        let busy = busy || self.host.busy();
        self.send(outbox)?;
        let mut frames = std::mem::take(&mut self.wire);
        frames.shuffle(&mut self.order);
        let active = busy || !frames.is_empty();
        let (mut inbox, mut inner) = (Vec::new(), Vec::new());
        for frame in frames {
            let message = Message::decode(&frame).map_err(|e| bad(0, &e))?;
            if message.to == COORDINATOR { inbox.push(message) } else { inner.push(message) }
        }
        if !self.host.is_done() {
            let sent = self.host.turn(Delivery { inbox: inner, active })?;
            self.send(sent)?;
        }
        Ok(Delivery { inbox, active })
    }
}
