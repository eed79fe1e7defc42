//! The partition tree below the path: splits, inner nodes and leaves.

use std::cmp::Ordering;
use std::ops::Range;

use septet_geometry::neighbourhood::box_dist2;
pub use septet_geometry::neighbourhood::{Bounds, bounds, join_bounds};
use septet_geometry::point::Point;
use septet_geometry::separator::{Separator, Side};
use septet_protocol::ids::NodeId;
use septet_protocol::message::UNKNOWN_RADIUS2;

/// The split of a node: its separator, and the boxes of its children's owned points.
#[derive(Clone, Debug)]
pub struct Split<P> {
    separator: Separator<P>,
    /// The boxes of the interior and the exterior child's owned points.
    boxes: [Bounds<P>; 2],
}

impl<P: Point> Split<P> {
    /// Creates a split from a separator and the boxes of the interior and the exterior child.
    pub(crate) fn new(separator: Separator<P>, boxes: [Bounds<P>; 2]) -> Self {
        Split { separator, boxes }
    }

    /// Returns the separating surface.
    #[inline]
    pub fn separator(&self) -> &Separator<P> {
        &self.separator
    }

    /// Returns the boxes of the interior and the exterior child's owned points.
    #[inline]
    pub fn boxes(&self) -> &[Bounds<P>; 2] {
        &self.boxes
    }

    /// Returns the side of `x`: 0 is interior, 1 is exterior.
    #[inline]
    pub fn side(&self, x: P) -> usize {
        usize::from(self.separator.side(x) == Side::Exterior)
    }

    /// Returns the child whose box is nearest to `x`, or the side of `x` if both are equally near.
    #[inline]
    pub fn nearest(&self, x: P) -> usize {
        let [inside, outside] = self.boxes.map(|(low, high)| box_dist2(x, low, high));
        match inside.total_cmp(&outside) {
            Ordering::Less => 0,
            Ordering::Greater => 1,
            Ordering::Equal => self.side(x),
        }
    }

    /// Returns `true` if a ball around `x` of squared radius `r2` may contain an owned point of the child on `side`.
    /// Rounding may only turn `false` into `true`.
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

/// A node of a rank's own subtree.
#[derive(Clone, Debug)]
pub enum Tree<P> {
    /// A leaf, by its index among the leaves of the subtree.
    Leaf(usize),
    /// An inner node.
    Node(Box<Inner<P>>),
}

/// An inner node of a rank's own subtree.
#[derive(Clone, Debug)]
pub struct Inner<P> {
    id: NodeId,
    /// Its index among the inner nodes of the subtree, in preorder.
    number: usize,
    split: Split<P>,
    /// The interior and the exterior child.
    children: [Tree<P>; 2],
    /// The largest squared radius of each child's owned points, infinite before the phase `summaries`.
    max_radius2: [f64; 2],
    /// The lexicographically smallest owned point of each child, 0 before the phase `summaries`.
    smallest: [u32; 2],
}

impl<P> Inner<P> {
    /// Creates an inner node with the index `number` in preorder.
    pub(crate) fn new(id: NodeId, number: usize, split: Split<P>, children: [Tree<P>; 2]) -> Self {
        Inner { id, number, split, children, max_radius2: [UNKNOWN_RADIUS2; 2], smallest: [0; 2] }
    }

    /// Its id in the partition tree.
    #[inline]
    pub fn id(&self) -> NodeId {
        self.id
    }

    /// Its index among the inner nodes of the subtree, in preorder.
    #[inline]
    pub fn number(&self) -> usize {
        self.number
    }

    /// Its split.
    #[inline]
    pub fn split(&self) -> &Split<P> {
        &self.split
    }

    /// Returns the interior and the exterior child.
    #[inline]
    pub fn children(&self) -> &[Tree<P>; 2] {
        &self.children
    }

    /// Returns the children, for the phase that summarises them.
    pub(crate) fn children_mut(&mut self) -> &mut [Tree<P>; 2] {
        &mut self.children
    }

    /// Returns the largest squared radius of each child's owned points, which is infinite before the phase
    /// `summaries`.
    #[inline]
    pub fn max_radius2(&self) -> [f64; 2] {
        self.max_radius2
    }

    /// Returns the lexicographically smallest owned point of each child, which is meaningless before the phase
    /// `summaries`.
    #[inline]
    pub fn smallest(&self) -> [u32; 2] {
        self.smallest
    }

    /// Stores the largest squared radius and the smallest owned point of a child.
    pub(crate) fn set_summary(&mut self, side: usize, max_radius2: f64, smallest: u32) {
        self.max_radius2[side] = max_radius2;
        self.smallest[side] = smallest;
    }
}

/// A leaf of the partition tree. One rank owns all its points, and numbers them consecutively.
#[derive(Clone, Debug)]
pub struct Leaf<P> {
    id: NodeId,
    owned: Range<u32>,
    bounds: Bounds<P>,
    /// The largest squared radius of an owned point, 0 before the phase `summaries`.
    max_radius2: f64,
}

impl<P: Copy> Leaf<P> {
    /// Creates a leaf with these owned points and their box.
    pub(crate) fn new(id: NodeId, owned: Range<u32>, bounds: Bounds<P>) -> Self {
        Leaf { id, owned, bounds, max_radius2: 0.0 }
    }

    /// Returns the box of its owned points.
    #[inline]
    pub fn bounds(&self) -> Bounds<P> {
        self.bounds
    }
}

impl<P> Leaf<P> {
    /// Its id in the partition tree.
    #[inline]
    pub fn id(&self) -> NodeId {
        self.id
    }

    /// Its owned points.
    #[inline]
    pub fn owned(&self) -> Range<u32> {
        self.owned.clone()
    }

    /// Its first owned point.
    #[inline]
    pub fn start(&self) -> u32 {
        self.owned.start
    }

    /// Its owned points, as indices into the columns of the table.
    #[inline]
    pub(crate) fn indices(&self) -> Range<usize> {
        self.owned.start as usize..self.owned.end as usize
    }

    /// Returns the number of its owned points.
    #[inline]
    pub(crate) fn owned_len(&self) -> u64 {
        u64::from(self.owned.end - self.owned.start)
    }

    /// Returns the largest squared radius of an owned point, which is 0 before the phase `summaries`.
    pub fn max_radius2(&self) -> f64 {
        self.max_radius2
    }

    /// Stores the largest squared radius of its owned points.
    pub(crate) fn set_max_radius2(&mut self, max_radius2: f64) {
        self.max_radius2 = max_radius2;
    }
}

/// The number of owned points of a leaf that one task scans.
pub(crate) const GROUP: usize = 4096;

/// Divides the owned points of all leaves into groups of at most [`GROUP`], each with the index of its leaf.
pub(crate) fn owned_groups<P>(leaves: &[Leaf<P>]) -> Vec<(usize, Range<u32>)> {
    let mut groups = Vec::new();
    for (at, leaf) in leaves.iter().enumerate() {
        for start in leaf.owned().step_by(GROUP) {
            groups.push((at, start..leaf.owned.end.min(start + GROUP as u32)));
        }
    }
    groups
}

/// Returns the index of the leaf that contains the owned point `point`.
pub(crate) fn leaf_number<P>(leaves: &[Leaf<P>], point: u32) -> u32 {
    leaves.partition_point(|leaf| leaf.owned.end <= point) as u32
}
