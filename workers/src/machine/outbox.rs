//! The messages that a rank sends in a round, and the meter that bills them.

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::{LedgerPart, RankKey, RoundKey, Traffic};
use septet_protocol::message::{Body, Message, PROTOCOL_VERSION};

use crate::machine::profile::{Site, sent};

/// The messages of one rank in one round. Messages to the rank itself wait for its next step and are never billed.
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
    /// Creates an empty outbox.
    pub fn new(run: u64, rank: Rank) -> Self {
        Outbox { run, rank, round: 0, sequence: 0, messages: Vec::new(), own: Vec::new() }
    }

    /// Sets the round of the messages that follow.
    pub fn set_round(&mut self, round: u32) {
        self.round = round;
    }

    /// Returns the rank and the round.
    pub fn site(&self) -> Site {
        Site { run: self.run, rank: self.rank, round: self.round }
    }

    /// Returns the round of new messages.
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

    /// Returns `true` if the rank has sent messages to itself.
    pub fn has_own(&self) -> bool {
        !self.own.is_empty()
    }

    /// Takes the messages of the rank to itself.
    pub fn take_own(&mut self) -> Vec<Message<P>> {
        std::mem::take(&mut self.own)
    }

    /// Takes the messages to other ranks, bills them to the ledger, adds their hashes to its balance and traces them.
    pub fn take(&mut self, phase: Phase, ledger: &mut LedgerPart) -> Vec<Message<P>> {
        if self.messages.is_empty() {
            return Vec::new();
        }
        sent(phase, &self.messages);
        let (round, rank) = (self.round, self.rank);
        ledger.tally(RoundKey { round, phase });
        for message in &self.messages {
            ledger.balance = ledger.balance.wrapping_add(message.content_hash());
            let bytes = message.encoded_len() as u64;
            let moved = Traffic { messages: 1, bytes, points: points_in(&message.body) as u64 };
            ledger.bill(RankKey { round, phase, rank }, message.to, moved);
        }
        std::mem::take(&mut self.messages)
    }
}

/// Returns the number of points in a message.
fn points_in<P: Point>(body: &Body<P>) -> usize {
    match body {
        Body::Move(b) | Body::Copies(b) | Body::Ghosts(b) | Body::Gather(b) => b.len(),
        Body::Items { points, .. }
        | Body::Reverse { points, .. }
        | Body::Propose { points, .. }
        | Body::Object { points, .. }
        | Body::Region { points, .. } => points.len(),
        Body::Reply(reply) => reply.points.len(),
        Body::Lists(list) => list.points.len(),
        Body::Query(q) => q.slots.len(),
        _ => 0,
    }
}
