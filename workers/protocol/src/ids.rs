//! Names of things: ranks, subproblems, phases.

use bincode::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// A party of the machine. Rank 0 is the coordinator, workers are `1..=p`.
pub type Rank = u32;

/// The coordinator's rank: it leads the root, reads and writes, and holds no bulk points otherwise.
pub const COORDINATOR: Rank = 0;

/// A subproblem: a node of the partition tree, by its path. The root is 1, the interior child of `s` is
/// `2s`, the exterior child `2s + 1`.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Encode, Decode, Serialize, Deserialize,
)]
pub struct NodeId(pub u64);

impl NodeId {
    /// The whole point set.
    pub const ROOT: NodeId = NodeId(1);
    /// No node may lie deeper (paths are 64 bits).
    pub const DEEPEST: u32 = 62;

    /// The interior (`side` 0) or exterior (`side` 1) child.
    #[must_use]
    pub fn child(self, side: usize) -> NodeId {
        NodeId(self.0 * 2 + side as u64)
    }

    /// The parent, or none for the root.
    pub fn parent(self) -> Option<NodeId> {
        (self.0 > 1).then_some(NodeId(self.0 / 2))
    }

    /// 0 interior, 1 exterior child of its parent.
    pub fn side(self) -> usize {
        (self.0 & 1) as usize
    }

    /// Number of levels below the root.
    pub fn level(self) -> u32 {
        self.0.ilog2()
    }

    /// Is `self` the node `other` or an ancestor of it?
    pub fn contains(self, other: NodeId) -> bool {
        let (a, b) = (self.level(), other.level());
        a <= b && other.0 >> (b - a) == self.0
    }

    /// Which child of `self` is `other` (a proper descendant) or an ancestor of it?
    pub fn side_of(self, other: NodeId) -> usize {
        let shift = other.level() - self.level() - 1;
        ((other.0 >> shift) & 1) as usize
    }
}

/// The stages of a run, in order. `paper` phases are the paper's; the others are the machine's own or
/// belong to repair and are never mixed with them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum Phase {
    /// Blocks of points to the workers.
    Load,
    /// Section 2 and 4.3 step 2: sphere separators, level by level.
    Partition,
    /// Points near separators to the other side (`triangulate` only).
    Halo,
    /// Every worker's own triangulation of its points and those (`triangulate` only).
    Pieces,
    /// Points whose cells reach farther (`triangulate` only).
    Seam,
    /// The choice of the supergraph from a sample of stars.
    Choice,
    /// Section 4.3: radii inside every leaf.
    Radii,
    /// Short-cut for balls that would touch very many leaves (the punt).
    Probe,
    /// Section 4.3: nearest-neighbour balls, by descent.
    Neighbours,
    /// Largest radius and smallest point of every subproblem, up and down the tree.
    Summaries,
    /// Section 4.5: k-nearest lists inside every leaf.
    KnnRadii,
    /// The punt of the k-nearest balls.
    KnnProbe,
    /// Section 4.5: k-nearest neighbours, by descent.
    Knn,
    /// Section 4.3: separator sets.
    Sets,
    /// Section 4.2: the supergraph, leaf by leaf, and its union.
    Graph,
    /// Section 5: a maximal independent set of the graph (`independent` only).
    Independent,
    /// Section 4.1: local hulls.
    Hulls,
    /// Do the stars agree? Fingerprints, and lists where they differ.
    Check,
    /// Exchange between stars that do not.
    Repair,
    /// The certificate of the final stars.
    Certificate,
    /// Gathering of regions that the exchange leaves unresolved.
    Fallback,
    /// Merged results up the tree.
    Merge,
    /// Cells and counts to the coordinator.
    Collect,
    /// The end.
    Done,
}

impl Phase {
    /// All phases, in order.
    pub const ALL: [Phase; 24] = [
        Phase::Load,
        Phase::Partition,
        Phase::Halo,
        Phase::Pieces,
        Phase::Seam,
        Phase::Choice,
        Phase::Radii,
        Phase::Probe,
        Phase::Neighbours,
        Phase::Summaries,
        Phase::KnnRadii,
        Phase::KnnProbe,
        Phase::Knn,
        Phase::Sets,
        Phase::Graph,
        Phase::Independent,
        Phase::Hulls,
        Phase::Check,
        Phase::Repair,
        Phase::Certificate,
        Phase::Fallback,
        Phase::Merge,
        Phase::Collect,
        Phase::Done,
    ];

    /// The phase with this number.
    pub fn from_number(n: u8) -> Option<Phase> {
        Phase::ALL.get(usize::from(n)).copied()
    }

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Load => "load",
            Phase::Partition => "partition",
            Phase::Halo => "halo",
            Phase::Pieces => "pieces",
            Phase::Seam => "seam",
            Phase::Radii => "radii",
            Phase::Probe => "probe",
            Phase::Neighbours => "neighbours",
            Phase::Summaries => "summaries",
            Phase::Choice => "choice",
            Phase::KnnRadii => "knn-radii",
            Phase::KnnProbe => "knn-probe",
            Phase::Knn => "knn",
            Phase::Sets => "separator-sets",
            Phase::Graph => "graph",
            Phase::Independent => "independent",
            Phase::Hulls => "hulls",
            Phase::Check => "check",
            Phase::Repair => "repair",
            Phase::Certificate => "certificate",
            Phase::Fallback => "fallback",
            Phase::Merge => "merge",
            Phase::Collect => "collect",
            Phase::Done => "done",
        }
    }

    /// Is it a phase of the paper's algorithm?
    pub fn is_paper(self) -> bool {
        matches!(
            self,
            Phase::Partition
                | Phase::Radii
                | Phase::Probe
                | Phase::Neighbours
                | Phase::Summaries
                | Phase::KnnRadii
                | Phase::KnnProbe
                | Phase::Knn
                | Phase::Sets
                | Phase::Graph
                | Phase::Independent
                | Phase::Hulls
                | Phase::Merge
        )
    }

    /// Does it belong to the agreement of stars, reported beside the paper's phases?
    pub fn is_repair(self) -> bool {
        matches!(self, Phase::Check | Phase::Repair | Phase::Certificate | Phase::Fallback)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths() {
        let n = NodeId::ROOT.child(0).child(1).child(1);
        assert_eq!((n.0, n.level(), n.side()), (11, 3, 1));
        assert!(NodeId(2).contains(n) && !NodeId(3).contains(n) && n.contains(n));
        assert_eq!((NodeId::ROOT.side_of(n), NodeId(2).side_of(n), NodeId(5).side_of(n)), (0, 1, 1));
        assert_eq!(n.parent(), Some(NodeId(5)));
    }

    #[test]
    fn phase_numbers_round_trip() {
        for (i, phase) in Phase::ALL.into_iter().enumerate() {
            assert_eq!(phase as usize, i);
            assert_eq!(Phase::from_number(i as u8), Some(phase));
        }
        assert_eq!(Phase::from_number(99), None);
    }
}
