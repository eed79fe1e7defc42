//! The phases of a run in their order, and its stages.

use crate::ids::{ByGroup, Flow, Phase};
use crate::ledger::part::{LedgerPart, Role};

/// The phases in which some subproblem has a charge, and whether there are passes of a bottom-up correction.
///
/// The fold of a part depends on the phases of the whole run. Processes that condense their parts therefore agree on the
/// union of their sets first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PhaseSet(u64);

impl PhaseSet {
    /// The bit that represents passes.
    const PASSES: u64 = 1 << 63;
    const ALL: u64 = PhaseSet::PASSES | ((1 << Phase::ALL.len()) - 1);

    /// Returns the phases of a part.
    pub fn of(part: &LedgerPart) -> Self {
        let bits = |role| if matches!(role, Role::Pass(_)) { PhaseSet::PASSES } else { 0 };
        let sets = part.charges.keys().map(|account| bits(account.role) | 1 << account.phase as u64);
        PhaseSet(sets.fold(0, |all, set| all | set))
    }

    /// Returns the set as a number, for the wire.
    pub fn bits(self) -> u64 {
        self.0
    }

    /// Returns the set that the number represents, or `None`.
    pub fn from_bits(bits: u64) -> Option<Self> {
        (bits & !PhaseSet::ALL == 0).then_some(PhaseSet(bits))
    }

    /// Returns the phases of both sets.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        PhaseSet(self.0 | other.0)
    }

    /// Returns `true` if some subproblem has a charge in the phase.
    pub fn contains(self, phase: Phase) -> bool {
        self.0 >> phase as u64 & 1 == 1
    }

    fn has_passes(self) -> bool {
        self.0 & PhaseSet::PASSES != 0
    }
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
pub(crate) struct Plan {
    /// All phases with charges, in order.
    pub(super) phases: Vec<(Phase, Flow)>,
    /// The stages of each group.
    pub(super) stages: ByGroup<Vec<Stage>>,
}

impl Plan {
    /// Returns the plan of a run with these phases.
    pub(crate) fn of(set: PhaseSet) -> Plan {
        let phases = Phase::ALL.into_iter().filter(|&phase| set.contains(phase));
        let phases: Vec<(Phase, Flow)> = phases.map(|phase| (phase, flow(phase, set.has_passes()))).collect();
        let of = |group| stages(phases.iter().copied().filter(|(phase, _)| phase.group() == group));
        Plan { stages: ByGroup::of(of), phases }
    }
}

/// Returns the direction of a phase in a run. The bottom-up correction goes up the tree.
fn flow(phase: Phase, has_passes: bool) -> Flow {
    if phase == Phase::Neighbours && has_passes { Flow::Up } else { phase.flow() }
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
