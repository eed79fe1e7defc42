//! The messages: a closed enum of bodies in an envelope with version, run, subproblem, attempt, round and sequence.

mod defects;
mod input;
pub mod kinds;
mod merged;
mod queries;
mod split;
mod typed;

use bincode::{Decode, Encode};
use bytemuck::Pod;

use crate::checksum::hash_of;
use crate::codec::{self, Bulk, CodecError};
use crate::ids::{NodeId, Rank};
use crate::outcome::Outcome;

pub use input::{RefusedRow, SiteTotals, Survey};
pub use merged::{Merged, PointSum, Totals};
pub use queries::{QueryBatch, ReplyBatch};
pub use split::{Child, Decision, Route, RouteBatch, SplitBatch};
pub use typed::{AlphaCounts, ChosenSupergraph, Crossings, Fingerprint, SampleStars, SetCounts, SetDecision};

/// The version of the protocol. It increases when the meaning or layout of a message changes.
pub const PROTOCOL_VERSION: u16 = 15;

/// A message with its envelope.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct Message<P> {
    /// [`PROTOCOL_VERSION`] of the sender.
    pub version: u16,
    /// The run.
    pub run: u64,
    /// The sender.
    pub from: Rank,
    /// The receiver.
    pub to: Rank,
    /// The subproblem.
    pub node: NodeId,
    /// The attempt at the subproblem (a separator, a round of splaying).
    pub attempt: u32,
    /// The round in which the message was sent.
    pub round: u32,
    /// The sequence number that the sender assigned to the message.
    pub sequence: u32,
    /// The body.
    pub body: Body<P>,
}

impl<P: Pod> Message<P> {
    /// Returns the exact length of [`Message::encode`] in bytes, which the ledger bills.
    pub fn encoded_len(&self) -> usize {
        codec::encoded_len(self)
    }

    /// Returns a hash of the envelope and the body.
    pub fn content_hash(&self) -> u64 {
        hash_of(self)
    }

    /// Encodes the message.
    ///
    /// # Errors
    /// Fails if the message is longer than a frame may be.
    pub fn encode(&self) -> Result<Vec<u8>, CodecError> {
        codec::encode(self)
    }

    /// Decodes a message.
    ///
    /// # Errors
    /// Fails if the bytes are not exactly one message.
    pub fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        codec::decode(bytes)
    }
}

/// Points as a structure of arrays with one entry per point. Points in transit ([`PointBatch::in_transit`]) have no owner
/// yet, and a ball only if the input gives one, so those two columns may be empty.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct PointBatch<P> {
    /// Index in the input.
    pub ids: Bulk<u64>,
    /// Coordinates.
    pub positions: Bulk<P>,
    /// The rank that owns the point.
    pub owners: Bulk<Rank>,
    /// Squared radius of the ball.
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
    /// Creates a batch of points in transit to their owners.
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

    /// Moves the points of another batch to the end of this one.
    pub fn append(&mut self, other: &mut Self) {
        self.ids.append(&mut other.ids);
        self.positions.append(&mut other.positions);
        self.owners.append(&mut other.owners);
        self.radii2.append(&mut other.radii2);
    }

    /// Splits off the points from index `at` to the end. All columns with an entry per point are split.
    ///
    /// # Panics
    /// Panics if there are fewer than `at` points.
    #[must_use]
    pub fn split_off(&mut self, at: usize) -> Self {
        if at == 0 {
            return std::mem::take(self);
        }
        let (owners, radii2) = (at.min(self.owners.len()), at.min(self.radii2.len()));
        PointBatch {
            ids: Bulk(self.ids.split_off(at)),
            positions: Bulk(self.positions.split_off(at)),
            owners: Bulk(self.owners.split_off(owners)),
            radii2: Bulk(self.radii2.split_off(radii2)),
        }
    }

    /// Removes the points whose flag is not set.
    ///
    /// # Panics
    /// Panics if a column has an entry for each point, and the number of flags is another.
    pub fn keep(&mut self, flags: &[bool]) {
        fn keep<T>(column: &mut Vec<T>, flags: &[bool]) {
            let mut at = 0..column.len();
            column.retain(|_| at.next().is_some_and(|i| flags[i]));
        }
        keep(&mut self.ids.0, flags);
        keep(&mut self.positions.0, flags);
        keep(&mut self.owners.0, flags);
        keep(&mut self.radii2.0, flags);
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Returns `true` if the batch is empty.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Returns `true` if all columns have one entry per point.
    pub fn is_consistent(&self) -> bool {
        let n = self.len();
        self.positions.len() == n && self.owners.len() == n && self.radii2.len() == n
    }
}

