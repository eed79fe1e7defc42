//! The messages of the baseline, if its points have owners.
//!
//! **Statement.** Every point has an owner. A cell is held by the owner of the point that created it, with its conflicts
//! and all their coordinates; the first cells are held by the owner of the first point. The owner of the first inserted
//! vertex of a facet keeps the facet. A round has at most three *exchanges*:
//! 1. The keeper of each ready facet tells the holders of both cells the outcome: the cell, the pivot, and the receiver.
//! 2. Both cells of a facet that is replaced go to the holder of the new cell, once per cell and receiver.
//! 3. Each new cell reports its facets, its number and its pivot to their keepers.
//!
//! Before the first round, all points go to the holder of the first cells. An exchange sends one message from an owner to
//! another if it sends any record between them. A message within an owner is free.
//!
//! **Departures.** Four bytes for a number, eight for a coordinate, and no headers. This favours the baseline over septet,
//! whose messages are counted as encoded.

use std::collections::{BTreeMap, BTreeSet};

/// Bytes of a number.
const NUMBER: u64 = 4;
/// Bytes of a coordinate.
const COORDINATE: u64 = 8;

/// The messages of a computation whose points have owners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Number of exchanges with messages.
    pub rounds: u64,
    /// Number of messages: pairs of a sender and a receiver in an exchange.
    pub messages: u64,
    /// Bytes of all records.
    pub bytes: u64,
}

/// The exchanges of a round.
#[derive(Clone, Copy)]
enum Exchange {
    Outcomes,
    Cells,
    Facets,
}

/// The owners, and the messages of the current round.
#[derive(Debug, Default)]
pub(super) struct Network {
    /// The owner of each point, in the order of insertion. Without owners, no message is sent.
    owners: Vec<u32>,
    dimension: u64,
    /// Bytes by sender and receiver, for each exchange.
    sent: [BTreeMap<(u32, u32), u64>; 3],
    /// Cells that were sent in this round, with their receivers.
    copied: BTreeSet<(u32, u32)>,
    traffic: Traffic,
}

impl Network {
    pub(super) fn new(owners: Vec<u32>, dimension: usize) -> Self {
        Network { owners, dimension: dimension as u64, ..Network::default() }
    }

    /// Returns the owner of a point, given by its position in the order of insertion.
    pub(super) fn owner(&self, point: u32) -> u32 {
        self.owners.get(point as usize).copied().unwrap_or(0)
    }

    fn send(&mut self, exchange: Exchange, (from, to): (u32, u32), bytes: u64) {
        if from != to {
            *self.sent[exchange as usize].entry((from, to)).or_default() += bytes;
        }
    }

    /// Sends all points to the holder of the first cells.
    pub(super) fn send_points(&mut self) {
        let to = self.owner(0);
        for at in 0..self.owners.len() {
            self.send(Exchange::Cells, (self.owners[at], to), NUMBER + COORDINATE * self.dimension);
        }
    }

    /// Tells the holder of a cell the outcome of a facet with these vertices.
    pub(super) fn tell(&mut self, facet: &[u32], holder: u32) {
        self.send(Exchange::Outcomes, (self.keeper(facet), holder), 3 * NUMBER);
    }

    /// Sends a cell with its conflicts to the holder of a new cell.
    pub(super) fn copy(&mut self, (cell, holder): (u32, u32), conflicts: usize, to: u32) {
        if self.copied.insert((cell, to)) {
            let points = self.dimension + 1 + conflicts as u64;
            self.send(
                Exchange::Cells,
                (holder, to),
                NUMBER + points * (NUMBER + COORDINATE * self.dimension),
            );
        }
    }

    /// Reports a facet of a new cell to its keeper.
    pub(super) fn report(&mut self, facet: &[u32], holder: u32) {
        let bytes = (self.dimension + 2) * NUMBER;
        self.send(Exchange::Facets, (holder, self.keeper(facet)), bytes);
    }

    /// Returns the keeper of a facet with sorted vertices.
    fn keeper(&self, facet: &[u32]) -> u32 {
        facet.first().map_or(0, |&v| self.owner(v))
    }

    /// Ends the round.
    pub(super) fn end_round(&mut self) {
        for sent in &mut self.sent {
            self.traffic.rounds += u64::from(!sent.is_empty());
            self.traffic.messages += sent.len() as u64;
            self.traffic.bytes += sent.values().sum::<u64>();
            sent.clear();
        }
        self.copied.clear();
    }

    pub(super) fn traffic(&self) -> Traffic {
        self.traffic
    }
}
