//! What a worker knows of the partition tree: the shared nodes from the root down to its own piece, and
//! the subtree of that piece. Nobody holds the whole tree.

use std::cmp::Ordering;
use std::ops::Range;

use septet_geometry::neighbourhood::box_dist2;
pub use septet_geometry::neighbourhood::{Bounds, bounds, join_bounds};
use septet_geometry::point::Point;
use septet_geometry::separator::{Separator, Side};
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Child, Summary};

pub use crate::machine::collectives::Group;

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

/// A child of a shared node, as the place where something leaves a rank's path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Way {
    /// The position of the node on the path.
    pub(crate) level: usize,
    /// The child.
    pub(crate) side: usize,
}

/// Where a message about a node goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entry {
    /// At the rank that holds the node, which its group could not split.
    Relay(Rank),
    /// Here: at this position of the path, or below the path where that is its end.
    Here(usize),
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
}

impl<P> Leaf<P> {
    /// Its home points.
    pub fn owned(&self) -> std::ops::Range<u32> {
        self.start..self.end
    }

    /// Number of its home points.
    pub(crate) fn owned_len(&self) -> u64 {
        u64::from(self.end - self.start)
    }
}

/// Of each leaf, the points of others that the graph can join to its home points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ghosts(Vec<Vec<u32>>);

impl Ghosts {
    /// None yet, for so many leaves.
    pub(crate) fn of_leaves(leaves: usize) -> Self {
        Ghosts(vec![Vec::new(); leaves])
    }

    /// Those of a leaf, by its position among the rank's leaves.
    pub(crate) fn of(&self, leaf: usize) -> &[u32] {
        self.0.get(leaf).map_or(&[], Vec::as_slice)
    }

    /// Adds one to a leaf.
    pub(crate) fn push(&mut self, leaf: usize, ghost: u32) {
        self.0[leaf].push(ghost);
    }

    /// Adds some to the first leaf, of a rank that has one at most.
    pub(crate) fn add_to_first(&mut self, ghosts: Vec<u32>) {
        match self.0.first_mut() {
            Some(first) => first.extend(ghosts),
            None => self.0.push(ghosts),
        }
    }

    /// Brings those of each leaf into an order in which equal ones are neighbours, and keeps each once.
    pub(crate) fn sort_by(&mut self, mut order: impl FnMut(&u32, &u32) -> Ordering) {
        for ghosts in &mut self.0 {
            ghosts.sort_unstable_by(&mut order);
            ghosts.dedup();
        }
    }

    /// The home points of a leaf, then its ghosts.
    pub(crate) fn members<P>(&self, at: usize, leaf: &Leaf<P>) -> Vec<u32> {
        leaf.owned().chain(self.of(at).iter().copied()).collect()
    }
}

/// Home points of one leaf that are scanned together.
pub(crate) const GROUP: usize = 4096;

/// Position of a leaf, and some of its home points.
pub(crate) fn owned_groups<P>(leaves: &[Leaf<P>]) -> Vec<(usize, Range<u32>)> {
    let mut groups = Vec::new();
    for (at, leaf) in leaves.iter().enumerate() {
        for start in leaf.owned().step_by(GROUP) {
            groups.push((at, start..leaf.end.min(start + GROUP as u32)));
        }
    }
    groups
}

/// The position of a home point's leaf.
pub(crate) fn leaf_number<P>(leaves: &[Leaf<P>], owned: u32) -> u32 {
    leaves.partition_point(|leaf| leaf.end <= owned) as u32
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

    /// The position of a node on the path, or its end.
    pub(crate) fn position(&self, node: NodeId) -> usize {
        self.path.iter().position(|shared| shared.id == node).unwrap_or(self.path.len())
    }

    /// The shared node on the path that has this id.
    pub(crate) fn shared(&self, node: NodeId) -> Option<&Shared<P>> {
        self.path.iter().find(|shared| shared.id == node)
    }

    /// Where something that was sent to a node goes on.
    pub(crate) fn entry(&self, node: NodeId, own: Rank) -> Entry {
        self.relayed(node, own).map_or_else(|| Entry::Here(self.position(node)), Entry::Relay)
    }

    /// Follows the path from a position on it with something that goes down the tree. `reach` says which children of
    /// a node it reaches; `leave` gets each place where it leaves the path. Returns whether it reaches this rank's own
    /// tree.
    pub(crate) fn follow(
        &self,
        start: usize,
        mut reach: impl FnMut(usize, &Shared<P>) -> [bool; 2],
        mut leave: impl FnMut(Way),
    ) -> bool {
        for (level, shared) in self.path.iter().enumerate().skip(start) {
            let reached = reach(level, shared);
            let goes_on = reached[shared.mine] && shared.goes_on;
            for side in (0..2).filter(|&side| reached[side] && (side != shared.mine || !goes_on)) {
                leave(Way { level, side });
            }
            if !goes_on {
                return false;
            }
        }
        true
    }

    /// The rank and the node to which something goes that leaves the path.
    pub(crate) fn beyond(&self, way: Way, own: Rank) -> (NodeId, Rank) {
        let shared = &self.path[way.level];
        (shared.id.child(way.side), shared.member_below(own, way.side))
    }

    /// The position of each home point's leaf.
    pub(crate) fn leaf_numbers(&self) -> Vec<u32> {
        let mut leaf_of = Vec::with_capacity(self.leaves.last().map_or(0, |leaf| leaf.end as usize));
        for (at, leaf) in (0u32..).zip(&self.leaves) {
            leaf_of.extend(leaf.owned().map(|_| at));
        }
        leaf_of
    }
}
