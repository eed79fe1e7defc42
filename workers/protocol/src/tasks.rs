//! What a run does, told leaf by leaf and free of the number of workers.
//!
//! **Statement.** Tree, neighbourhoods, graph and stars are functions of points, seed and parameters. What
//! crosses between two workers is therefore the sum, over the leaves of the one and the leaves of the other,
//! of what those leaves have to say to each other. A [`TaskLog`] holds these terms, counted while one worker
//! runs the whole tree; mapped to `p` workers by the placement of the machine itself, they give its messages.
//!
//! Leaves are named by their position in the tree, from the interior to the exterior; nodes by their path
//! ([`crate::ids::NodeId`]); blocks are equal shares of the input in its order.

use bincode::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// Samples of a node's attempt: path, attempt, and (block, number) of those drawn.
pub type SampleRow = (u64, u32, Vec<(u32, u32)>);

/// The terms of a run. Rows are sorted by their first columns.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode, Serialize, Deserialize)]
pub struct TaskLog {
    /// Number of points.
    pub population: u64,
    /// Largest leaf asked for.
    pub leaf_size: u64,
    /// Number of coordinates.
    pub dimension: u32,
    /// Blocks of the input in which places are told: point `i` lies in block `i * blocks / population`.
    pub blocks: u32,
    /// All nodes of the tree: path, home points, attempts, kind (0 leaf, 1 sphere, 2 plane).
    pub nodes: Vec<(u64, u64, u64, u64)>,
    /// Paths of the leaves, in order.
    pub leaves: Vec<u64>,
    /// Leaves of the frame's points.
    pub frame: Vec<u32>,
    /// For each leaf, (block, home points that come from it).
    pub first_blocks: Vec<Vec<(u32, u32)>>,
    /// For each node and attempt: its samples.
    pub samples: Vec<SampleRow>,
    /// Phase, home leaf, node off the way home; balls or points that reach it, entries of the lists found there for
    /// them, points that these name.
    pub reach: Vec<(u8, u32, u64, u64, u64, u64)>,
    /// Was the supergraph chosen by a sample?
    pub chosen: bool,
    /// Edges of nearest neighbours that are told to their other end: leaf, leaf of the other end, number.
    pub reverse: Vec<(u32, u32, u64)>,
    /// Points that tell them. Of each, the leaves of the other ends in order: the point's leaf, one of them, the one
    /// before it (or its own leaf's number again, if it is the first); number of points. As a worker's leaves follow each
    /// other, a point goes to as many workers as hold one of these leaves and not the one before it.
    #[serde(default)]
    pub tellers: Vec<(u32, u32, u32, u64)>,
    /// Number of the check; leaf; leaf that must hold the same; low and high half of the sum; pairs.
    pub agreement: Vec<(u32, u32, u32, u64, u64, u64)>,
    /// What stars of two leaves say to each other in the exchange.
    pub exchange: Vec<Said>,
    /// Cells of each leaf.
    pub cells: Vec<u64>,
    /// Phase, node, work, depth: what was charged.
    pub charges: Vec<(u8, u64, u64, u64)>,
}

/// Proposals or objections of one leaf's stars to another's in one step of the exchange.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode, Serialize, Deserialize)]
pub struct Said {
    /// Step of the phase in which it is sent.
    pub step: u32,
    /// An objection? Else a proposal.
    pub objection: bool,
    /// The speaker's leaf.
    pub from: u32,
    /// The listener's leaf.
    pub to: u32,
    /// Cells.
    pub cells: u64,
    /// Points in conflict with them.
    pub conflicts: u64,
    /// Ids of all points named, sorted.
    pub points: Vec<u64>,
}
