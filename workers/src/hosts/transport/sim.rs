//! The simulator: all ranks run on the thread of the caller. Every message is encoded and decoded. The order of delivery
//! is drawn from a seed.

use std::marker::PhantomData;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use septet_geometry::point::Point;
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};

/// The transport of a simulated machine of one host.
pub(crate) struct Sim<P> {
    order: ChaCha8Rng,
    points: PhantomData<fn(P)>,
}

impl<P> Sim<P> {
    /// Creates a transport with this seed of the order.
    pub(crate) fn new(delivery_seed: u64) -> Self {
        Sim { order: ChaCha8Rng::seed_from_u64(delivery_seed), points: PhantomData }
    }
}

fn bad(from: u32, error: &dyn std::fmt::Display) -> TransportError {
    TransportError::BadMessage { from, reason: error.to_string() }
}

impl<P: Point> Transport<P> for Sim<P> {
    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let active = state.is_busy()? || !outbox.is_empty();
        let mut frames = Vec::with_capacity(outbox.len());
        for message in outbox {
            let bytes = message.encode().map_err(|e| bad(message.from, &e))?;
            debug_assert_eq!(bytes.len(), message.encoded_len());
            frames.push(bytes);
        }
        frames.shuffle(&mut self.order);
        let decoded = frames.iter().map(|frame| Message::decode(frame).map_err(|e| bad(0, &e)));
        Ok(Delivery { inbox: decoded.collect::<Result<_, _>>()?, active })
    }
}
