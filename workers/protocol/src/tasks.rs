//! The record of tasks: the messages between leaves, independent of the number of workers.
//!
//! **Statement.** The tree, the neighbourhoods, the graph and the stars are functions of the points, the seed and the
//! parameters. The messages between two workers are therefore a sum over the pairs of their leaves. A [`TaskLog`]
//! holds the terms of this sum. One worker that runs the whole tree counts them. Given the placement of leaves on `p`
//! workers, the terms determine the messages of that machine.
//!
//! A leaf is identified by its position in the tree, from the interior to the exterior. A node is identified by its path
//! ([`crate::ids::NodeId`]). Blocks are equal shares of the input in its order.

use bincode::{Decode, Encode};
use serde::{Deserialize, Serialize};

use crate::ids::Phase;

/// The samples of an attempt at a node: path, attempt, and pairs of a block and its number of samples.
pub type SampleRow = (u64, u32, Vec<(u32, u32)>);

/// The terms of a run. Rows are sorted by their first columns.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode, Serialize, Deserialize)]
pub struct TaskLog {
    /// Number of points.
    pub population: u64,
    /// The largest population of a leaf that is not split.
    pub leaf_size: u64,
    /// Number of coordinates.
    pub dimension: u32,
    /// Number of blocks of the input. Point `i` lies in block `i * blocks / population`.
    pub blocks: u32,
    /// All nodes of the tree: path, owned points, attempts, and the number of the [`crate::ledger::NodeKind`].
    pub nodes: Vec<(u64, u64, u64, u64)>,
    /// Paths of the leaves, in order.
    pub leaves: Vec<u64>,
    /// Leaves of the frame's points.
    pub frame: Vec<u32>,
    /// For each leaf, pairs of a block and the number of owned points that it contains.
    pub first_blocks: Vec<Vec<(u32, u32)>>,
    /// The samples of each attempt at each node.
    pub samples: Vec<SampleRow>,
    /// Balls or points that leave the path to their own leaf: phase, leaf, node reached, number of balls or points,
    /// entries of the lists found there, and distinct points in these lists.
    pub reach: Vec<(Phase, u32, u64, u64, u64, u64)>,
    /// Whether a sample chose the supergraph.
    pub chosen: bool,
    /// Edges of nearest neighbours that are sent to their other end: leaf, leaf of the other end, number.
    pub reverse: Vec<(u32, u32, u64)>,
    /// Points that send these edges. For each point, take the leaves of the other ends in order. A row holds the leaf
    /// of the point, one of these leaves, the leaf before it in this order, and the number of points. For the first
    /// leaf, the leaf of the point is the one before it. The leaves of a worker are consecutive. The number of
    /// workers that receive a point is therefore the number of its rows whose leaf and preceding leaf are on
    /// different workers.
    #[serde(default, rename = "tellers")]
    pub senders: Vec<(u32, u32, u32, u64)>,
    /// Sums that two leaves must agree on: number of the check, both leaves, low and high half of the sum, pairs.
    pub agreement: Vec<(u32, u32, u32, u64, u64, u64)>,
    /// Proposals and objections between the stars of two leaves.
    pub exchange: Vec<SentCells>,
    /// Cells of each leaf.
    pub cells: Vec<u64>,
    /// Charges: phase, node, work, depth.
    pub charges: Vec<(Phase, u64, u64, u64)>,
}

/// Proposals or objections from the stars of one leaf to the stars of another in one step of splaying.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode, Serialize, Deserialize)]
pub struct SentCells {
    /// The step of the phase.
    pub step: u32,
    /// `true` for objections, `false` for proposals.
    pub objection: bool,
    /// The leaf of the sender.
    pub from: u32,
    /// The leaf of the receiver.
    pub to: u32,
    /// Cells.
    pub cells: u64,
    /// Points in conflict with the cells.
    pub conflicts: u64,
    /// Ids of all points in the cells and conflicts, sorted.
    pub points: Vec<u64>,
}
