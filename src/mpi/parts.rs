//! Parcels in parts, because a message of MPI has fewer than 2^31 bytes.
//!
//! The first message of a parcel is its end: the bytes after the last whole part, and the length of the parcel. Then the
//! whole parts follow from the beginning. So no byte is copied before it is sent, and a short parcel is one message.

use std::collections::BTreeMap;
use std::mem;

use septet_protocol::wire::{Parcel, WireError};

/// Bytes of the length of a parcel.
const LENGTH_BYTES: usize = 8;

/// A parcel that is sent in parts.
#[derive(Debug)]
pub struct Outgoing {
    /// The receiver.
    pub process: u32,
    /// The content, and its length.
    bytes: Vec<u8>,
    /// The bytes of all whole parts.
    whole: usize,
}

impl Outgoing {
    /// Prepares a parcel.
    pub fn new(Parcel { process, mut bytes }: Parcel, part_bytes: usize) -> Self {
        let len = bytes.len();
        bytes.extend_from_slice(&(len as u64).to_le_bytes());
        Outgoing { process, bytes, whole: len - len % part_bytes }
    }

    /// Returns the messages in their order.
    pub fn messages(&self, part_bytes: usize) -> impl Iterator<Item = &[u8]> {
        let (whole, end) = self.bytes.split_at(self.whole);
        std::iter::once(end).chain(whole.chunks(part_bytes))
    }
}

/// A parcel that arrives in parts.
#[derive(Debug, Default)]
struct Incoming {
    bytes: Vec<u8>,
    /// The bytes of the whole parts that have arrived.
    filled: usize,
    /// The bytes of all whole parts. They are unknown until the first message has arrived.
    whole: Option<usize>,
}

impl Incoming {
    /// Reads the length at the end of the first message, and makes room for the whole parts.
    fn open(&mut self, part_bytes: usize) -> Result<(), String> {
        let rest = self.bytes.len().checked_sub(LENGTH_BYTES).ok_or("its length is missing")?;
        let len = u64::from_le_bytes(self.bytes[rest..].try_into().expect("eight bytes"));
        let len = usize::try_from(len).map_err(|_| format!("a parcel of {len} bytes"))?;
        if len % part_bytes != rest {
            return Err(format!("a parcel of {len} bytes does not end with {rest} bytes"));
        }
        self.bytes.truncate(rest);
        let whole = len - rest;
        if whole > 0 {
            let end = mem::take(&mut self.bytes);
            let no_memory = |_| format!("no memory for a parcel of {len} bytes");
            self.bytes.try_reserve_exact(len).map_err(no_memory)?;
            self.bytes.resize(whole, 0);
            self.bytes.extend_from_slice(&end);
        }
        self.whole = Some(whole);
        Ok(())
    }
}

/// The parcels of a round, which arrive in parts.
#[derive(Debug)]
pub struct Inbox {
    part_bytes: usize,
    parcels: BTreeMap<u32, Incoming>,
    /// The first defect. The messages of the round are received nevertheless, because their senders wait for this.
    defect: Option<WireError>,
    /// The room for messages after a defect.
    refused: Vec<u8>,
}

impl Inbox {
    /// Starts a round.
    pub fn new(part_bytes: usize) -> Self {
        Inbox { part_bytes, parcels: BTreeMap::new(), defect: None, refused: Vec::new() }
    }

    /// Returns the room for the next message from a process. [`Inbox::arrived`] follows as soon as the room is filled.
    pub fn room(&mut self, process: u32, bytes: usize) -> &mut [u8] {
        let incoming = self.parcels.entry(process).or_default();
        if self.defect.is_none() {
            match incoming.whole {
                None => {
                    incoming.bytes = vec![0; bytes];
                    return &mut incoming.bytes;
                }
                Some(whole) if bytes == self.part_bytes && incoming.filled + bytes <= whole => {
                    let start = incoming.filled;
                    incoming.filled += bytes;
                    return &mut incoming.bytes[start..][..bytes];
                }
                Some(_) => {
                    let reason = format!("a part of {bytes} bytes is unexpected");
                    self.defect = Some(WireError::Corrupt { process, reason });
                }
            }
        }
        self.refused.resize(bytes, 0);
        &mut self.refused
    }

    /// Notes that the room for a message is filled.
    pub fn arrived(&mut self, process: u32) {
        let incoming = self.parcels.get_mut(&process).filter(|incoming| incoming.whole.is_none());
        if let Some(incoming) = incoming
            && self.defect.is_none()
            && let Err(reason) = incoming.open(self.part_bytes)
        {
            self.defect = Some(WireError::Corrupt { process, reason });
        }
    }

    /// Returns the parcels in the order of their senders.
    ///
    /// # Errors
    /// Fails if a part is missing or unexpected.
    pub fn finish(self) -> Result<Vec<Parcel>, WireError> {
        if let Some(defect) = self.defect {
            return Err(defect);
        }
        let close = |(process, incoming): (u32, Incoming)| {
            if incoming.whole == Some(incoming.filled) {
                return Ok(Parcel { process, bytes: incoming.bytes });
            }
            let reason = format!("only {} bytes of its whole parts arrived", incoming.filled);
            Err(WireError::Corrupt { process, reason })
        };
        self.parcels.into_iter().map(close).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receive(inbox: &mut Inbox, process: u32, message: &[u8]) {
        inbox.room(process, message.len()).copy_from_slice(message);
        inbox.arrived(process);
    }

    #[test]
    fn parcels_pass_in_parts() {
        for len in 0..40_u8 {
            for part_bytes in [1, 2, 7, 8, 13, 39, 40, 100] {
                let bytes: Vec<u8> = (0..len).collect();
                let mut inbox = Inbox::new(part_bytes);
                let outgoing = Outgoing::new(Parcel { process: 9, bytes: bytes.clone() }, part_bytes);
                let messages: Vec<_> = outgoing.messages(part_bytes).collect();
                assert_eq!(messages.len(), 1 + usize::from(len) / part_bytes);
                for message in messages {
                    assert!(message.len() < part_bytes + LENGTH_BYTES);
                    receive(&mut inbox, 4, message);
                }
                assert_eq!(inbox.finish(), Ok(vec![Parcel { process: 4, bytes }]));
            }
        }
    }

    #[test]
    fn defects_are_refused() {
        let of = |bytes: u8| Outgoing::new(Parcel { process: 0, bytes: vec![bytes; bytes.into()] }, 4);
        let other = of(9);
        let reason = |messages: &[&[u8]]| {
            let mut inbox = Inbox::new(4);
            for message in messages {
                receive(&mut inbox, 3, message);
            }
            inbox.finish().unwrap_err().to_string()
        };
        let messages: Vec<_> = other.messages(4).collect();
        assert!(reason(&messages[..2]).contains("only 4 bytes"));
        assert!(reason(&[&messages[..], &[&[1, 2, 3, 4]]].concat()).contains("unexpected"));
        assert!(reason(&[messages[0], &[1, 2]]).contains("a part of 2 bytes"));
        assert!(reason(&[&[0; 7]]).contains("its length is missing"));
        assert!(reason(&[&[1; 9]]).contains("no memory"));
        assert!(reason(&[&[7, 3, 0, 0, 0, 0, 0, 0, 0]]).contains("does not end with 1 bytes"));
    }
}
