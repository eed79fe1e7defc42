//! The number of messages and bytes of a machine, by round.

use std::collections::BTreeMap;

use septet_protocol::ids::{Phase, Rank};

/// The messages of a rank in a round, sent or received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
}

impl Load {
    fn add(&mut self, bytes: u64) {
        self.messages += 1;
        self.bytes += bytes;
    }

    fn most(self, other: Load) -> Load {
        Load { messages: self.messages.max(other.messages), bytes: self.bytes.max(other.bytes) }
    }
}

/// One round of a phase.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RoundTraffic {
    /// All messages of the round.
    pub all: Load,
    sent: BTreeMap<Rank, Load>,
    received: BTreeMap<Rank, Load>,
}

impl RoundTraffic {
    /// Returns the largest load that a single rank sends or receives: the `h` of an h-relation.
    pub fn most(&self) -> Load {
        self.sent.values().chain(self.received.values()).fold(Load::default(), |m, &l| m.most(l))
    }
}

/// Messages by phase, and by round within the phase.
#[derive(Clone, Debug, Default)]
pub struct PhaseTraffic {
    rounds: BTreeMap<(Phase, u32), RoundTraffic>,
}

impl PhaseTraffic {
    /// Adds a message. Messages from a rank to itself are not billed.
    pub(super) fn send(&mut self, phase: Phase, round: u32, (from, to): (Rank, Rank), bytes: u64) {
        if from == to {
            return;
        }
        let row = self.rounds.entry((phase, round)).or_default();
        row.all.add(bytes);
        row.sent.entry(from).or_default().add(bytes);
        row.received.entry(to).or_default().add(bytes);
    }

    /// Returns the rounds in which messages are sent, in order.
    pub fn rounds(&self) -> impl Iterator<Item = (Phase, &RoundTraffic)> {
        self.rounds.iter().map(|((phase, _), row)| (*phase, row))
    }

    /// Returns rounds, messages and bytes of each phase that sends messages.
    pub fn phases(&self) -> BTreeMap<Phase, (u64, Load)> {
        let mut phases: BTreeMap<Phase, (u64, Load)> = BTreeMap::new();
        for ((phase, _), row) in &self.rounds {
            let entry = phases.entry(*phase).or_default();
            entry.0 += 1;
            entry.1.messages += row.all.messages;
            entry.1.bytes += row.all.bytes;
        }
        phases
    }

    /// Returns the total of rounds, messages and bytes.
    pub fn total(&self) -> (u64, Load) {
        self.phases().values().fold((0, Load::default()), |mut sum, (rounds, load)| {
            sum.0 += rounds;
            sum.1.messages += load.messages;
            sum.1.bytes += load.bytes;
            sum
        })
    }
}