/// Lists of points, one per slot: neighbours that another rank found.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct ListBatch<P> {
    /// The receiver's slot of each list.
    pub slots: Bulk<u32>,
    /// Length of each list.
    pub counts: Bulk<u32>,
    /// All lists, one after the other.
    pub points: PointBatch<P>,
}

/// The summary of a subproblem: its owned points and their balls.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct Summary<P> {
    /// Largest squared radius of an owned point's ball.
    pub max_radius2: f64,
    /// The lexicographically smallest owned point (one entry).
    pub smallest: PointBatch<P>,
}

/// The flag of a star that splaying changed, in [`ViewPart::flags`].
pub const SHOWN_REPAIRED: u64 = 1;
/// The flag of a star whose circumspheres all lie in the known ball around its vertex, in [`ViewPart::flags`].
pub const SHOWN_LOCAL: u64 = 2;

/// The radius that marks a gathered point whose star is unresolved ([`Body::Gather`]).
pub const WANTED: f64 = 1.0;
/// The radius that marks a gathered point that only the links of other stars contain.
pub const OF_A_LINK: f64 = 0.0;

/// Returns `true` if the radius marks a gathered point whose star is unresolved.
pub fn is_wanted(radius: f64) -> bool {
    radius > OF_A_LINK
}

/// The squared radius of a ball that is not known. The ball reaches every point.
pub const UNKNOWN_RADIUS2: f64 = f64::INFINITY;

/// The part of a worker in the picture: sampled points, one entry each, and the splits that the worker reports.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct ViewPart<P> {
    /// Sampled owned points.
    pub points: PointBatch<P>,
    /// The leaf of each sampled point.
    pub leaves: Bulk<u64>,
    /// Bit `l` is set if the point's ball meets the separator of its leaf's ancestor at level `l`.
    pub crossing: Bulk<u64>,
    /// The flags [`SHOWN_REPAIRED`] and [`SHOWN_LOCAL`].
    pub flags: Bulk<u64>,
    /// Ids of sampled points that are ghosts of a leaf of the worker.
    pub ghosts: Bulk<u64>,
    /// The leaf of each ghost.
    pub ghost_leaves: Bulk<u64>,
    /// Nodes that are split.
    pub nodes: Bulk<u64>,
    /// The separators of the nodes, 9 numbers each (`Separator::to_array`).
    pub separators: Bulk<f64>,
    /// Low and high corners of the boxes of the nodes' owned points.
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
    /// Returns `true` if the lengths of the columns are consistent.
    pub fn is_consistent(&self) -> bool {
        let (n, m) = (self.points.len(), self.nodes.len());
        self.points.is_consistent()
            && [self.leaves.len(), self.crossing.len(), self.flags.len()] == [n; 3]
            && self.ghosts.len() == self.ghost_leaves.len()
            && self.separators.len() == 9 * m
            && self.boxes.len() == 2 * m
    }
}

