//! The order of phases. Every rank derives it from the same facts, so no message is needed to say that
//! a phase begins: a phase is over when a round moved nothing, which the exchange tells all at once.

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::{NodeId, Phase};
pub use septet_protocol::outcome::Outcome;

use crate::config::{Correction, Task, Wanted, WorkerConfig};

/// What the phases' order depends on, known to every rank by the time it matters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// The supergraph, once chosen.
    pub supergraph: Option<Supergraph>,
    /// The coordinator's verdict on the last certificate.
    pub outcome: Outcome,
    /// The level whose nodes correct their balls in this pass, where that is done level by level.
    pub level: u32,
}

impl Known {
    /// Notes that a phase begins, or its next pass.
    pub fn enter(&mut self, before: Phase, now: Phase, config: &WorkerConfig) {
        if now == Phase::Neighbours {
            self.level = if before == now { self.level.saturating_sub(1) } else { first_level(config) };
        }
    }
}

/// The level whose nodes correct their balls first: no node below it is shared, since groups lose a rank with
/// every level.
pub fn first_level(config: &WorkerConfig) -> u32 {
    config.workers.saturating_sub(1).min(NodeId::DEEPEST)
}

/// Are the balls to the nearest neighbours of all points needed? Graphs of k nearest neighbours are not made of them.
fn needs_radii(config: &WorkerConfig, known: &Known) -> bool {
    let measured = config.correction == Correction::Naive || config.until == Some(Phase::Neighbours);
    measured || !matches!(known.supergraph, Some(Supergraph::Knn { .. }))
}

/// Is the supergraph still to be chosen?
fn chooses(config: &WorkerConfig) -> bool {
    config.until != Some(Phase::Neighbours) && !matches!(config.wanted, Wanted::Fixed(_))
}

/// The phase after `phase`.
pub fn next(phase: Phase, config: &WorkerConfig, known: &Known) -> Phase {
    let naive = config.correction == Correction::Naive;
    let last = phase != Phase::Neighbours || !naive || known.level == 0;
    if config.until == Some(phase) && last {
        return Phase::Collect;
    }
    let knn = config.counted && matches!(known.supergraph, Some(Supergraph::Knn { .. }));
    let independent = config.task != Task::Delaunay;
    match phase {
        Phase::Load => Phase::Partition,
        // Points bring their radii along.
        Phase::Partition if independent => Phase::Summaries,
        Phase::Partition if !config.counted => Phase::Halo,
        Phase::Halo => Phase::Pieces,
        Phase::Pieces => Phase::Seam,
        Phase::Partition if chooses(config) => Phase::Choice,
        Phase::Partition | Phase::Choice if needs_radii(config, known) => Phase::Radii,
        Phase::Radii if naive => Phase::Neighbours,
        Phase::Neighbours if naive && known.level > 0 => Phase::Neighbours,
        Phase::Radii => Phase::Probe,
        Phase::Probe => Phase::Neighbours,
        Phase::Partition | Phase::Choice | Phase::Neighbours => Phase::Summaries,
        Phase::Summaries if knn => Phase::KnnRadii,
        Phase::Summaries | Phase::Knn => Phase::Sets,
        Phase::KnnRadii => Phase::KnnProbe,
        Phase::KnnProbe => Phase::Knn,
        Phase::Sets => Phase::Graph,
        Phase::Graph if independent => Phase::Independent,
        Phase::Seam | Phase::Graph => Phase::Hulls,
        Phase::Hulls => Phase::Check,
        Phase::Check | Phase::Fallback => Phase::Repair,
        Phase::Repair => Phase::Certificate,
        Phase::Certificate => Phase::Merge,
        Phase::Merge => match known.outcome {
            Outcome::Passed | Outcome::Failed => Phase::Collect,
            Outcome::GatherUnresolved | Outcome::GatherAll => Phase::Fallback,
        },
        Phase::Independent => Phase::Collect,
        Phase::Collect | Phase::Done => Phase::Done,
    }
}
