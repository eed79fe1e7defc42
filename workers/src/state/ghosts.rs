//! The ghosts of each leaf.

use std::cmp::Ordering;

use crate::state::tree::Leaf;

/// For each leaf, the points outside the leaf that may be adjacent to its owned points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ghosts(Vec<Vec<u32>>);

impl Ghosts {
    /// Creates empty lists for `leaves` leaves.
    pub(crate) fn of_leaves(leaves: usize) -> Self {
        Ghosts(vec![Vec::new(); leaves])
    }

    /// Returns the ghosts of a leaf, by its index among the leaves of the rank.
    pub(crate) fn of(&self, leaf: usize) -> &[u32] {
        self.0.get(leaf).map_or(&[], Vec::as_slice)
    }

    /// Adds a ghost to a leaf.
    pub(crate) fn push(&mut self, leaf: usize, ghost: u32) {
        self.0[leaf].push(ghost);
    }

    /// Adds ghosts to the first leaf of a rank that has at most one leaf.
    pub(crate) fn add_to_first(&mut self, ghosts: Vec<u32>) {
        match self.0.first_mut() {
            Some(first) => first.extend(ghosts),
            None => self.0.push(ghosts),
        }
    }

    /// Sorts the ghosts of each leaf and removes duplicates. In `order`, equal ghosts must be adjacent.
    pub(crate) fn sort_by(&mut self, mut order: impl FnMut(&u32, &u32) -> Ordering) {
        for ghosts in &mut self.0 {
            ghosts.sort_unstable_by(&mut order);
            ghosts.dedup();
        }
    }

    /// Returns the owned points of the leaf with index `at`, followed by its ghosts.
    pub(crate) fn members<P>(&self, at: usize, leaf: &Leaf<P>) -> Vec<u32> {
        leaf.owned().chain(self.of(at).iter().copied()).collect()
    }
}
