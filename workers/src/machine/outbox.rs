//! What a rank sends in a round: envelopes, and the meter that bills them.

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase, Rank};
use septet_protocol::ledger::{LedgerPart, Traffic};
use septet_protocol::message::{Body, Message, PROTOCOL_VERSION};

use crate::machine::profile::{Site, sent};

/// Messages of one rank in one round. Those to itself are kept for its next step and never billed.
#[derive(Debug)]
pub struct Outbox<P> {
    run: u64,
    rank: Rank,
    round: u32,
    sequence: u32,
    messages: Vec<Message<P>>,
    own: Vec<Message<P>>,
}

impl<P: Point> Outbox<P> {
    /// An empty one.
    pub fn new(run: u64, rank: Rank) -> Self {
        Outbox { run, rank, round: 0, sequence: 0, messages: Vec::new(), own: Vec::new() }
    }

    /// The round that messages are stamped with from now on.
    pub fn set_round(&mut self, round: u32) {
        self.round = round;
    }

    /// Whose round it is.
    pub fn site(&self) -> Site {
        Site { run: self.run, rank: self.rank, round: self.round }
    }

    /// That round.
    pub fn round(&self) -> u32 {
        self.round
    }

    /// Sends a message about a subproblem.
    pub fn send(&mut self, to: Rank, node: NodeId, attempt: u32, body: Body<P>) {
        let message = Message {
            version: PROTOCOL_VERSION,
            run: self.run,
            from: self.rank,
            to,
            node,
            attempt,
            round: self.round,
            sequence: self.sequence,
            body,
        };
        self.sequence += 1;
        if to == self.rank {
            self.own.push(message);
        } else {
            self.messages.push(message);
        }
    }

    /// Are there messages to itself?
    pub fn has_own(&self) -> bool {
        !self.own.is_empty()
    }

    /// Takes the messages to itself.
    pub fn take_own(&mut self) -> Vec<Message<P>> {
        std::mem::take(&mut self.own)
    }

    /// Takes what leaves, billing it to the ledger and telling of it.
    pub fn take(&mut self, phase: Phase, ledger: &mut LedgerPart) -> Vec<Message<P>> {
        if self.messages.is_empty() {
            return Vec::new();
        }
        sent(phase, &self.messages);
        ledger.tally(self.round, phase);
        for message in &self.messages {
            if message.body.is_instrument() {
                continue;
            }
            let bytes = message.encoded_len() as u64;
            let moved = Traffic { messages: 1, bytes, points: points_in(&message.body) as u64 };
            let tally = ledger.bill(self.round, phase, self.rank, message.to, moved);
            if message.to == COORDINATOR && !message.body.is_bulk() {
                tally.control += bytes;
            }
        }
        std::mem::take(&mut self.messages)
    }
}

/// Number of points a message ships.
fn points_in<P: Point>(body: &Body<P>) -> usize {
    match body {
        Body::Block(b) | Body::Move(b) | Body::Ghosts(b) | Body::Gather(b) => b.len(),
        Body::Items { points, .. }
        | Body::Seam { points, .. }
        | Body::Reverse { points, .. }
        | Body::Propose { points, .. }
        | Body::Object { points, .. }
        | Body::Region { points, .. } => points.len(),
        Body::Reply(answer) => answer.points.len(),
        Body::Lists(list) => list.points.len(),
        Body::Query(q) => q.slots.len(),
        _ => 0,
    }
}
