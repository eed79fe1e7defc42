//! Faults of the machine: some end or disturb a run, and others falsify a claim of the paper.
//!
//! A fault of the machine changes the phases themselves: messages, members, separators ([`machine`]). A fault of
//! charges changes only the account of the work ([`charges`]). It changes the shares of all workers alike, so the
//! counts remain independent of the number of workers.

mod charges;
mod factor;
mod flip;
mod forms;
mod law;
mod machine;
mod text;

use septet_geometry::separator::Ablation;
use septet_protocol::ids::{NodeId, Phase, Rank};
use serde::{Deserialize, Serialize};

pub use factor::Factor;
pub use flip::Flip;
pub use forms::{FAULTS, FaultForm};
pub use law::Law;
pub use text::FaultTextError;

/// One planted fault. [`FAULTS`] lists the forms of its text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Fault {
    /// Leaders do not split the shared nodes from `first` to `last`. The lowest rank of the group holds such a node
    /// as a leaf, and the other ranks of the group relay the messages about it.
    RefuseSplit {
        /// The first node.
        first: NodeId,
        /// The last node.
        last: NodeId,
    },
    /// A hash of node and attempt rejects about one of `every` separators. Some nodes therefore draw again while
    /// others continue. If `every` is 1, every separator is rejected and no node is split.
    RefuseDraws {
        /// The reciprocal of the share of rejected separators, at least 1.
        every: u32,
    },
    /// A worker loses a cell of one of its stars before every certificate.
    SpoilStar {
        /// The worker.
        rank: Rank,
    },
    /// A worker ends when a phase begins.
    DieAt {
        /// The worker.
        rank: Rank,
        /// The phase.
        phase: Phase,
    },
    /// A worker panics when a phase begins.
    PanicAt {
        /// The worker.
        rank: Rank,
        /// The phase.
        phase: Phase,
    },
    /// One bit of one message is flipped before the message is sent.
    Flip(Flip),
    /// Every point goes to every leaf.
    Flood,
    /// Points go to all leaves within a multiple of their reach.
    FarGhosts {
        /// The multiple, at least 1.
        factor: Factor,
    },
    /// A hash of the coordinates keeps about half of the points in their own leaves. Rule `ghost` only.
    HalfGhosts,
    /// A hash of the coordinates removes about half of the points from all separator sets. Rules `both`,
    /// `own` and `smaller` only.
    HalfSeparators,
    /// Graphs are built with half the chosen alpha.
    HalveAlpha,
    /// Cells that ask for a point in their circumsphere get no answer.
    BlindProbes,
    /// Balls of overlap graphs extend to the first neighbour, whatever k is.
    FirstBall,
    /// The choice of the supergraph takes the candidate that it predicts to be the worst. Purpose `counting` only.
    WorstChoice,
    /// Every node punts in the correction of neighbour balls in stages.
    AlwaysPunt,
    /// Local hulls with many candidates are built by distance.
    SlowHub,
    /// Every set is divided by the separator of the partition. Rule `own` only.
    OldSpheres,
    /// Every separator is a sphere around one sample that contains a twentieth of the points. It is always accepted.
    SmallSphere,
    /// Separators lack one part of the draw.
    Ablate(Ablation),
    /// A phase is deeper: each node takes additional steps.
    Slow {
        /// The phase, one of the paper.
        phase: Phase,
        /// The number of additional steps.
        law: Law,
        /// The factor of the law.
        factor: Factor,
    },
    /// The work of a phase is multiplied.
    Work {
        /// The phase, one of the paper.
        phase: Phase,
        /// The factor.
        factor: Factor,
    },
    /// A phase costs one step of one processor at each node.
    Free {
        /// The phase, one of the paper.
        phase: Phase,
    },
    /// One processor computes the radii within a leaf, pair by pair.
    SequentialLeaf,
    /// The radii within leaves are charged one step per point, not one per pair.
    FreeLoop,
    /// A worker has one clock for all its subproblems, so they wait for each other.
    OneClock,
}
