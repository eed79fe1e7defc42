//! The part of the partition tree that a rank holds: its path and its own subtree.
//!
//! The *path* consists of the shared nodes from the root down to the rank's own subtree. A node is *shared* if a group of
//! several ranks holds its points. No rank holds the whole tree, but in `triangulate`, every worker knows the splits of all
//! shared nodes (`crate::direct::regions`).

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, Child, Summary};

use crate::machine::context::Context;
pub use crate::machine::group::Group;
use crate::state::tree::{Leaf, Split, Tree};

/// A shared node on the path of a rank.
#[derive(Clone, Debug)]
pub struct Shared<P> {
    group: Group,
    split: Split<P>,
    /// The groups of the interior and the exterior child.
    children: [Child; 2],
    /// The child whose group contains this rank: 0 is interior, 1 is exterior.
    mine: usize,
    /// Whether this rank continues with the child `mine`. `false` if the child is a leaf that another rank holds.
    goes_on: bool,
    /// The summaries of the children, or `None` before the phase `summaries`.
    summaries: Option<Box<[Summary<P>; 2]>>,
}

impl<P> Shared<P> {
    /// Creates the shared node of `group` on the path of `rank`, which belongs to the group of the child `mine`.
    pub(crate) fn new(group: Group, split: Split<P>, children: [Child; 2], mine: usize, rank: Rank) -> Self {
        let goes_on = !children[mine].leaf || children[mine].first == rank;
        Shared { group, split, children, mine, goes_on, summaries: None }
    }

    /// Its id in the partition tree.
    #[inline]
    pub fn id(&self) -> NodeId {
        self.group.node
    }

    /// Returns its group.
    pub fn group(&self) -> &Group {
        &self.group
    }

    /// Returns the first rank of its group.
    pub fn first(&self) -> Rank {
        self.group.child.first
    }

    /// Its split.
    #[inline]
    pub fn split(&self) -> &Split<P> {
        &self.split
    }

    /// Returns the groups of the interior and the exterior child.
    pub fn children(&self) -> &[Child; 2] {
        &self.children
    }

    /// Returns the child whose group contains this rank: 0 is interior, 1 is exterior.
    #[inline]
    pub fn mine(&self) -> usize {
        self.mine
    }

    /// Returns the summaries of the children, or `None` before the phase `summaries`.
    #[inline]
    pub fn summaries(&self) -> Option<&[Summary<P>; 2]> {
        self.summaries.as_deref()
    }

    /// Records that this rank's child could not be split, so that the first rank of the child's group holds all of
    /// it.
    pub(crate) fn end_in_leaf(&mut self, rank: Rank) {
        self.children[self.mine].leaf = true;
        self.goes_on = self.children[self.mine].first == rank;
    }

    /// Follows an item that reaches these children by one step. Calls `leave` with every child at which it leaves the path.
    /// Returns `true` if it also continues with this rank's child.
    #[inline]
    pub(crate) fn follow(&self, reached: [bool; 2], leave: impl FnMut(usize)) -> bool {
        let continues = reached[self.mine] && self.goes_on;
        (0..2).filter(|&side| reached[side] && (side != self.mine || !continues)).for_each(leave);
        continues
    }

    /// Returns the member of a child's group to which member `rank` of this group sends: the member at the same
    /// relative position, or the holder if one rank holds the whole child.
    pub fn member_below(&self, rank: Rank, side: usize) -> Rank {
        let child = &self.children[side];
        if child.leaf {
            return child.first;
        }
        let Child { first, ranks, .. } = self.group.child;
        let position = u64::from(rank - first) * u64::from(child.ranks) / u64::from(ranks);
        child.first + position as u32
    }
}

/// A child of a node on the path, at which an item leaves the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Way {
    /// The position of the node on the path.
    pub(crate) level: usize,
    /// The child: 0 is interior, 1 is exterior.
    pub(crate) side: usize,
}

/// The place at which a rank continues with an item that was sent to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entry {
    /// On another rank, which holds the node because its group could not split it.
    Relay(Rank),
    /// On this rank, from this position of the path. The length of the path denotes this rank's subtree.
    Here(usize),
}