/// The body of a message.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub enum Body<P> {
    /// Up and down the tree of all ranks: the survey of the rows below, then of all rows.
    Survey(Survey),
    /// Worker to the home of hashes: the hashes of the coordinates of its rows.
    Keys(Bulk<u64>),
    /// Home of hashes to worker: the positions in `Keys` of the hashes that other rows share.
    Alike(Bulk<u32>),
    /// Worker to the home of hashes: the points at these positions.
    Candidates(PointBatch<P>),
    /// Home of hashes to worker: the points that repeat an earlier row.
    Repeated {
        /// Their positions in `Keys`.
        keys: Bulk<u32>,
        /// For each, the first row with the same coordinates.
        first: Bulk<u64>,
    },
    /// Up and down the tree of all ranks: the points of the ranks below, then of all ranks, and a frame that spans them.
    Start {
        /// Distinct points.
        population: PointSum,
        /// At most `d + 1` affinely independent points.
        frame: PointBatch<P>,
    },
    /// Leader to the leader of a child: the plan of the placement, as numbers of leaves below nodes.
    Plan {
        /// Nodes.
        nodes: Bulk<u64>,
        /// Leaves below each.
        leaves: Bulk<u32>,
    },
    /// Member to leader, through the tree of the group: samples of the subproblem.
    Samples(Bulk<P>),
    /// Leader to member, through the tree of the group: the separator. Empty if none was found.
    Sphere(Bulk<f64>),
    /// Member to leader: the numbers of owned points inside and outside, and their boxes. A box is its low and high
    /// corner; the interior box comes first.
    Counts {
        /// Interior points.
        inside: u64,
        /// Exterior points.
        outside: u64,
        /// Four corners.
        boxes: Bulk<P>,
    },
    /// Leader to member: the decision on the attempt, with the boxes of both children.
    Decision {
        /// The decision.
        decision: Decision,
        /// Four corners, as in `Counts`; empty unless split.
        boxes: Bulk<P>,
        /// The member's routes to both children; empty unless split.
        routes: Box<[Route; 2]>,
    },
    /// Member to member: points that move to a child, through a tree if one rank takes the child of a large group.
    Move(PointBatch<P>),
    /// Queries of balls for points below this node.
    Query(QueryBatch<P>),
    /// Replies to queries.
    Reply(ReplyBatch<P>),
    /// Leader to the leader of the parent: the summary of the subproblem.
    Summary(Summary<P>),
    /// Leader to member, through the tree of the group: the summaries of both children.
    Children(Box<[Summary<P>; 2]>),
    /// Worker to coordinator, then coordinator to all ranks, through a tree: the points of the frame with their owners.
    Frame(PointBatch<P>),
    /// Worker to coordinator: the counts of its sampled stars.
    SampleStars(SampleStars),
    /// Coordinator to all ranks, through a tree: the chosen supergraph.
    Choice(ChosenSupergraph),
    /// Ghosts for a subproblem that their balls reach.
    Ghosts(PointBatch<P>),
    /// Member of a child's group to a member of the other child's group: the splits of the shared nodes below the child.
    Splits(SplitBatch<P>),
    /// Worker to worker: points of the sender that the receiver keeps as ghosts. They have no owners and no balls.
    Copies(PointBatch<P>),
    /// Points with nearest neighbours that the receiver owns. These neighbours are the other ends of edges.
    Reverse {
        /// The points, without duplicates.
        points: PointBatch<P>,
        /// For each point, the number of its neighbours that the receiver owns.
        counts: Bulk<u32>,
        /// The ids of these neighbours, point by point.
        targets: Bulk<u64>,
    },
    /// Members of a subproblem's set (owned and separator points).
    Items {
        /// The points.
        points: PointBatch<P>,
        /// The sender's slot of each member.
        slots: Bulk<u32>,
    },
    /// Member to leader, through the tree of the group: counts of the set.
    SetCounts(SetCounts),
    /// Leader to member, through the tree of the group: the decision on the set.
    SetDecision(SetDecision),
    /// Member to leader, through the tree of the group: what its branch knows of a node whose balls are corrected. Then from
    /// the leader to all members: what the group knows.
    Crossings(Crossings),
    /// Neighbours that another rank found.
    Lists(ListBatch<P>),
    /// The order-free fingerprint of the cells that two workers share.
    Fingerprint(Fingerprint),
    /// The key of each pair of a shared cell and a vertex.
    FingerprintList(Bulk<u64>),
    /// Proposals: cells in the star of one vertex, for the star of another.
    Propose {
        /// The points of the cells.
        points: PointBatch<P>,
        /// Positions in `points`, `d + 1` per cell: the vertex of the sender, the vertex of the receiver, the others.
        cells: Bulk<u32>,
    },
    /// Objections: cells that are not Delaunay, for stars that may hold them, with points in their circumspheres.
    Object {
        /// The points of the cells and conflicts.
        points: PointBatch<P>,
        /// Positions in `points`, `d + 1` per cell: the vertex of the sender, the vertex of the receiver, the others.
        cells: Bulk<u32>,
        /// Number of points in conflict with each cell.
        counts: Bulk<u32>,
        /// Positions in `points` of the points in conflict.
        conflicts: Bulk<u32>,
    },
    /// Owner to the owners of neighbours: points that joined the independent set.
    Joined(Bulk<u64>),
    /// Owner to the owners of neighbours: points that are excluded from the independent set.
    Left(Bulk<u64>),
    /// Leader to the leader of the parent: the merged result of the subproblem.
    Merged(Merged),
    /// Coordinator to all ranks, through a tree: the decision on a certificate.
    Outcome(Outcome),
    /// Worker to coordinator: the vertices of unresolved stars and of their links. The radius of a point marks its role
    /// ([`WANTED`], [`OF_A_LINK`]).
    Gather(PointBatch<P>),
    /// Coordinator to worker: points to add to stars.
    Region {
        /// Ids of the vertices.
        vertices: Bulk<u64>,
        /// Number of points to add to the star of each vertex.
        counts: Bulk<u32>,
        /// All points.
        points: PointBatch<P>,
    },
    /// A facet of a cell whose neighbour may be on another rank, to the owner of the facet's smallest vertex.
    Facets {
        /// `d` ids per facet, ascending.
        vertices: Bulk<u64>,
        /// The entry of each facet in the rows of the sender.
        entries: Bulk<u32>,
    },
    /// The cells across facets, to a rank that sent the facets.
    Across {
        /// The entry of each facet in the rows of the receiver.
        entries: Bulk<u32>,
        /// The rank of the other cell; that of the receiver for a facet on the hull.
        ranks: Bulk<Rank>,
        /// The other cell; `u32::MAX` for a facet on the hull.
        cells: Bulk<u32>,
    },
    /// Member to the member above it in the tree of a large group: `Counts` of the sender and of all members below it.
    BranchCounts {
        /// Interior points of each of these members.
        inside: Bulk<u64>,
        /// Exterior points of each of these members.
        outside: Bulk<u64>,
        /// Four corners of all points of these members, as in `Counts`.
        boxes: Bulk<P>,
    },
    /// Member to a member below it in the tree of a large group: `Decision` for the receiver and all members below it.
    BranchDecision {
        /// The decision.
        decision: Decision,
        /// Four corners, as in `Decision`.
        boxes: Bulk<P>,
        /// The routes of each of these members to both children; empty unless split.
        routes: RouteBatch,
    },
    /// Up and down the tree of all ranks: the totals of the ranks below, then of all ranks.
    Totals(Box<Totals>),
    /// Worker to worker: items of an evaluation that the receiver evaluates on the next level.
    WorkItems {
        /// The number of words of each item.
        lengths: Bulk<u32>,
        /// The words of all items.
        words: Bulk<u64>,
    },
    /// Up and down the tree of all ranks: for each rank below, then for each rank, the number of results of a level and the
    /// number of items of the next level.
    WorkCounts(Bulk<u64>),
    /// Up and down the tree of all ranks, if points have weights: the sites of the ranks below, then of all ranks.
    Sites(SiteTotals),
}

impl<P: Copy> Body<P> {
    /// Returns `true` if the arrays of a query or a reply are consistent. Other bodies are not checked here.
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
