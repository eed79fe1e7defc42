//! The messages: one closed enum, versioned, each with run, subproblem, attempt, round and sequence.

mod queries;

use bincode::{Decode, Encode};
use bytemuck::Pod;

use crate::codec::{self, Bulk, CodecError};
use crate::ids::{NodeId, Rank};
use crate::tasks::TaskLog;

pub use queries::{QueryBatch, ReplyBatch};

/// Raised whenever the meaning or layout of a message changes; peers with another are refused.
pub const PROTOCOL_VERSION: u16 = 8;

/// A message with its envelope.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct Message<P> {
    /// [`PROTOCOL_VERSION`] of the sender.
    pub version: u16,
    /// Which run.
    pub run: u64,
    /// Sender.
    pub from: Rank,
    /// Receiver.
    pub to: Rank,
    /// The subproblem it belongs to.
    pub node: NodeId,
    /// Attempt of that subproblem (retries of a separator, rounds of repair).
    pub attempt: u32,
    /// The round in which it was sent.
    pub round: u32,
    /// Number of this message among its sender's.
    pub sequence: u32,
    /// What it says.
    pub body: Body<P>,
}

impl<P: Pod> Message<P> {
    /// Exact number of bytes of [`Message::encode`]: what the ledger bills.
    pub fn encoded_len(&self) -> usize {
        codec::encoded_len(self)
    }

    /// The message as bytes.
    ///
    /// # Errors
    /// If it is longer than a frame may be.
    pub fn encode(&self) -> Result<Vec<u8>, CodecError> {
        codec::encode(self)
    }

    /// The message in these bytes.
    ///
    /// # Errors
    /// If they are not exactly one message.
    pub fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        codec::decode(bytes)
    }
}

/// Points in bulk: structure of arrays, one entry a point. Points on their way home ([`PointBatch::in_transit`]) have
/// no owner yet, and a ball only if it is given: those two columns may be empty.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct PointBatch<P> {
    /// Index in the input.
    pub ids: Bulk<u64>,
    /// Coordinates.
    pub positions: Bulk<P>,
    /// The rank where the point is at home.
    pub owners: Bulk<Rank>,
    /// Squared radius of its ball.
    pub radii2: Bulk<f64>,
}

impl<P> Default for PointBatch<P> {
    fn default() -> Self {
        PointBatch {
            ids: Bulk(Vec::new()),
            positions: Bulk(Vec::new()),
            owners: Bulk(Vec::new()),
            radii2: Bulk(Vec::new()),
        }
    }
}

impl<P: Copy> PointBatch<P> {
    /// Points on their way home.
    pub fn in_transit(ids: Vec<u64>, positions: Vec<P>) -> Self {
        PointBatch { ids: Bulk(ids), positions: Bulk(positions), ..PointBatch::default() }
    }

    /// Appends a point.
    pub fn push(&mut self, id: u64, position: P, owner: Rank, radius2: f64) {
        self.ids.push(id);
        self.positions.push(position);
        self.owners.push(owner);
        self.radii2.push(radius2);
    }

    /// Appends the points of another batch, which is empty then.
    pub fn append(&mut self, other: &mut Self) {
        self.ids.append(&mut other.ids);
        self.positions.append(&mut other.positions);
        self.owners.append(&mut other.owners);
        self.radii2.append(&mut other.radii2);
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Do all columns have one entry a point?
    pub fn is_consistent(&self) -> bool {
        let n = self.len();
        self.positions.len() == n && self.owners.len() == n && self.radii2.len() == n
    }
}

/// Lists of points, one list a slot: neighbours found elsewhere.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct ListBatch<P> {
    /// The receiver's name of each list.
    pub slots: Bulk<u32>,
    /// Length of each list.
    pub counts: Bulk<u32>,
    /// All lists, one after the other.
    pub points: PointBatch<P>,
}

/// A child subproblem as decided by its parent's leader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct Child {
    /// Number of home points.
    pub population: u64,
    /// First rank of its group.
    pub first: Rank,
    /// Number of ranks of its group.
    pub ranks: u32,
    /// Will it be split no further?
    pub leaf: bool,
}

/// What a leader decided about an attempt.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub enum Decision {
    /// Draw again.
    Retry,
    /// Give up splitting: the subproblem is a leaf, held by its group's lowest rank.
    Leaf,
    /// Split into these.
    Split([Child; 2]),
}

