//! What a worker knows of the partition tree: the shared nodes from the root down to its own piece, and
//! the subtree of that piece. Nobody holds the whole tree.

use std::ops::Range;

use septet_geometry::neighbourhood::box_dist2;
pub use septet_geometry::neighbourhood::{Bounds, bounds, join_bounds};
use septet_geometry::point::Point;
use septet_geometry::separator::{Separator, Side};
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Child, Summary};

/// A split: the separator and the boxes of both children's home points.
#[derive(Clone, Debug)]
pub struct Split<P> {
    /// The surface.
    pub separator: Separator<P>,
    /// Interior and exterior child's box.
    pub boxes: [Bounds<P>; 2],
}

impl<P: Point> Split<P> {
    /// 0 interior, 1 exterior.
    #[inline]
    pub fn side(&self, x: P) -> usize {
        usize::from(self.separator.side(x) == Side::Exterior)
    }

    /// Can a ball around `x`, of squared radius `r2`, hold a home point of that child?
    #[inline]
    pub fn reaches(&self, x: P, r2: f64, side: usize) -> bool {
        let (low, high) = self.boxes[side];
        if box_dist2(x, low, high) > r2 {
            return false;
        }
        let wanted = if side == 0 { Side::Interior } else { Side::Exterior };
        self.separator.reaches(x, r2.sqrt() * (1.0 + 1e-12), wanted)
    }
}

/// A node shared by a group of workers, as each of them knows it.
#[derive(Clone, Debug)]
pub struct Shared<P> {
    /// Which.
    pub id: NodeId,
    /// First rank of the group.
    pub first: Rank,
    /// Number of ranks in it.
    pub ranks: u32,
    /// Who leads it: its lowest rank, or the coordinator for the root.
    pub leader: Rank,
    /// How it was split.
    pub split: Split<P>,
    /// The children's groups.
    pub children: [Child; 2],
    /// The child whose group this worker belongs to.
    pub mine: usize,
    /// Does this worker go on with that child? Not if it is a leaf that another rank holds.
    pub goes_on: bool,
    /// What the children hold, once known.
    pub summaries: Option<Box<[Summary<P>; 2]>>,
}

impl<P> Shared<P> {
    /// The member of a child's group that takes what member `rank` of this group sends down: the one at
    /// the same relative place, or the holder of a leaf.
    pub fn member_below(&self, rank: Rank, side: usize) -> Rank {
        let child = &self.children[side];
        if child.leaf {
            return child.first;
        }
        let place = u64::from(rank - self.first) * u64::from(child.ranks) / u64::from(self.ranks);
        child.first + place as u32
    }
}

/// A node of a worker's own subtree.
#[derive(Clone, Debug)]
pub enum Tree<P> {
    /// A leaf, by its position among the worker's leaves.
    Leaf(usize),
    /// An inner node.
    Node(Box<Inner<P>>),
}

/// An inner node of a worker's own subtree.
#[derive(Clone, Debug)]
pub struct Inner<P> {
    /// Which.
    pub id: NodeId,
    /// Its position among the inner nodes of the subtree, in preorder.
    pub number: usize,
    /// How it is split.
    pub split: Split<P>,
    /// Interior and exterior child.
    pub children: [Tree<P>; 2],
    /// Largest squared radius of each child's home points, once known.
    pub max_radius2: [f64; 2],
    /// Local number of each child's lexicographically smallest home point, once known.
    pub smallest: [u32; 2],
}

/// A leaf of the partition tree, held by one worker.
#[derive(Clone, Debug)]
pub struct Leaf<P> {
    /// Which.
    pub id: NodeId,
    /// First home point.
    pub start: u32,
    /// One past the last.
    pub end: u32,
    /// Box of the home points.
    pub bounds: Bounds<P>,
    /// Largest squared radius of a home point, once known.
    pub max_radius2: f64,
    /// Foreign and other leaves' points that the graph can join to home points.
    pub ghosts: Vec<u32>,
}

impl<P> Leaf<P> {
    /// Its home points.
    pub fn home(&self) -> std::ops::Range<u32> {
        self.start..self.end
    }

    /// Number of its home points.
    pub(crate) fn home_len(&self) -> u64 {
        u64::from(self.end - self.start)
    }
}

/// The position of a home point's leaf.
pub(crate) fn leaf_number<P>(leaves: &[Leaf<P>], home: u32) -> u32 {
    leaves.partition_point(|leaf| leaf.end <= home) as u32
}

/// Where a rank is in the tree, and what is at home there.
#[derive(Debug)]
pub(crate) struct Subdomain<P> {
    /// Shared nodes from the root down.
    pub(crate) path: Vec<Shared<P>>,
    /// The shared node below them that its group could not split, and the rank that holds it.
    pub(crate) relay: Option<(NodeId, Rank)>,
    /// The tree below.
    pub(crate) tree: Option<(NodeId, Tree<P>)>,
    /// The inner nodes below.
    pub(crate) inner_ids: Vec<NodeId>,
    /// The leaves below.
    pub(crate) leaves: Vec<Leaf<P>>,
    /// The shared nodes that this rank leads.
    pub(crate) led: Vec<Group>,
}

impl<P> Default for Subdomain<P> {
    fn default() -> Self {
        let (path, inner_ids, leaves, led) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Subdomain { path, relay: None, tree: None, inner_ids, leaves, led }
    }
}

impl<P> Subdomain<P> {
    /// The rank that holds a node which this rank is asked for, if it is another.
    pub(crate) fn relayed(&self, node: NodeId, own: Rank) -> Option<Rank> {
        self.relay.filter(|&(at, holder)| at == node && holder != own).map(|(_, holder)| holder)
    }

    /// The node that this rank holds; the root if it holds none.
    pub(crate) fn root(&self) -> NodeId {
        self.tree.as_ref().map_or(NodeId::ROOT, |tree| tree.0)
    }

    /// Adds ghosts to the first leaf: of a rank that holds its piece as one leaf.
    pub(crate) fn note_ghosts(&mut self, ghosts: Vec<u32>) {
        if let Some(leaf) = self.leaves.first_mut() {
            leaf.ghosts.extend(ghosts);
        }
    }

    /// The position of a node on the path, or its end.
    pub(crate) fn position(&self, node: NodeId) -> usize {
        self.path.iter().position(|shared| shared.id == node).unwrap_or(self.path.len())
    }
}

/// A node, and the group of ranks that has it.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// The node.
    pub node: NodeId,
    /// Who leads the group.
    pub leader: Rank,
    /// Its ranks and points.
    pub child: Child,
}

impl Group {
    /// That of a child. Its lowest rank leads it.
    pub(crate) fn below(self, side: usize, child: Child) -> Self {
        Group { node: self.node.child(side), leader: child.first, child }
    }

    /// Does one rank take it whole?
    pub(crate) fn is_whole(&self) -> bool {
        self.child.ranks == 1 || self.child.leaf
    }

    pub(crate) fn members(&self) -> Range<Rank> {
        self.child.first..self.child.first + self.child.ranks
    }
}
