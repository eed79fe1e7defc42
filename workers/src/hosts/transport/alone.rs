//! One host for all ranks, on the thread of the caller. Messages move without being encoded, and no round waits.
//!
//! The ranks exchange the same messages in the same rounds as on threads ([`super::channel`]), so their counts are equal.

use septet_geometry::point::Point;
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};

/// The transport of a machine of one host.
pub(crate) struct Alone;

impl<P: Point> Transport<P> for Alone {
    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let active = state.is_busy()? || !outbox.is_empty();
        Ok(Delivery { inbox: outbox, active })
    }
}
