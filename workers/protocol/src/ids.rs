//! Identifiers of ranks, subproblems and phases.

mod phases;

use bincode::{Decode, Encode};
use serde::{Deserialize, Serialize};

pub use phases::{ByGroup, Flow, Group, Phase, PhaseNumberError, names};

/// A rank of the machine. Rank 0 is the coordinator, workers are `1..=p`.
pub type Rank = u32;

/// The rank of the coordinator. It owns no point, and neither points nor results pass through it.
pub const COORDINATOR: Rank = 0;

/// A subproblem: a node of the partition tree, identified by its path. The root is 1. The interior child of `s` is `2s`,
/// the exterior child is `2s + 1`.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Encode, Decode, Serialize, Deserialize,
)]
pub struct NodeId(pub u64);

impl NodeId {
    /// The whole point set.
    pub const ROOT: NodeId = NodeId(1);
    /// The largest level of a node: a path has 64 bits.
    pub const DEEPEST: u32 = 62;

    /// Returns the interior (`side` 0) or exterior (`side` 1) child.
    #[must_use]
    pub fn child(self, side: usize) -> NodeId {
        NodeId(self.0 * 2 + side as u64)
    }

    /// Returns the parent, or `None` for the root.
    pub fn parent(self) -> Option<NodeId> {
        (self.0 > 1).then_some(NodeId(self.0 / 2))
    }

    /// Returns the side in the parent: 0 is interior, 1 is exterior.
    pub fn side(self) -> usize {
        (self.0 & 1) as usize
    }

    /// Returns the number of levels below the root.
    pub fn level(self) -> u32 {
        self.0.ilog2()
    }

    /// Returns `true` if `self` is `other` or an ancestor of it.
    pub fn contains(self, other: NodeId) -> bool {
        let (a, b) = (self.level(), other.level());
        a <= b && other.0 >> (b - a) == self.0
    }

    /// Returns the side of the child of `self` that is `other` or an ancestor of it. `other` must be a proper
    /// descendant.
    pub fn side_of(self, other: NodeId) -> usize {
        let shift = other.level() - self.level() - 1;
        ((other.0 >> shift) & 1) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths() {
        let n = NodeId::ROOT.child(0).child(1).child(1);
        assert_eq!((n.0, n.level(), n.side()), (11, 3, 1));
        assert!(NodeId(2).contains(n) && !NodeId(3).contains(n) && n.contains(n));
        assert_eq!((NodeId::ROOT.side_of(n), NodeId(2).side_of(n), NodeId(5).side_of(n)), (0, 1, 1));
        assert_eq!(n.parent(), Some(NodeId(5)));
    }
}
