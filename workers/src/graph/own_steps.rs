//! The accounts of the recursion on sets, with and without separators of their own.
//!
//! **Statement.** By the rules on the partition tree, a set is a node of the tree, and the ledger orders its charges from
//! parent to child. The recursion with own separators has another tree. Its charges are therefore steps: all sets of a
//! level make an attempt together, then divide together; all leaves compare their pairs; and all sets of a level
//! unite their lists, from the lowest level up.
//!
//! **Departure.** In the paper a set waits for its parent only. Here it waits for all sets of the level above, so the depth
//! is an upper bound: at most `O(log n)` levels, each with the depth of its slowest set.

use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;

use crate::partition::leader::MAX_ATTEMPTS;

/// The number of levels of a tree whose nodes have 64-bit numbers.
const LEVELS: u32 = 64;

/// The number of steps of a level: three for each attempt, and the division.
const STEPS: u32 = 3 * MAX_ATTEMPTS + 1;

/// A step of the recursion with own separators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OwnStep {
    /// Members select the samples of an attempt.
    Sample(u32),
    /// Leaders draw separators from the samples of an attempt.
    Draw(u32),
    /// Members count the sides of an attempt.
    Count(u32),
    /// Members divide the set.
    Divide,
    /// All pairs of a set that is not divided are compared.
    Compare,
    /// The lists of the children of a set are united.
    Unite,
}

impl OwnStep {
    /// Returns the account of a set in this step.
    pub(super) fn account(self, node: NodeId) -> Account {
        let level = node.level();
        let number = match self {
            OwnStep::Sample(attempt) => level * STEPS + 3 * attempt,
            OwnStep::Draw(attempt) => level * STEPS + 3 * attempt + 1,
            OwnStep::Count(attempt) => level * STEPS + 3 * attempt + 2,
            OwnStep::Divide => (level + 1) * STEPS - 1,
            OwnStep::Compare => LEVELS * STEPS,
            OwnStep::Unite => LEVELS * (STEPS + 1) - level,
        };
        Account::step(Phase::OwnSets, number, node)
    }
}

/// The tree of the sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SetTree {
    /// Sets are nodes of the partition tree.
    Partition,
    /// Every set has its own separator.
    Own,
}

impl SetTree {
    /// Returns the account of the comparison of all pairs of a set.
    pub(super) fn comparison(self, node: NodeId) -> Account {
        match self {
            SetTree::Partition => Account::member(Phase::Graph, node),
            SetTree::Own => OwnStep::Compare.account(node),
        }
    }

    /// Returns the account of the union of the lists of a set's children.
    pub(super) fn union(self, node: NodeId) -> Account {
        match self {
            SetTree::Partition => Account::member(Phase::Sets, node),
            SetTree::Own => OwnStep::Unite.account(node),
        }
    }
}

#[cfg(test)]
mod tests {
    use septet_protocol::ledger::Role;

    use super::*;

    #[test]
    fn steps_are_in_the_order_of_the_recursion() {
        let (root, child) = (NodeId::ROOT, NodeId::ROOT.child(1));
        let last = MAX_ATTEMPTS - 1;
        let order = [
            (OwnStep::Sample(0), root),
            (OwnStep::Draw(0), root),
            (OwnStep::Count(0), root),
            (OwnStep::Sample(last), root),
            (OwnStep::Count(last), root),
            (OwnStep::Divide, root),
            (OwnStep::Sample(0), child),
            (OwnStep::Divide, NodeId(1 << 63)),
            (OwnStep::Compare, root),
            (OwnStep::Unite, NodeId(1 << 63)),
            (OwnStep::Unite, child),
            (OwnStep::Unite, root),
        ];
        let numbers = order.map(|(step, node)| match step.account(node).role {
            Role::Step(number) => number,
            Role::Member | Role::Leader | Role::Pass(_) => panic!("no step"),
        });
        assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
    }
}
