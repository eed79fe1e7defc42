//! Splits of subproblems: the decision of a leader on an attempt, and the splits that all workers receive.

use bincode::{Decode, Encode};
use bytemuck::Pod;

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

/// The routes of several members to both children of a node, member by member.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode)]
pub struct RouteBatch {
    /// For each member, the numbers of receivers of its route to the interior child and to the exterior child.
    pub lengths: Bulk<u32>,
    /// The receivers of all routes.
    pub receivers: Bulk<Rank>,
    /// The number of points for each receiver.
    pub counts: Bulk<u64>,
}

impl RouteBatch {
    /// Creates a batch from the routes of each member.
    pub fn of(routes: &[[Route; 2]]) -> Self {
        let mut batch = RouteBatch::default();
        for route in routes.iter().flatten() {
            batch.lengths.push(route.receivers.len() as u32);
            batch.receivers.extend_from_slice(&route.receivers);
            batch.counts.extend_from_slice(&route.counts);
        }
        batch
    }

    /// Returns `true` if the lengths of the columns are consistent.
    pub fn is_consistent(&self) -> bool {
        let receivers: u64 = self.lengths.iter().map(|&len| u64::from(len)).sum();
        self.lengths.len().is_multiple_of(2)
            && [self.receivers.len() as u64, self.counts.len() as u64] == [receivers; 2]
    }

    /// Returns the routes of each member, or no routes if the batch is not consistent.
    pub fn to_routes(&self) -> Vec<[Route; 2]> {
        if !self.is_consistent() {
            return Vec::new();
        }
        let mut at = 0;
        let mut next = |len: u32| {
            let range = at..at + len as usize;
            at = range.end;
            Route {
                receivers: Bulk(self.receivers[range.clone()].to_vec()),
                counts: Bulk(self.counts[range].to_vec()),
            }
        };
        self.lengths.chunks_exact(2).map(|pair| [next(pair[0]), next(pair[1])]).collect()
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

/// The splits of some shared nodes, as columns.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct SplitBatch<P> {
    /// The nodes.
    pub nodes: Bulk<u64>,
    /// The number of ranks of each interior child.
    pub interior: Bulk<u32>,
    /// Nine words for each separator (`Separator::to_array`).
    pub separators: Bulk<f64>,
    /// Four corners for each node: those of the interior and of the exterior box.
    pub boxes: Bulk<P>,
}

impl<P> SplitBatch<P> {
    /// Moves the splits of another batch to the end of this one.
    pub fn append(&mut self, mut other: Self) {
        self.nodes.append(&mut other.nodes);
        self.interior.append(&mut other.interior);
        self.separators.append(&mut other.separators);
        self.boxes.append(&mut other.boxes);
    }
}

impl<P> Default for SplitBatch<P> {
    fn default() -> Self {
        let (nodes, interior) = (Bulk(Vec::new()), Bulk(Vec::new()));
        SplitBatch { nodes, interior, separators: Bulk(Vec::new()), boxes: Bulk(Vec::new()) }
    }
}
