//! Messages and bytes of a machine, collected round by round.

use std::collections::BTreeMap;

use septet_protocol::ids::{Phase, Rank};

/// What one rank sends or receives in a round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Messages.
    pub messages: u64,
    /// Bytes.
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
pub struct Round {
    /// All that is sent.
    pub all: Load,
    sent: BTreeMap<Rank, Load>,
    received: BTreeMap<Rank, Load>,
}

impl Round {
    /// The most that one rank sends or receives: the `h` of an h-relation.
    pub fn most(&self) -> Load {
        self.sent.values().chain(self.received.values()).fold(Load::default(), |m, &l| m.most(l))
    }
}

/// Messages by phase and round of the phase.
#[derive(Clone, Debug, Default)]
pub struct Traffic {
    rounds: BTreeMap<(u8, u32), Round>,
}

impl Traffic {
    /// Sends a message; what a rank tells itself is not billed.
    pub(super) fn send(&mut self, phase: Phase, round: u32, (from, to): (Rank, Rank), bytes: u64) {
        if from == to {
            return;
        }
        let row = self.rounds.entry((phase as u8, round)).or_default();
        row.all.add(bytes);
        row.sent.entry(from).or_default().add(bytes);
        row.received.entry(to).or_default().add(bytes);
    }

    /// Rounds in which something is sent, in order.
    pub fn rounds(&self) -> impl Iterator<Item = (Phase, &Round)> {
        self.rounds.iter().filter_map(|((p, _), row)| Some((Phase::from_number(*p)?, row)))
    }

    /// Rounds, messages and bytes of each phase that sends.
    pub fn phases(&self) -> BTreeMap<u8, (u64, Load)> {
        let mut phases: BTreeMap<u8, (u64, Load)> = BTreeMap::new();
        for ((phase, _), row) in &self.rounds {
            let entry = phases.entry(*phase).or_default();
            entry.0 += 1;
            entry.1.messages += row.all.messages;
            entry.1.bytes += row.all.bytes;
        }
        phases
    }

    /// Rounds, messages and bytes in all.
    pub fn total(&self) -> (u64, Load) {
        self.phases().values().fold((0, Load::default()), |mut sum, (rounds, load)| {
            sum.0 += rounds;
            sum.1.messages += load.messages;
            sum.1.bytes += load.bytes;
            sum
        })
    }
}
