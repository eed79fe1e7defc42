//! The decision of a leader on an attempt to split a subproblem.

use bincode::{Decode, Encode};

use crate::codec::Bulk;
use crate::ids::Rank;

/// A child subproblem, as decided by the leader of its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Child {
    /// Number of owned points.
    pub population: u64,
    /// The first rank of its group.
    pub first: Rank,
    /// Number of ranks of its group.
    pub ranks: u32,
    /// Whether the child is a leaf.
    pub leaf: bool,
}

/// The ranks to which a member of a node's group sends its points of a child.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode)]
pub struct Route {
    /// The receivers. The member keeps the points that it would send to itself.
    pub receivers: Bulk<Rank>,
    /// The number of points for each receiver, in the order of the points.
    pub counts: Bulk<u64>,
}

impl Route {
    /// Appends a receiver, unless it gets no points.
    pub fn push(&mut self, receiver: Rank, count: u64) {
        if count > 0 {
            self.receivers.push(receiver);
            self.counts.push(count);
        }
    }
}

/// The decision of a leader on an attempt.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub enum Decision {
    /// Another separator is drawn.
    Retry,
    /// The subproblem is not split. The lowest rank of its group holds it as a leaf.
    Leaf,
    /// The subproblem is split into these children.
    Split([Child; 2]),
}
