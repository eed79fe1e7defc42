//! The phases of a run in their order, and the direction of each over the tree.

use crate::ids::Phase;
use crate::ledger::part::LedgerPart;

/// The direction of a phase over the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow {
    Down,
    Up,
    Local,
    Steps,
}

/// A part of a run that starts when everything before it has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Phases without a barrier between them, in order. At most the first goes down the tree.
    Chained(Vec<(Phase, Flow)>),
    /// A phase whose subproblems step together.
    Steps(Phase),
}

/// The phases in which some subproblem has a charge. All ranks that fold parts of one ledger need the same plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Plan {
    /// All phases with charges, in order.
    pub(super) phases: Vec<(Phase, Flow)>,
    /// The stages of the paper's phases.
    pub(super) paper: Vec<Stage>,
    /// The stages of the repair phases.
    pub(super) repair: Vec<Stage>,
}

impl Plan {
    /// Returns the plan of a run whose ranks have these parts, merged.
    pub(super) fn of(part: &LedgerPart) -> Plan {
        let has_passes = part.passes().next().is_some();
        let phases: Vec<(Phase, Flow)> = Phase::ALL
            .into_iter()
            .map(|phase| (phase, flow(phase, has_passes)))
            .filter(|&(phase, _)| part.members(phase).next().is_some())
            .collect();
        let stages =
            |belongs: fn(Phase) -> bool| stages(phases.iter().copied().filter(|&(phase, _)| belongs(phase)));
        Plan { paper: stages(Phase::is_paper), repair: stages(Phase::is_repair), phases }
    }
}

/// Returns the direction of a phase. A descent whose replies return makes two passes over the tree. Both are charged
/// on the way down, so its flow is [`Flow::Down`].
fn flow(phase: Phase, has_passes: bool) -> Flow {
    match phase {
        Phase::Repair | Phase::Independent => Flow::Steps,
        Phase::Neighbours if has_passes => Flow::Up,
        Phase::Summaries | Phase::Merge | Phase::Check | Phase::Certificate | Phase::Fallback => Flow::Up,
        // A leaf may receive the ends of edges from any other leaf, so the graph waits for everything before it.
        Phase::Graph
        | Phase::Partition
        | Phase::Choice
        | Phase::Sets
        | Phase::Probe
        | Phase::Neighbours
        | Phase::KnnProbe
        | Phase::Knn => Flow::Down,
        _ => Flow::Local,
    }
}

/// Splits phases into stages: before each phase that goes down the tree, and around each phase with steps.
fn stages(phases: impl Iterator<Item = (Phase, Flow)>) -> Vec<Stage> {
    let mut stages = Vec::new();
    for (phase, flow) in phases {
        match (flow, stages.last_mut()) {
            (Flow::Steps, _) => stages.push(Stage::Steps(phase)),
            (Flow::Local | Flow::Up, Some(Stage::Chained(chained))) => chained.push((phase, flow)),
            _ => stages.push(Stage::Chained(vec![(phase, flow)])),
        }
    }
    stages
}
