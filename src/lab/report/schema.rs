//! The schema of the report, field by field.

use std::collections::BTreeMap;

use serde::Serialize;

use septet_core::TrafficTotal;
use septet_core::result::view::View;
use septet_protocol::ids::ByGroup;
use septet_protocol::ledger::{PathStep, RoundRow};

use super::input::InputReport;
use super::periodic::PeriodicReport;
use super::processes::ProcessReport;
use super::stats::StatsReport;
use super::traffic::{TimelineReport, TrafficReport};
use super::{Parameters, SettledReport};
use crate::rows::{GraphRow, GroupTotal, LevelRow, NodeRow, PhaseRow, TreeRow};

/// Name and version of the schema of [`RunReport`]. The number changes if a field changes its meaning or disappears.
/// New fields may appear under the same number.
pub const SCHEMA: &str = "septet-run/2";

/// The report of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RunReport {
    /// Name and version of this schema.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    pub schema: &'static str,
    /// Version of septet.
    pub version: &'static str,
    /// All options of the run.
    pub parameters: Parameters,
    /// The options that the run settled, as it used them.
    pub settled: SettledReport,
    /// Seed of every random draw.
    pub seed: u64,
    /// The supergraph of the run. Its kind is `none` for `triangulate` in dimensions 2 and 3, and if there was nothing to triangulate.
    pub supergraph: SupergraphReport,
    /// The input points, counted by use.
    pub points: PointsReport,
    /// What was read of the files of the input; absent for a sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<InputReport>,
    /// The periodic box and the triangulation in it; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periodic: Option<PeriodicReport>,
    /// Number of coordinates: 2 to 6.
    pub space: usize,
    /// Dimension of the affine hull of the points; -1 for no points. If it is below `space`, there are no simplices.
    pub dimension: isize,
    /// Number of cells: triangles, tetrahedra or simplices of a higher dimension.
    pub simplices: u64,
    /// Number of facets of the convex hull.
    pub hull_facets: u64,
    /// The numbers of the triangulation; absent unless requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stats: Option<StatsReport>,
    /// `passed`, or `failed: ` and the reason. If it failed, there are no simplices.
    pub certificate: String,
    /// The splaying of stars that disagree.
    pub repair: RepairReport,
    /// Points that were gathered because splaying was stopped early.
    pub fallback: Option<Fallback>,
    /// Number of stars by kind of proof.
    pub how_proved: HowProved,
    /// Totals of the machine.
    pub machine: MachineReport,
    /// Traffic of the planning run for `--workers leaves`. The totals do not include it.
    pub plan: Option<TrafficTotal>,
    /// The phases in order.
    pub phases: Vec<PhaseRow<Option<u64>>>,
    /// The longest chain of subproblems. Its depths add up to `machine.paper.depth`. Empty if not counted.
    pub critical_path: Vec<PathStep>,
    /// The rounds in order.
    pub rounds: Vec<RoundRow>,
    /// Messages by phase, sender and receiver.
    pub traffic: TrafficReport,
    /// Messages by round and sender.
    pub timeline: TimelineReport,
    /// The partition tree; for `triangulate`, the part that several workers share.
    pub tree: TreeReport,
    /// Every node of the tree, by id. Empty if not counted, absent if the report leaves them out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<Vec<NodeRow>>,
    /// The size of the supergraph. `None` if not counted.
    pub graph: Option<GraphReport>,
    /// Sampled points and the tree, for pictures. `None` if not requested.
    pub view: Option<View>,
    /// The traffic of the coordinator, over all phases.
    pub coordinator: CoordinatorReport,
    /// The same as `coordinator.bytes_in`.
    pub control_bytes: u64,
    /// Measured wall-clock seconds.
    pub seconds: RunSeconds,
    /// Measured resident memory before the run, with the points in memory.
    pub rss_before_bytes: Option<u64>,
    /// Measured peak of resident memory.
    pub peak_rss_bytes: Option<u64>,
    /// The processes; absent if there is one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub processes: Vec<ProcessReport>,
}

/// The traffic of the coordinator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CoordinatorReport {
    /// Bytes of all messages to the coordinator.
    pub bytes_in: u64,
    /// Bytes of all messages from the coordinator.
    pub bytes_out: u64,
}

