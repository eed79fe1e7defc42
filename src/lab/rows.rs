//! Rows that reports of runs and lines of sweeps share. They hold the counts of the ledger.

use septet_core::TrafficTotal;
use septet_protocol::ids::{ByGroup, Group, NodeId, Phase};
use septet_protocol::ledger::{Ledger, NodeFacts, PhaseTotal, RoundRow, Total};
use serde::{Deserialize, Serialize};

/// One phase. `C` is the type of counts of work and depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "PhaseRow"))]
pub struct PhaseRow<C = u64> {
    /// The counts.
    #[serde(flatten)]
    pub total: PhaseTotal<C>,
    /// Measured wall-clock seconds.
    pub seconds: f64,
}

impl<C> PhaseRow<C> {
    /// Returns the name of the phase.
    pub fn name(&self) -> &'static str {
        self.total.phase.name()
    }

    /// Returns the group of the phase.
    pub fn group(&self) -> Group {
        self.total.phase.group()
    }
}

/// Returns the phases that were counted or measured, in order. A phase that occurred twice has one row.
pub(crate) fn phases(ledger: &Ledger, seconds: &[(Phase, f64)]) -> Vec<PhaseRow> {
    let row = |phase: Phase| {
        let total = ledger.phases.iter().find(|total| total.phase == phase);
        let mut times = seconds.iter().filter(|(of, _)| *of == phase).map(|(_, seconds)| seconds).peekable();
        if total.is_none() && times.peek().is_none() {
            return None;
        }
        let total = total.copied().unwrap_or_else(|| PhaseTotal::empty(phase));
        Some(PhaseRow { total, seconds: times.sum() })
    };
    Phase::ALL.into_iter().filter_map(row).collect()
}

/// The totals of a group of phases. `C` is the type of counts of work and depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "GroupTotal"))]
pub struct GroupTotal<C = u64> {
    /// Work and depth.
    #[serde(flatten)]
    pub total: Total<C>,
    /// Messages.
    #[serde(flatten)]
    pub traffic: TrafficTotal,
}

/// Returns the totals of the groups whose phases count work.
pub(crate) fn groups(ledger: &Ledger) -> ByGroup<GroupTotal> {
    ByGroup::of(|group| GroupTotal {
        total: ledger.totals.get(group).copied().unwrap_or_default(),
        traffic: TrafficTotal::of_phases(ledger.phases.iter().filter(|total| total.phase.group() == group)),
    })
}

/// Returns the rounds in order.
pub(crate) fn rounds(ledger: &Ledger) -> impl Iterator<Item = RoundRow> {
    ledger.part.rounds.iter().map(|(&key, &tally)| RoundRow { key, tally })
}

/// One node of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NodeRow {
    /// Id: the root is 1, and the children of s are 2s (inside) and 2s + 1 (outside).
    #[cfg_attr(feature = "schema", schemars(with = "u64"))]
    pub id: NodeId,
    /// Levels below the root.
    pub level: u32,
    /// The facts of the node.
    #[serde(flatten)]
    pub facts: NodeFacts,
}

/// Returns every node of the tree, by id.
pub(crate) fn nodes(ledger: &Ledger) -> Vec<NodeRow> {
    let row = |(&id, &facts): (&NodeId, &NodeFacts)| NodeRow { id, level: id.level(), facts };
    ledger.part.nodes.iter().map(row).collect()
}
