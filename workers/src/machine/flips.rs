//! Plants flipped bits in messages ([`Fault::Flip`]).
//!
//! A flip acts on the encoded body, between the bill of the message and its transport. It is therefore the same on all
//! transports, and no hash of a frame detects it.

use std::fmt::Display;

use septet_geometry::point::Point;
use septet_protocol::codec::encoded_len;
use septet_protocol::message::Message;
use septet_protocol::transport::TransportError;

use crate::config::{Fault, WorkerConfig};

/// The number of messages of the planted kind that a rank has sent.
#[derive(Debug, Default)]
pub(super) struct Flips(u32);

impl Flips {
    /// Flips a bit of a message that the fault of the run strikes.
    ///
    /// # Errors
    /// Fails if the message then does not decode.
    pub(super) fn strike<P: Point>(
        &mut self,
        config: &WorkerConfig,
        sent: &mut [Message<P>],
    ) -> Result<(), TransportError> {
        let Some(Fault::Flip(flip)) = config.fault else { return Ok(()) };
        for message in sent.iter_mut().filter(|message| message.body.kind() == flip.kind()) {
            let earlier = self.0;
            self.0 += 1;
            if (message.from, earlier) != flip.target(config.ranks()) {
                continue;
            }
            let from = message.from;
            let failed = |error: &dyn Display| TransportError::BadMessage { from, reason: error.to_string() };
            let mut bytes = message.encode().map_err(|error| failed(&error))?;
            let body = encoded_len(&message.body);
            let bit = flip.bit(8 * body as u64);
            let first = bytes.len() - body;
            bytes[first + (bit / 8) as usize] ^= 1 << (bit % 8);
            *message = Message::decode(&bytes).map_err(|error| failed(&error))?;
        }
        Ok(())
    }
}
