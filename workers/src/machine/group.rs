//! A group of ranks: a node of the partition tree with the ranks that share it. One of them leads it.

use std::ops::Range;

use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::Child;

/// A node, and the group of ranks that shares it.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// The node.
    pub node: NodeId,
    /// The rank that leads the group.
    pub leader: Rank,
    /// The ranks and the points of the group.
    pub child: Child,
}

/// Returns the rank that leads a group: the member in the middle. If all groups are halved exactly, a rank leads at
/// most one group.
pub(crate) fn leader(child: &Child) -> Rank {
    child.first + (child.ranks.max(1) - 1) / 2
}

impl Group {
    /// Creates the group of a node.
    pub(crate) fn new(node: NodeId, child: Child) -> Self {
        Group { node, leader: leader(&child), child }
    }

    /// Creates the group of a child.
    pub(crate) fn below(self, side: usize, child: Child) -> Self {
        Group::new(self.node.child(side), child)
    }

    /// Returns `true` if one rank takes the whole node.
    pub(crate) fn is_whole(&self) -> bool {
        self.child.ranks == 1 || self.child.leaf
    }

    /// Returns the ranks of the group.
    pub(crate) fn members(&self) -> Range<Rank> {
        self.child.first..self.child.first + self.child.ranks
    }
}
