//! A set of numbers in the order of insertion.
//!
//! **Statement.** [`Seen::push`] adds a number once. Breadth-first searches use it both as the queue and as the set of visited
//! items.
//!
//! **Work.** O(1) for each number of a small set, O(log n) in a large one.

use std::collections::BTreeSet;

/// Up to this number of items, comparing all of them is faster than a tree.
const FEW: usize = 64;

/// The numbers of a set, in the order of insertion.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    list: Vec<u32>,
    /// The same numbers, if they are many.
    tree: BTreeSet<u32>,
}

impl Seen {
    /// Removes all numbers.
    pub(crate) fn clear(&mut self) {
        self.list.clear();
        self.tree.clear();
    }

    /// Adds a number. Returns whether it is new.
    pub(crate) fn push(&mut self, x: u32) -> bool {
        if self.list.len() < FEW {
            if self.list.contains(&x) {
                return false;
            }
            self.list.push(x);
            return true;
        }
        if self.tree.is_empty() {
            self.tree.extend(&self.list);
        }
        let is_new = self.tree.insert(x);
        if is_new {
            self.list.push(x);
        }
        is_new
    }

    /// Whether the set has a number.
    pub(crate) fn contains(&self, x: u32) -> bool {
        if self.tree.is_empty() { self.list.contains(&x) } else { self.tree.contains(&x) }
    }

    /// Returns a number by its position.
    pub(crate) fn get(&self, at: usize) -> Option<u32> {
        self.list.get(at).copied()
    }

    /// Returns all numbers in the order of insertion.
    pub(crate) fn list(&self) -> &[u32] {
        &self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_added_once() {
        let mut seen = Seen::default();
        for round in 0..2 {
            for x in 0..300 {
                assert_eq!(seen.push(x * 7919 % 1000), round == 0);
            }
        }
        assert_eq!(seen.list().len(), 300);
        assert!((0..1000).filter(|&x| seen.contains(x)).count() == 300 && seen.get(1) == Some(919));
        seen.clear();
        assert!(seen.list().is_empty() && !seen.contains(0));
    }
}
