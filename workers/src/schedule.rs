//! The order of phases. Every rank derives it from the same facts, so no message is needed to say that
//! a phase begins: a phase is over when a round moved nothing, which the exchange tells all at once.

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::Phase;

use crate::config::{Wanted, WorkerConfig};

/// What the phases' order depends on, known to every rank by the time it matters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// The supergraph, once chosen.
    pub supergraph: Option<Supergraph>,
    /// The coordinator's verdict on the last certificate.
    pub outcome: Outcome,
}

/// What the coordinator decides after a certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// All stars agree: collect.
    #[default]
    Passed,
    /// Gather the unresolved stars and exchange again.
    GatherUnresolved,
    /// Gather everything.
    GatherAll,
    /// The stars do not agree and nothing is left to try.
    Failed,
}

impl Outcome {
    /// As a number, for the wire.
    pub fn number(self) -> u8 {
        self as u8
    }

    /// From the wire.
    pub fn from_number(n: u8) -> Option<Self> {
        [Outcome::Passed, Outcome::GatherUnresolved, Outcome::GatherAll, Outcome::Failed]
            .get(usize::from(n))
            .copied()
    }
}

/// The phase after `phase`.
pub fn next(phase: Phase, config: &WorkerConfig, known: &Known) -> Phase {
    if config.until == Some(phase) {
        return Phase::Collect;
    }
    let knn = config.counted && matches!(known.supergraph, Some(Supergraph::Knn { .. }));
    match phase {
        Phase::Load => Phase::Partition,
        Phase::Partition if !config.counted => Phase::Pieces,
        Phase::Pieces => Phase::Seam,
        Phase::Partition => Phase::Radii,
        Phase::Radii => Phase::Probe,
        Phase::Probe => Phase::Neighbours,
        Phase::Neighbours => Phase::Summaries,
        Phase::Summaries if !matches!(config.wanted, Wanted::Fixed(_)) => Phase::Choice,
        Phase::Summaries | Phase::Choice if knn => Phase::KnnRadii,
        Phase::Summaries | Phase::Choice | Phase::Knn => Phase::Sets,
        Phase::KnnRadii => Phase::KnnProbe,
        Phase::KnnProbe => Phase::Knn,
        Phase::Sets => Phase::Graph,
        Phase::Seam | Phase::Graph => Phase::Hulls,
        Phase::Hulls => Phase::Check,
        Phase::Check | Phase::Fallback => Phase::Repair,
        Phase::Repair => Phase::Certificate,
        Phase::Certificate => Phase::Merge,
        Phase::Merge => match known.outcome {
            Outcome::Passed | Outcome::Failed => Phase::Collect,
            Outcome::GatherUnresolved | Outcome::GatherAll => Phase::Fallback,
        },
        Phase::Collect | Phase::Done => Phase::Done,
    }
}