/// What is known of a subproblem after the neighbourhoods.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct Summary<P> {
    /// Largest squared radius of a home point's ball.
    pub max_radius2: f64,
    /// The lexicographically smallest home point (one entry).
    pub smallest: PointBatch<P>,
}

/// What the merged result of a subproblem says (the union of its children's).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Encode, Decode)]
pub struct Merged {
    /// Stars built by the exact kernel and not empty.
    pub stars: u64,
    /// Finite cells whose lexicographically smallest vertex is at home here.
    pub cells: u64,
    /// Hull facets likewise.
    pub hull_facets: u64,
    /// Vertices without a lexicographically smaller neighbour: 1 in a whole triangulation.
    pub minima: u64,
    /// Pairs of workers whose fingerprints differ, and local disagreements.
    pub disagreements: u64,
    /// Stars changed by the exchange.
    pub repaired: u64,
    /// Unchanged stars whose circumspheres all lie in the ball of radius `alpha r` around their vertex.
    pub local: u64,
    /// Rounds of exchange (the largest of the parts).
    pub exchange_rounds: u64,
}

impl Merged {
    /// The union of two disjoint results.
    pub fn join(&mut self, other: &Merged) {
        self.stars += other.stars;
        self.cells += other.cells;
        self.hull_facets += other.hull_facets;
        self.minima += other.minima;
        self.disagreements += other.disagreements;
        self.repaired += other.repaired;
        self.local += other.local;
        self.exchange_rounds = self.exchange_rounds.max(other.exchange_rounds);
    }
}

/// A star was changed by the exchange: a flag in [`ViewPart::flags`].
pub const SHOWN_REPAIRED: u64 = 1;
/// A star's circumspheres all lie in the known ball around its vertex: a flag in [`ViewPart::flags`].
pub const SHOWN_LOCAL: u64 = 2;

/// The radius of a gathered point whose star is wanted ([`Body::Gather`]).
pub const WANTED: f64 = 1.0;
/// The radius of a gathered point that only the links of others hold.
pub const OF_A_LINK: f64 = 0.0;

/// What a worker shows of its points and of the tree: sampled points, one entry each, and the splits it
/// answers for.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct ViewPart<P> {
    /// Sampled home points.
    pub points: PointBatch<P>,
    /// Home leaf of each.
    pub leaves: Bulk<u64>,
    /// Bit `l`: the point's ball meets the separator of its ancestor of level `l`.
    pub crossing: Bulk<u64>,
    /// [`SHOWN_REPAIRED`], [`SHOWN_LOCAL`].
    pub flags: Bulk<u64>,
    /// Ids of sampled points that a leaf here holds as ghosts.
    pub ghosts: Bulk<u64>,
    /// That leaf, one entry a ghost.
    pub ghost_leaves: Bulk<u64>,
    /// Nodes that were split.
    pub nodes: Bulk<u64>,
    /// Their separators, 9 numbers each (`Separator::to_array`).
    pub separators: Bulk<f64>,
    /// Low and high corner of their home points' boxes.
    pub boxes: Bulk<P>,
}

impl<P> Default for ViewPart<P> {
    fn default() -> Self {
        ViewPart {
            points: PointBatch::default(),
            leaves: Bulk(Vec::new()),
            crossing: Bulk(Vec::new()),
            flags: Bulk(Vec::new()),
            ghosts: Bulk(Vec::new()),
            ghost_leaves: Bulk(Vec::new()),
            nodes: Bulk(Vec::new()),
            separators: Bulk(Vec::new()),
            boxes: Bulk(Vec::new()),
        }
    }
}

impl<P: Copy> ViewPart<P> {
    /// Do all columns fit each other?
    pub fn is_consistent(&self) -> bool {
        let (n, m) = (self.points.len(), self.nodes.len());
        self.points.is_consistent()
            && [self.leaves.len(), self.crossing.len(), self.flags.len()] == [n; 3]
            && self.ghosts.len() == self.ghost_leaves.len()
            && self.separators.len() == 9 * m
            && self.boxes.len() == 2 * m
    }
}