/// A shared node that its group could not split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unsplit {
    pub(crate) node: NodeId,
    /// The rank that holds the whole node.
    pub(crate) holder: Rank,
}

/// The subtree that one rank holds.
#[derive(Debug)]
pub(crate) struct Subtree<P> {
    root: NodeId,
    tree: Tree<P>,
    /// The ids of the inner nodes, in preorder.
    inner_ids: Vec<NodeId>,
    /// The leaves, in the order of the tree.
    leaves: Vec<Leaf<P>>,
}

impl<P> Subtree<P> {
    /// Creates a subtree from its nodes. The ids of inner nodes are in preorder and the leaves in the order of the tree.
    pub(crate) fn new(root: NodeId, tree: Tree<P>, inner_ids: Vec<NodeId>, leaves: Vec<Leaf<P>>) -> Self {
        Subtree { root, tree, inner_ids, leaves }
    }

    /// Creates a subtree that consists of one leaf.
    pub(crate) fn of_leaf(leaf: Leaf<P>) -> Self {
        Subtree { root: leaf.id(), tree: Tree::Leaf(0), inner_ids: Vec::new(), leaves: vec![leaf] }
    }
}

/// The part of the partition tree that a rank holds.
#[derive(Debug)]
pub(crate) struct Subdomain<P> {
    /// The shared nodes, from the root down.
    path: Vec<Shared<P>>,
    /// Returns the node at the end of the path, if its group could not split it.
    unsplit: Option<Unsplit>,
    /// `None` on a rank without points.
    subtree: Option<Subtree<P>>,
    /// The shared nodes that this rank leads.
    led: Vec<Group>,
}

impl<P> Default for Subdomain<P> {
    fn default() -> Self {
        Subdomain::new(Vec::new(), None, None, Vec::new())
    }
}

impl<P> Subdomain<P> {
    /// Creates a subdomain from the path, its unsplit end if any, this rank's subtree and the shared nodes that the
    /// rank leads.
    pub(crate) fn new(
        path: Vec<Shared<P>>,
        unsplit: Option<Unsplit>,
        subtree: Option<Subtree<P>>,
        led: Vec<Group>,
    ) -> Self {
        Subdomain { path, unsplit, subtree, led }
    }

    /// Returns the shared nodes, from the root down.
    #[inline]
    pub(crate) fn path(&self) -> &[Shared<P>] {
        &self.path
    }

    /// Returns the groups of the shared nodes, from the root down.
    pub(crate) fn groups(&self) -> impl Iterator<Item = &Group> {
        self.path.iter().map(Shared::group)
    }

    /// The node at the end of the path, if its group could not split it.
    pub(crate) fn unsplit(&self) -> Option<Unsplit> {
        self.unsplit
    }

    /// Returns the root of this rank's subtree, or `None` on a rank without points.
    #[inline]
    pub(crate) fn tree(&self) -> Option<&Tree<P>> {
        self.subtree.as_ref().map(|subtree| &subtree.tree)
    }

    /// Returns the root of this rank's subtree and its leaves, for the phase that summarises them.
    pub(crate) fn tree_mut(&mut self) -> Option<(&mut Tree<P>, &mut [Leaf<P>])> {
        self.subtree.as_mut().map(|Subtree { tree, leaves, .. }| (tree, leaves.as_mut_slice()))
    }

    /// Returns the ids of the inner nodes of this rank's subtree, in preorder.
    pub(crate) fn inner_ids(&self) -> &[NodeId] {
        self.subtree.as_ref().map_or(&[], |subtree| &subtree.inner_ids)
    }

    /// Returns the leaves of this rank's subtree, in the order of the tree.
    #[inline]
    pub(crate) fn leaves(&self) -> &[Leaf<P>] {
        self.subtree.as_ref().map_or(&[], |subtree| &subtree.leaves)
    }

    /// Returns the shared nodes that this rank leads.
    pub(crate) fn led(&self) -> &[Group] {
        &self.led
    }

    /// Returns the root of this rank's subtree, or the root of the tree if this rank has no subtree.
    pub(crate) fn root(&self) -> NodeId {
        self.subtree.as_ref().map_or(NodeId::ROOT, |subtree| subtree.root)
    }

