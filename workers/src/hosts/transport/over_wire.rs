//! Messages over a wire between processes.
//!
//! In a round, each process sends at most one parcel to each other process: its frames, as in `frames`. Messages
//! between the ranks of a process are not encoded. If a process has an error, it exchanges the state `FAILED`. All
//! processes then exchange their errors, and end with the first one.

use std::collections::BTreeMap;

use septet_geometry::point::Point;
use septet_protocol::codec;
use septet_protocol::message::Message;
use septet_protocol::transport::{
    Delivery, HostState, Placement, ProcessTransport, Transport, TransportError,
};
use septet_protocol::wire::{Arrived, Parcel, Processes, WireError};

use crate::hosts::transport::frames::{Frame, read_round, write_round};

const IDLE: u8 = 0;
const BUSY: u8 = 1;
const FAILED: u8 = 2;

/// A transport over a wire. The first processes run the ranks, as many as the placement has.
pub struct OverWire<'a, 'w> {
    processes: &'a mut Processes<'w>,
    placement: Placement,
}

impl<'a, 'w> OverWire<'a, 'w> {
    /// Creates the transport of this process.
    pub fn new(processes: &'a mut Processes<'w>, placement: Placement) -> Self {
        OverWire { processes, placement }
    }

    fn members(&self) -> u32 {
        self.placement.processes()
    }

    /// Returns the error for a lost process. All other processes find the loss by themselves.
    fn lost(&self, error: &WireError) -> TransportError {
        let (WireError::Lost { process, .. } | WireError::Corrupt { process, .. }) = error;
        let rank = self.placement.workers_of(*process).start;
        TransportError::WorkerFailed { rank, reason: error.to_string() }
    }

    fn try_exchange(&mut self, sent: Vec<Parcel>, state: u8) -> Result<Arrived, TransportError> {
        let members = self.members();
        self.processes.exchange(members, sent, state).map_err(|error| self.lost(&error))
    }

    /// Ends the run on all processes after an exchange with the state [`FAILED`]. Returns the first error.
    fn end(&mut self, own: Option<&TransportError>) -> TransportError {
        let mut bytes = Vec::new();
        if let Some(encoded) = own.and_then(|error| codec::encode(error).ok()) {
            bytes = encoded;
        }
        let parcels = (0..self.members()).filter(|_| !bytes.is_empty());
        let parcels = parcels.map(|process| Parcel { process, bytes: bytes.clone() }).collect();
        match self.try_exchange(parcels, FAILED) {
            Err(error) => error,
            Ok(Arrived { parcels, .. }) => match parcels.first() {
                Some(Parcel { bytes, .. }) if let Ok(error) = codec::decode(bytes) => error,
                _ => own.cloned().unwrap_or(TransportError::Stopped),
            },
        }
    }

    /// Tells the other processes of an error of this process.
    fn fail(&mut self, error: &TransportError) -> TransportError {
        match self.try_exchange(Vec::new(), FAILED) {
            Ok(_) => self.end(Some(error)),
            Err(error) => error,
        }
    }

    /// Divides the messages of a round among the processes. Returns those to this process, and a parcel for each other one.
    fn pack<P: Point>(&self, outbox: Vec<Message<P>>) -> Result<Packed<P>, TransportError> {
        let mut own = Vec::new();
        let mut frames: BTreeMap<u32, Vec<Frame>> = BTreeMap::new();
        for message in outbox {
            let bad = |reason: String| TransportError::BadMessage { from: message.from, reason };
            if message.to > self.placement.workers() {
                return Err(bad(format!("there is no rank {}", message.to)));
            }
            let process = self.placement.process_of(message.to);
            if process == self.processes.process() {
                own.push(message);
            } else {
                let bytes = message.encode().map_err(|e| bad(e.to_string()))?;
                frames.entry(process).or_default().push((message.to, bytes));
            }
        }
        let mut parcels = Vec::with_capacity(frames.len());
        for (process, frames) in frames {
            let mut bytes = Vec::with_capacity(frames.iter().map(|(_, frame)| frame.len() + 64).sum());
            write_round(&mut bytes, BUSY, &frames)
                .map_err(|e| TransportError::BadMessage { from: 0, reason: e.to_string() })?;
            parcels.push(Parcel { process, bytes });
        }
        Ok(Packed { own, parcels })
    }
}

/// The messages of a round by their receivers.
struct Packed<P> {
    /// The messages between the ranks of this process.
    own: Vec<Message<P>>,
    parcels: Vec<Parcel>,
}

/// Adds the messages of a parcel to the inbox.
fn unpack<P: Point>(parcel: &Parcel, inbox: &mut Vec<Message<P>>) -> Result<(), TransportError> {
    let bad = |reason: String| {
        let reason = format!("a parcel of process {} does not decode: {reason}", parcel.process);
        TransportError::BadMessage { from: 0, reason }
    };
    let (_, frames) = read_round(&mut parcel.bytes.as_slice()).map_err(|e| bad(e.to_string()))?;
    for (_, bytes) in frames {
        inbox.push(Message::decode(&bytes).map_err(|e| bad(e.to_string()))?);
    }
    Ok(())
}

impl<P: Point> Transport<P> for OverWire<'_, '_> {
    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let begun = state.is_busy().and_then(|busy| {
            let busy = busy || !outbox.is_empty();
            Ok((self.pack(outbox)?, if busy { BUSY } else { IDLE }))
        });
        let (Packed { own: mut inbox, parcels }, state) = match begun {
            Ok(begun) => begun,
            Err(error) => return Err(self.fail(&error)),
        };
        let arrived = self.try_exchange(parcels, state)?;
        if arrived.state == FAILED {
            return Err(self.end(None));
        }
        for parcel in &arrived.parcels {
            // The other processes learn of this error in their next exchange.
            unpack(parcel, &mut inbox).map_err(|error| self.fail(&error))?;
        }
        Ok(Delivery { inbox, active: arrived.state == BUSY })
    }
}

impl<P: Point> ProcessTransport<P> for OverWire<'_, '_> {
    fn process(&self) -> u32 {
        self.processes.process()
    }

    fn processes(&self) -> u32 {
        self.members()
    }

    fn begin(&mut self, placement: Placement) {
        self.placement = placement;
    }
}
