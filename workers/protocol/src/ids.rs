//! Identifiers of ranks, subproblems and phases.

use bincode::{Decode, Encode};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A rank of the machine. Rank 0 is the coordinator, workers are `1..=p`.
pub type Rank = u32;

/// The rank of the coordinator. It owns no point, and neither points nor results pass through it.
pub const COORDINATOR: Rank = 0;

/// A subproblem: a node of the partition tree, identified by its path. The root is 1. The interior child of `s` is `2s`,
/// the exterior child is `2s + 1`.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Encode, Decode, Serialize, Deserialize,
)]
pub struct NodeId(pub u64);

impl NodeId {
    /// The whole point set.
    pub const ROOT: NodeId = NodeId(1);
    /// The largest level of a node: a path has 64 bits.
    pub const DEEPEST: u32 = 62;

    /// Returns the interior (`side` 0) or exterior (`side` 1) child.
    #[must_use]
    pub fn child(self, side: usize) -> NodeId {
        NodeId(self.0 * 2 + side as u64)
    }

    /// Returns the parent, or `None` for the root.
    pub fn parent(self) -> Option<NodeId> {
        (self.0 > 1).then_some(NodeId(self.0 / 2))
    }

    /// Returns the side in the parent: 0 is interior, 1 is exterior.
    pub fn side(self) -> usize {
        (self.0 & 1) as usize
    }

    /// Returns the number of levels below the root.
    pub fn level(self) -> u32 {
        self.0.ilog2()
    }

    /// Returns `true` if `self` is `other` or an ancestor of it.
    pub fn contains(self, other: NodeId) -> bool {
        let (a, b) = (self.level(), other.level());
        a <= b && other.0 >> (b - a) == self.0
    }

    /// Returns the side of the child of `self` that is `other` or an ancestor of it. `other` must be a proper
    /// descendant.
    pub fn side_of(self, other: NodeId) -> usize {
        let shift = other.level() - self.level() - 1;
        ((other.0 >> shift) & 1) as usize
    }
}

/// The phases of a run, in order. Reports separate the phases of the paper, the repair phases, and the phases of the
/// machine itself. Messages and records contain the number of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "u8", try_from = "u8")]
#[repr(u8)]
pub enum Phase {
    /// Each rank reads its block of the points.
    Load,
    /// Section 2, and step 2 of Section 4.3: sphere separators, level by level.
    Partition,
    /// Exchange of ghosts near separators (`triangulate` only).
    Halo,
    /// Triangulation of every subdomain with its ghosts (`triangulate` only).
    Pieces,
    /// Exchange of the ghosts beyond the ghost layers (`triangulate` only).
    Seam,
    /// Choice of the supergraph from a sample of stars.
    Choice,
    /// Section 4.3: radii within every leaf.
    Radii,
    /// Probe of large balls that would otherwise visit many leaves (the punt).
    Probe,
    /// Section 4.3: nearest-neighbour balls, by descent.
    Neighbours,
    /// Largest radius and smallest point of every subproblem, up and down the tree.
    Summaries,
    /// Section 4.5: k-nearest lists within every leaf.
    KnnRadii,
    /// Probe of the k-nearest balls.
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
    /// Check of the stars: fingerprints, and lists where fingerprints differ.
    Check,
    /// Star splaying: exchange between stars that disagree.
    Repair,
    /// The certificate of the final stars.
    Certificate,
    /// Gathering of regions that splaying leaves unresolved.
    Fallback,
    /// Reduction of the results up the tree.
    Merge,
    /// Each rank builds its share of the result.
    Collect,
    /// The end of the run.
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

    /// Returns the phase with this number, or `None`.
    pub fn from_number(n: u8) -> Option<Phase> {
        Phase::ALL.get(usize::from(n)).copied()
    }

    /// Returns the name in reports and traces.
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

    /// Returns `true` for phases of the paper's algorithm.
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

    /// Returns `true` for repair phases, which are reported separately from the paper's phases.
    pub fn is_repair(self) -> bool {
        matches!(self, Phase::Check | Phase::Repair | Phase::Certificate | Phase::Fallback)
    }
}

impl From<Phase> for u8 {
    fn from(phase: Phase) -> u8 {
        phase as u8
    }
}

/// A number that is not the number of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("no phase has the number {0}")]
pub struct PhaseNumberError(u8);

impl TryFrom<u8> for Phase {
    type Error = PhaseNumberError;

    fn try_from(number: u8) -> Result<Self, PhaseNumberError> {
        Phase::from_number(number).ok_or(PhaseNumberError(number))
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
        assert_eq!(Phase::try_from(99), Err(PhaseNumberError(99)));
    }
}