/// The supergraph.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SupergraphReport {
    /// `density`, `overlap`, `knn`, or `none`.
    pub kind: &'static str,
    /// alpha, if the graph has one.
    pub alpha: Option<f64>,
    /// k, if the graph has one: the number of nearest neighbours, or the neighbour to which the balls of an overlap graph
    /// extend.
    pub k: Option<u32>,
    /// The reason for the choice of this supergraph.
    pub why: String,
}

/// The input points, counted by use: `input = used + duplicate + refused`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PointsReport {
    /// Number of points in the input.
    pub input: u64,
    /// Number of vertices.
    pub used: u64,
    /// Number of points that coincide with a point of smaller index.
    pub duplicate: u64,
    /// Number of invalid points, which were dropped.
    pub refused: u64,
    /// Number of hidden points, which their weights exclude from the triangulation; absent if the points have no weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hidden: Option<u64>,
}

/// Splaying of stars.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RepairReport {
    /// Number of rounds of splaying.
    pub rounds: u64,
    /// Number of stars that splaying changed.
    pub stars: u64,
    /// Number of cells that asked the leaf of their circumcentre for a point.
    pub probes: u64,
    /// Number of visits of these cells to leaves.
    pub probe_visits: u64,
}

/// Points that were gathered and triangulated at once.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Fallback {
    /// The reason.
    pub reason: String,
    /// Number of points.
    pub points: u64,
}

/// Number of stars by kind of proof; the numbers add up to the points with stars: `points.used`,
/// hidden points, and images of both in a periodic box.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HowProved {
    /// Stars of `triangulate`, which needs no hypothesis: the certificate over exact subdomain triangulations proves
    /// them. 0 for `simulate`.
    pub direct: u64,
    /// Stars of `simulate` proved by the certificate and the supergraph alone, as the paper assumes.
    pub hypothesis: u64,
    /// Unchanged stars whose circumspheres all lie in the ball of the known radius around the vertex.
    pub local_radius: u64,
    /// Stars changed by splaying.
    pub exchange: u64,
}

/// Totals of the machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MachineReport {
    /// Number of workers.
    pub workers: u32,
    /// The messages of all phases.
    #[serde(flatten)]
    pub traffic: TrafficTotal,
    /// The sum of the groups of phases.
    pub total: GroupTotal<Option<u64>>,
    /// The totals of the groups of phases. Work and depth are those of the model (an EREW PRAM with unit-time scans).
    #[serde(flatten)]
    pub totals: ByGroup<GroupTotal<Option<u64>>>,
}

/// The partition tree.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TreeReport {
    /// Largest expected number of samples from which a separator is drawn. `None` for `triangulate`, whose separators
    /// are balanced.
    pub samples: Option<u64>,
    /// Number of great circles that are drawn for a separator. `None` for `triangulate`.
    pub tries: Option<u32>,
    /// The nodes and their separators.
    #[serde(flatten)]
    pub tree: TreeRow,
    /// The levels, beginning with the root.
    pub by_level: Vec<LevelRow<LevelDepths>>,
}

/// The largest depths of the nodes of a level.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LevelDepths {
    /// Largest depth of a node in the phase `partition`. `None` if not counted.
    pub partition_depth: Option<u64>,
    /// Largest depth of a node in the phase `neighbours`. `None` if not counted.
    pub neighbours_depth: Option<u64>,
    /// Largest depth of a node in the phase `merge`. `None` if not counted.
    pub merge_depth: Option<u64>,
    /// Largest depth of a node in each phase that charged nodes of the level, by name. Empty if not counted.
    pub depths: BTreeMap<&'static str, u64>,
}

/// The supergraph.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GraphReport {
    /// The size.
    #[serde(flatten)]
    pub size: GraphRow,
    /// Hash of all edges, independent of their order, in hexadecimal.
    pub edge_hash: String,
}

/// Measured wall-clock seconds.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RunSeconds {
    /// Reading or generating the input.
    pub read: f64,
    /// From points in memory to certified stars.
    pub triangulate: f64,
    /// Writing the outputs.
    pub write: f64,
    /// The whole command.
    pub total: f64,
}