    /// Returns the root of this rank's subtree, if only this rank charges it. The members of a group that could not split its
    /// node have charges of the node, although one of them holds it.
    pub(crate) fn own_root(&self) -> Option<NodeId> {
        let root = self.subtree.as_ref().map(|subtree| subtree.root);
        root.filter(|&root| self.unsplit.is_none_or(|end| end.node != root))
    }

    /// Returns the highest node of which this rank holds points: the first node of the path, otherwise the root of
    /// this rank's subtree.
    pub(crate) fn top(&self) -> Option<NodeId> {
        self.path.first().map(Shared::id).or(self.subtree.as_ref().map(|subtree| subtree.root))
    }

    /// Returns `true` if `node` is the root of this rank's subtree.
    pub(crate) fn holds(&self, node: NodeId) -> bool {
        self.subtree.as_ref().is_some_and(|subtree| subtree.root == node)
    }

    /// Stores the summaries of the children of a node, if the node is on the path.
    pub(crate) fn set_summaries(&mut self, node: NodeId, summaries: Box<[Summary<P>; 2]>) {
        if let Some(shared) = self.path.iter_mut().find(|shared| shared.id() == node) {
            shared.summaries = Some(summaries);
        }
    }

    /// Returns the position of a node on the path, or the length of the path if the node is not on it.
    pub(crate) fn position(&self, node: NodeId) -> usize {
        self.path.iter().position(|shared| shared.id() == node).unwrap_or(self.path.len())
    }

    /// Returns the node on the path with this id.
    pub(crate) fn shared(&self, node: NodeId) -> Option<&Shared<P>> {
        self.path.iter().find(|shared| shared.id() == node)
    }

    /// Returns the place at which this rank continues with an item that was sent to a node.
    pub(crate) fn entry(&self, node: NodeId, own: Rank) -> Entry {
        match self.unsplit.filter(|end| end.node == node) {
            Some(Unsplit { holder, .. }) if holder != own => Entry::Relay(holder),
            _ => Entry::Here(self.position(node)),
        }
    }

    /// Receives an item that was sent to a node. Returns it with the position of the path from which this rank continues.
    /// If another rank holds the node, sends the item on to it as a message and returns `None`.
    pub(crate) fn receive<T>(
        &self,
        cx: &mut Context<P>,
        node: NodeId,
        item: T,
        into_body: impl FnOnce(T) -> Body<P>,
    ) -> Option<(usize, T)>
    where
        P: Point,
    {
        match self.entry(node, cx.rank()) {
            Entry::Here(start) => Some((start, item)),
            Entry::Relay(holder) => {
                cx.send_to((node, holder), into_body(item));
                None
            }
        }
    }

    /// Follows an item (a point or a ball) down the path, from the position `start`.
    ///
    /// `reach` returns which children of a node the item reaches. `leave` receives every child at which the item leaves
    /// the path. Returns `true` if the item reaches this rank's subtree.
    pub(crate) fn follow(
        &self,
        start: usize,
        mut reach: impl FnMut(usize, &Shared<P>) -> [bool; 2],
        mut leave: impl FnMut(Way),
    ) -> bool {
        for (level, shared) in self.path.iter().enumerate().skip(start) {
            if !shared.follow(reach(level, shared), |side| leave(Way { level, side })) {
                return false;
            }
        }
        true
    }

    /// Returns the node and the rank to which an item is sent if it leaves the path by `way`.
    pub(crate) fn beyond(&self, way: Way, own: Rank) -> (NodeId, Rank) {
        let shared = &self.path[way.level];
        (shared.id().child(way.side), shared.member_below(own, way.side))
    }

    /// Returns, for each owned point, the index of its leaf.
    pub(crate) fn leaf_numbers(&self) -> Vec<u32> {
        let mut leaf_of = Vec::with_capacity(self.leaves().last().map_or(0, |leaf| leaf.indices().end));
        for (at, leaf) in (0u32..).zip(self.leaves()) {
            leaf_of.extend(leaf.owned().map(|_| at));
        }
        leaf_of
    }
}
