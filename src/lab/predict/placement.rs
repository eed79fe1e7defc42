//! The ranks of each subproblem. They follow from the machine's rule, applied to a recorded tree.

use std::collections::BTreeMap;

use septet_protocol::ids::{COORDINATOR, NodeId, Rank};
use septet_protocol::tasks::TaskLog;
use septet_workers::leader::divide;

use super::error::PredictError;

/// A node of the tree, and the ranks that hold it.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) node: NodeId,
    pub(super) first: Rank,
    pub(super) ranks: u32,
    /// Whether the first rank holds the whole node.
    pub(super) whole: bool,
    pub(super) leader: Rank,
    pub(super) parent: Option<usize>,
    /// Positions of the children's groups, if the node is shared.
    pub(super) children: Option<[usize; 2]>,
}

impl Group {
    pub(super) fn holds(&self, rank: Rank) -> bool {
        (self.first..self.first + self.ranks).contains(&rank)
    }
}

/// The placement of a recorded tree on `workers` ranks.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    pub(super) workers: u32,
    /// Shared nodes and their children, parents before children. The root is the first.
    pub(super) groups: Vec<Group>,
    /// The rank of each leaf.
    pub(super) holder: Vec<Rank>,
    /// Positions of the leaves of each rank that has leaves.
    pub(super) leaves_of: BTreeMap<Rank, Vec<u32>>,
    /// The position of the unshared group of each rank that has leaves.
    pub(super) piece: BTreeMap<Rank, usize>,
}

impl Placement {
    pub(super) fn new(log: &TaskLog, workers: u32) -> Result<Self, PredictError> {
        let nodes: BTreeMap<u64, (u64, u64)> = log.nodes.iter().map(|n| (n.0, (n.1, n.3))).collect();
        let mut groups: Vec<Group> = Vec::new();
        let root = (NodeId::ROOT, 1, workers, None);
        let mut open = vec![root];
        while let Some((node, first, ranks, parent)) = open.pop() {
            let &(population, kind) = nodes
                .get(&node.0)
                .ok_or(PredictError::Corrupt { what: "a node is missing from the tree" })?;
            let small = population <= log.leaf_size || node.level() >= NodeId::DEEPEST;
            let whole = ranks == 1 || small;
            let leader = if node == NodeId::ROOT { COORDINATOR } else { first };
            let at = groups.len();
            groups.push(Group { node, first, ranks, whole, leader, parent, children: None });
            if let Some(parent) = parent {
                let sides = groups[parent].children.get_or_insert([usize::MAX; 2]);
                sides[node.side()] = at;
            }
            if whole {
                continue;
            }
            if kind == 0 {
                return Err(PredictError::Unsplit { node: node.0, population });
            }
            let below = [0, 1].map(|side| nodes.get(&node.child(side).0).map_or(0, |n| n.0));
            let interior = divide(ranks, below);
            open.push((node.child(1), first + interior, ranks - interior, Some(at)));
            open.push((node.child(0), first, interior, Some(at)));
        }
        let mut placement = Placement {
            workers,
            groups,
            holder: vec![0; log.leaves.len()],
            leaves_of: BTreeMap::new(),
            piece: BTreeMap::new(),
        };
        for (at, &leaf) in log.leaves.iter().enumerate() {
            let piece = placement.piece_of(NodeId(leaf));
            let rank = placement.groups[piece].first;
            placement.holder[at] = rank;
            placement.leaves_of.entry(rank).or_default().push(at as u32);
            placement.piece.insert(rank, piece);
        }
        Ok(placement)
    }

    fn piece_of(&self, leaf: NodeId) -> usize {
        let mut at = 0;
        while let Some(children) = self.groups[at].children {
            at = children[self.groups[at].node.side_of(leaf)];
        }
        at
    }

    /// Returns the rank in a child's group that receives the messages of `rank`, a member of the shared node.
    pub(super) fn member_below(&self, group: usize, rank: Rank, child: usize) -> Rank {
        let (above, below) = (&self.groups[group], &self.groups[child]);
        if below.whole {
            return below.first;
        }
        let place = u64::from(rank - above.first) * u64::from(below.ranks) / u64::from(above.ranks);
        below.first + place as u32
    }

    /// Returns the shared groups from the root down to a group, without this group.
    pub(super) fn above(&self, group: usize) -> Vec<usize> {
        let mut path = Vec::new();
        let mut at = self.groups[group].parent;
        while let Some(i) = at {
            path.push(i);
            at = self.groups[i].parent;
        }
        path.reverse();
        path
    }
}