/// What a message says.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub enum Body<P> {
    /// Coordinator to worker: number of points, and a frame that spans the space.
    Start {
        /// Number of distinct points of the run.
        population: u64,
        /// `d + 1` affinely independent points.
        frame: PointBatch<P>,
    },
    /// Coordinator to worker: its block of the input, homeless.
    Block(PointBatch<P>),
    /// Leaves below every node of a subtree, where the placement is planned: node, leaves.
    Plan {
        /// Nodes.
        nodes: Bulk<u64>,
        /// Leaves below each.
        leaves: Bulk<u32>,
    },
    /// Member to leader: the member's samples of the subproblem.
    Samples(Bulk<P>),
    /// Leader to member: the separator drawn. Empty: none could be.
    Sphere(Bulk<f64>),
    /// Member to leader: how many home points lie inside and outside, and their boxes (low and high
    /// corner inside, low and high corner outside).
    Counts {
        /// Interior points.
        inside: u64,
        /// Exterior points.
        outside: u64,
        /// Four corners.
        boxes: Bulk<P>,
    },
    /// Leader to member: what becomes of the attempt, with the boxes of both children.
    Decision {
        /// The verdict.
        verdict: Decision,
        /// Four corners, as in `Counts`; empty unless split.
        boxes: Bulk<P>,
    },
    /// Member to member: points that move to a child.
    Move(PointBatch<P>),
    /// Balls that look for points below this node.
    Query(QueryBatch<P>),
    /// The points they found.
    Reply(ReplyBatch<P>),
    /// Leader to the parent's leader: what the subproblem holds.
    Summary(Summary<P>),
    /// Leader to members: what both children hold.
    Children(Box<[Summary<P>; 2]>),
    /// Worker to coordinator, and coordinator to all: where the frame's points are at home.
    Frame(PointBatch<P>),
    /// Worker to coordinator: sampled stars, and how many the radii 2.5, 3, 4, 6 certify.
    SampleStars(Bulk<u64>),
    /// Coordinator to worker: the supergraph (0 density, 1 overlap, 2 knn) and its parameter.
    Choice {
        /// Kind.
        kind: u8,
        /// alpha, or k.
        parameter: f64,
    },
    /// Points that belong to a subproblem's surroundings: as far as their balls reach (in halos, balls of the halo's radius).
    Ghosts(PointBatch<P>),
    /// Points that may be neighbours of points in a subproblem, with the cells that reach into it.
    Seam {
        /// The points.
        points: PointBatch<P>,
        /// Positions in `points`, `d + 1` a cell; `u32::MAX` for infinity, the first bit set where a point only gives the
        /// cell its shape. None where nobody asks why.
        cells: Bulk<u32>,
    },
    /// Points some of whose nearest neighbours are at home at the receiver: the other ends of edges.
    Reverse {
        /// The points, each once.
        points: PointBatch<P>,
        /// How many of its neighbours each has there.
        counts: Bulk<u32>,
        /// The ids of these neighbours, point by point.
        targets: Bulk<u64>,
    },
    /// Members of a subproblem's set (home and separator points), with the sender's names of them.
    Items {
        /// The points.
        points: PointBatch<P>,
        /// The sender's name of each.
        slots: Bulk<u32>,
    },
    /// Member to leader: size of its share of the set, and of each child's, and of the crossing points on
    /// either side.
    SetCounts(Bulk<u64>),
    /// Leader to member: 0 stop here, 1 both sides cross, 2 interior points cross, 3 exterior ones.
    SetDecision(u8),
    /// Neighbours found in another leaf.
    Lists(ListBatch<P>),
    /// Order-free fingerprint of the cells two workers share: low and high half, then their number.
    Fingerprint(Bulk<u64>),
    /// Of the same, the key of each cell and vertex.
    FingerprintList(Bulk<u64>),
    /// Cells that stand in the star of `from[i]`, proposed to `to[i]`: one row of other vertices a cell,
    /// as positions in `points`.
    Propose {
        /// All points named.
        points: PointBatch<P>,
        /// Positions in `points`, `d + 1` a cell: from, to, then the others.
        cells: Bulk<u32>,
    },
    /// Cells that are not Delaunay, told to the stars of `to[i]` that may hold them, with points that lie in
    /// their spheres.
    Object {
        /// All points named.
        points: PointBatch<P>,
        /// Positions in `points`, `d + 1` a cell: from, to, then the others.
        cells: Bulk<u32>,
        /// Number of points in conflict with each cell.
        counts: Bulk<u32>,
        /// Positions in `points` of all of them.
        conflicts: Bulk<u32>,
    },
    /// Points at home at the sender that are in the independent set now: to whoever has neighbours of theirs.
    Joined(Bulk<u64>),
    /// Points at home at the sender that are out of it now, likewise.
    Left(Bulk<u64>),
    /// The merged result of a subproblem, to the parent's leader.
    Merged(Merged),
    /// Coordinator to worker, after a certificate: the number of an [`Outcome`](crate::outcome::Outcome).
    Outcome(u8),
    /// Worker to coordinator: the vertices of unresolved stars and of their links; a point's radius says which
    /// ([`WANTED`], [`OF_A_LINK`]).
    Gather(PointBatch<P>),
    /// Coordinator to worker: points to add to stars.
    Region {
        /// Ids of the vertices.
        vertices: Bulk<u64>,
        /// Number of points for each.
        counts: Bulk<u32>,
        /// All points.
        points: PointBatch<P>,
    },
    /// Worker to coordinator: cells as rows of point ids, and the home leaf of each.
    Cells {
        /// `d + 1` ids a row, positively oriented.
        cells: Bulk<u64>,
        /// Leaf of the smallest vertex.
        leaves: Bulk<u64>,
    },
    /// Worker to coordinator: its cells with their adjacency (`triangulate` only).
    Piece {
        /// The leaf that was home to the worker's points.
        leaf: u64,
        /// Input index of each vertex.
        ids: Bulk<u64>,
        /// `d + 1` vertices a cell, positively oriented, then across the facet opposite each a cell, or one of
        /// two marks (hull, another piece).
        rows: Bulk<u32>,
        /// The cells with a mark, by their numbers, ascending.
        open: Bulk<u32>,
    },
    /// Worker to coordinator: its share of the independent set.
    Selected {
        /// Ids of its members that joined.
        members: Bulk<u64>,
        /// How many home points were undecided at the start of each round, as long as there were any.
        undecided: Bulk<u64>,
    },
    /// Worker to coordinator: graph edges as pairs of ids (on request).
    Edges(Bulk<u64>),
    /// Worker to coordinator: its part of the ledger. Not billed: it is the instrument.
    Ledger(Bulk<u64>),
    /// Worker to coordinator: what its leaves had to say to each other, on request. Not billed either.
    Tasks(Box<TaskLog>),
    /// Worker to coordinator, on request: what it shows of itself in pictures. Not billed: it is the
    /// instrument.
    View(Box<ViewPart<P>>),
}

