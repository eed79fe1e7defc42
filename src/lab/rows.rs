//! Rows that reports of runs and lines of sweeps share. They hold the counts of the ledger.

use septet_core::TrafficTotal;
use septet_protocol::ids::{ByGroup, Group, NodeId, Phase};
use septet_protocol::ledger::{Ledger, LevelSums, NodeFacts, PhaseTotal, RoundRow, Total};
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
        // The sum of no numbers would be -0.
        Some(PhaseRow { total, seconds: times.fold(0.0, |sum, seconds| sum + seconds) })
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

/// The partition tree. Ratios are `None` if no node was split.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct TreeRow {
    /// Number of levels below the root; 0 for a single leaf.
    pub levels: u32,
    /// Number of leaves.
    pub leaves: u64,
    /// Number of nodes, leaves included.
    pub nodes: u64,
    /// Number of nodes split by a sphere.
    pub spheres: u64,
    /// Number of nodes split by a plane.
    pub planes: u64,
    /// Number of nodes split by a cut of a Hilbert curve.
    pub curves: u64,
    /// Size of the larger side over the number of owned points of the node; the maximum over all splits.
    pub largest_split_ratio: Option<f64>,
    /// Mean of this ratio, over all splits.
    pub mean_split_ratio: Option<f64>,
    /// Number of attempts at separators, over all splits.
    pub attempts: u64,
    /// Largest number of attempts at the separator of a node.
    pub largest_attempts: u64,
    /// Mean number of attempts per split.
    pub mean_attempts: Option<f64>,
    /// Number of points whose balls meet the separator, over `m^(1 - 1/d)` for m owned points; the maximum over all
    /// splits. `None` if the run stopped early.
    pub largest_separator_ratio: Option<f64>,
    /// Mean of this ratio, over all splits.
    pub mean_separator_ratio: Option<f64>,
    /// Number of nodes that punt: too many balls cross their separators for a correction in stages (`fmt`).
    pub punts: u64,
    /// Number of well-separated pairs (`pairs`).
    pub pairs: u64,
}

/// Returns the row of the tree. Only a run that did not stop early has sizes of separators.
pub(crate) fn tree(ledger: &Ledger, has_separators: bool) -> TreeRow {
    let total = ledger.tree.total();
    let splits = total.nodes - total.leaves;
    TreeRow {
        levels: ledger.tree.levels().map(|(level, _)| level).last().unwrap_or(0),
        leaves: total.leaves,
        nodes: total.nodes,
        spheres: total.spheres,
        planes: total.planes,
        curves: total.curves,
        largest_split_ratio: total.split.largest(),
        mean_split_ratio: total.split.mean(),
        attempts: total.attempts,
        largest_attempts: total.largest_attempts,
        mean_attempts: (splits > 0).then(|| total.attempts as f64 / splits as f64),
        largest_separator_ratio: total.separator.largest().filter(|_| has_separators),
        mean_separator_ratio: total.separator.mean().filter(|_| has_separators),
        punts: total.punts,
        pairs: total.pairs,
    }
}

/// The size of the supergraph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GraphRow {
    /// Number of edges.
    pub edges: u64,
    /// Largest degree.
    pub max_degree: u64,
    /// Mean degree.
    #[serde(default)]
    pub mean_degree: f64,
    /// Number of points of all leaves, ghosts included, divided by the number of points.
    pub replication: f64,
}

/// Returns the size of the supergraph of `points` points.
pub(crate) fn graph(ledger: &Ledger, points: u64) -> GraphRow {
    let total = ledger.tree.total();
    let points = points.max(1) as f64;
    GraphRow {
        edges: total.edges,
        max_degree: total.max_degree,
        mean_degree: 2.0 * total.edges as f64 / points,
        replication: total.members as f64 / points,
    }
}

/// One level of the tree. `D` has what only reports or only lines have.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "{D}OfLevel"))]
pub struct LevelRow<D> {
    /// 0 for the root.
    pub level: u32,
    /// Number of nodes.
    pub nodes: u64,
    /// Number of leaves among them.
    #[serde(default)]
    pub leaves: u64,
    /// Number of owned points of all nodes.
    pub points: u64,
    /// Number of owned points of the largest node.
    pub largest: u64,
    /// Size of the larger side over the number of owned points of a node; the maximum over all splits.
    #[serde(default)]
    pub largest_split_ratio: Option<f64>,
    /// Number of attempts at separators.
    pub attempts: u64,
    /// Largest number of attempts at the separator of a node.
    #[serde(default)]
    pub largest_attempts: u64,
    /// Number of points whose balls meet a separator. `None` if the run stopped early.
    pub separator_points: Option<u64>,
    /// What only reports or only lines have.
    #[serde(flatten)]
    pub detail: D,
}

/// Returns the levels of the tree, beginning with the root.
pub(crate) fn levels<D>(
    ledger: &Ledger,
    has_separators: bool,
    mut detail: impl FnMut(u32, &LevelSums) -> D,
) -> Vec<LevelRow<D>> {
    let row = |(level, sums): (u32, &LevelSums)| LevelRow {
        level,
        nodes: sums.nodes,
        leaves: sums.leaves,
        points: sums.points,
        largest: sums.largest,
        largest_split_ratio: sums.split.largest(),
        attempts: sums.attempts,
        largest_attempts: sums.largest_attempts,
        separator_points: has_separators.then_some(sums.separator_points),
        detail: detail(level, sums),
    };
    ledger.tree.levels().map(row).collect()
}

#[cfg(test)]
mod tests {
    use septet_geometry::cost::Price;
    use septet_protocol::ledger::BrentCurve;

    use super::*;

    #[test]
    fn a_curve_of_bounds_is_a_map_in_reports() {
        let mut row = GroupTotal::<u64>::default();
        row.total.brent_at = BrentCurve::up_to(5);
        row.total.brent_at.add_step(Price::from_parts([9, 1, 0, 0, 0]));
        let text = serde_json::to_string(&row).unwrap();
        assert!(text.contains(r#""brent_at":{"1":9,"2":5,"4":3}"#), "{text}");
        assert_eq!(serde_json::from_str::<GroupTotal>(&text).unwrap(), row);
        let old = text.replace(r#""brent_at":{"1":9,"2":5,"4":3},"#, "");
        assert_eq!(serde_json::from_str::<GroupTotal>(&old).unwrap().total.brent_at, BrentCurve::default());
        assert!(serde_json::from_str::<GroupTotal>(&text.replace(r#""4""#, r#""3""#)).is_err());
    }
}
