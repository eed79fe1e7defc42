//! The conflict lists of a link, and the counts of their rounds.
//!
//! **Statement.** See [`super::random_order`]. A facet is removed at the turn of its pivot and not before. So the facets
//! whose pivot is a candidate form a linked list, all of whose entries exist when its turn comes.
//!
//! **Work and depth.** O(1) for each facet and entry. The sweeps of a round follow one another: the planes of
//! the new facets, the test of the entries of both old facets against the new one and against the other old one, the moves of
//! the conflicts with a scan that finds the pivots, and the ridges.

use crate::complex::NONE;
use crate::cost::{Cost, Sweep};

/// The conflict lists of a link, in reused storage.
#[derive(Debug, Default)]
pub(super) struct ConflictLists {
    /// For each facet, its list, in the order of insertion.
    pub(super) lists: Vec<Vec<u32>>,
    /// For each facet, its round.
    pub(super) rounds: Vec<u32>,
    /// For each facet, the next facet with the same pivot.
    next: Vec<u32>,
    /// For each candidate, the first facet whose pivot it is.
    first: Vec<u32>,
    counts: Vec<RoundCount>,
    pub(super) spare: Vec<Vec<u32>>,
}

/// The items of one round.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoundCount {
    /// The entries of the lists of both old facets.
    pub(super) entries: Sweep,
    /// The entries of the lists of the new facets.
    pub(super) kept: Sweep,
    pub(super) facets: Sweep,
    pub(super) ridges: Sweep,
}

/// A ridge on the boundary of a cavity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    /// Position of the inner facet in the cavity.
    pub(super) inner: usize,
    pub(super) outer: u32,
    /// The round of the new facet.
    pub(super) round: u32,
}

impl ConflictLists {
    /// Makes room for `slots` facets and `candidates` candidates, and empties all lists.
    pub(super) fn clear(&mut self, slots: usize, candidates: usize) {
        self.spare.extend(self.lists.drain(..).filter(|list| list.capacity() > 0));
        self.rounds.clear();
        self.next.clear();
        self.first.clear();
        self.first.resize(candidates, NONE);
        self.counts.clear();
        self.make_room(slots);
    }

    pub(super) fn make_room(&mut self, slots: usize) {
        if slots > self.lists.len() {
            self.lists.resize_with(slots, Vec::new);
            self.rounds.resize(slots, 0);
            self.next.resize(slots, NONE);
        }
    }

    /// Returns `true` if the candidate is the pivot of the facet.
    pub(super) fn is_pivot(&self, facet: u32, q: u32) -> bool {
        self.lists[facet as usize].first() == Some(&q)
    }

    /// Enters a facet, whose list is complete, at its pivot.
    pub(super) fn enter(&mut self, facet: u32) {
        if let Some(&pivot) = self.lists[facet as usize].first() {
            self.next[facet as usize] = std::mem::replace(&mut self.first[pivot as usize], facet);
        }
    }

    /// Sets `cavity` to the facets whose pivot is the candidate.
    pub(super) fn take_cavity(&mut self, q: u32, cavity: &mut Vec<u32>) {
        cavity.clear();
        let mut facet = self.first[q as usize];
        while facet != NONE {
            cavity.push(facet);
            facet = self.next[facet as usize];
        }
    }

    pub(super) fn round_mut(&mut self, round: u32) -> &mut RoundCount {
        let round = round as usize;
        if round >= self.counts.len() {
            self.counts.resize(round + 1, RoundCount::default());
        }
        &mut self.counts[round]
    }

    /// Charges all rounds.
    pub(super) fn charge(&self, cost: &mut Cost) {
        for RoundCount { entries, kept, facets, ridges } in &self.counts {
            cost.charge_sweeps([*facets, *entries, *kept, *ridges]);
        }
    }
}