impl<P> Body<P> {
    /// Name of its kind in traces.
    pub fn kind(&self) -> &'static str {
        match self {
            Body::Start { .. } => "start",
            Body::Block(_) => "block",
            Body::Plan { .. } => "plan",
            Body::Samples(_) => "samples",
            Body::Sphere(_) => "sphere",
            Body::Counts { .. } => "counts",
            Body::Decision { .. } => "decision",
            Body::Move(_) => "move",
            Body::Query(_) => "query",
            Body::Reply(_) => "answer",
            Body::Summary(_) => "summary",
            Body::Children(_) => "children",
            Body::Frame(_) => "frame",
            Body::SampleStars(_) => "sample stars",
            Body::Choice { .. } => "choice",
            Body::Ghosts(_) => "ghosts",
            Body::Seam { .. } => "seam",
            Body::Reverse { .. } => "reverse",
            Body::Items { .. } => "items",
            Body::SetCounts(_) => "set counts",
            Body::SetDecision(_) => "set decision",
            Body::Lists(_) => "lists",
            Body::Fingerprint(_) => "fingerprint",
            Body::FingerprintList(_) => "fingerprint list",
            Body::Propose { .. } => "propose",
            Body::Object { .. } => "object",
            Body::Joined(_) => "joined",
            Body::Left(_) => "left",
            Body::Merged(_) => "merged",
            Body::Outcome(_) => "outcome",
            Body::Gather(_) => "gather",
            Body::Region { .. } => "region",
            Body::Cells { .. } => "cells",
            Body::Piece { .. } => "piece",
            Body::Selected { .. } => "selected",
            Body::Edges(_) => "edges",
            Body::Ledger(_) => "ledger",
            Body::Tasks(_) => "tasks",
            Body::View(_) => "view",
        }
    }

    /// Is it the instrument's own traffic, which is not billed?
    pub fn is_instrument(&self) -> bool {
        matches!(self, Body::Ledger(_) | Body::Tasks(_) | Body::View(_))
    }

    /// Is it reading or merging, for the coordinator's budget?
    pub fn is_bulk(&self) -> bool {
        matches!(
            self,
            Body::Block(_) | Body::Cells { .. } | Body::Piece { .. } | Body::Selected { .. } | Body::Edges(_)
        )
    }
}

impl<P: Copy> Body<P> {
    /// Do the arrays of queries and answers fit together? Of others nothing is known.
    pub fn is_consistent(&self) -> bool {
        match self {
            Body::Query(batch) => batch.is_consistent(),
            Body::Reply(batch) => batch.is_consistent(),
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests;
