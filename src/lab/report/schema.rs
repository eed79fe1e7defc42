//! The schema, field by field. README.md says the same for readers of the JSON.

use septet_protocol::tasks::TaskLog;
use serde::Serialize;

use septet_core::result::view::View;
use septet_core::run::TrafficTotal;

use super::Parameters;
use super::traffic::{TimelineReport, TrafficReport};

/// Name and version of the schema of [`Report`]. The number changes when a field changes its meaning or
/// disappears; new fields may appear under the same number.
pub const SCHEMA: &str = "septet-run/1";

/// Everything there is to say about a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Version of septet.
    pub version: &'static str,
    /// Every option.
    pub parameters: Parameters,
    /// Seed of every random draw.
    pub seed: u64,
    /// The supergraph that was used; none for `triangulate`, or if there was nothing to triangulate.
    pub supergraph: SupergraphReport,
    /// What became of the input points.
    pub points: PointsReport,
    /// Number of coordinates: 2 or 3.
    pub space: usize,
    /// Dimension of the points' affine hull, -1 for no points; below `space` there are no simplices.
    pub dimension: isize,
    /// Number of triangles or tetrahedra.
    pub simplices: u64,
    /// Number of facets of the convex hull.
    pub hull_facets: u64,
    /// `passed`, or `failed: ` and what is wrong with the stars; then there are no simplices.
    pub certificate: String,
    /// The exchange between stars that did not agree.
    pub repair: RepairReport,
    /// Regions gathered because the exchange was cut short.
    pub fallback: Option<Fallback>,
    /// What proved the stars.
    pub how_proved: HowProved,
    /// Totals of the machine.
    pub machine: MachineReport,
    /// What the machine sent before, to count the leaves for `--workers leaves`; not in the totals.
    pub plan: Option<TrafficTotal>,
    /// Phase by phase.
    pub phases: Vec<PhaseReport>,
    /// The longest chain of subproblems; depths add up to `machine.paper.depth`. Empty if not counted.
    pub critical_path: Vec<PathReport>,
    /// Round by round.
    pub rounds: Vec<RoundReport>,
    /// Who sent to whom, phase by phase.
    pub traffic: TrafficReport,
    /// Who sent, round by round.
    pub timeline: TimelineReport,
    /// The partition tree; in `triangulate` the part above one worker.
    pub tree: TreeReport,
    /// Every node of the tree, by id. Empty if not counted.
    pub nodes: Vec<NodeReport>,
    /// The supergraph's size; none if not counted.
    pub graph: Option<GraphReport>,
    /// Sampled points and the tree, for pictures; none if not asked for.
    pub view: Option<View>,
    /// Bytes received by the coordinator less reading and merging.
    pub control_bytes: u64,
    /// Measured wall-clock seconds.
    pub seconds: Seconds,
    /// Measured resident memory before the run, points read.
    pub rss_before_bytes: Option<u64>,
    /// Measured peak of resident memory.
    pub peak_rss_bytes: Option<u64>,
    /// What leaves have to say to each other, free of the number of workers; if asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tasks: Option<TaskLog>,
}

/// The supergraph.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SupergraphReport {
    /// `density`, `overlap`, `knn`, or `none`.
    pub kind: &'static str,
    /// alpha, if it has one.
    pub alpha: Option<f64>,
    /// k, if it has one.
    pub k: Option<u32>,
    /// Why this one.
    pub why: String,
}

/// What became of the input points: `input = used + duplicate + refused`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PointsReport {
    /// Points in the input.
    pub input: u64,
    /// Vertices.
    pub used: u64,
    /// Points that coincide with one of smaller index.
    pub duplicate: u64,
    /// Invalid points, dropped.
    pub refused: u64,
}

/// The exchange between stars.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RepairReport {
    /// Rounds of exchange.
    pub rounds: u64,
    /// Stars it changed.
    pub stars: u64,
}

/// Regions triangulated in one piece.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fallback {
    /// Why.
    pub reason: String,
    /// Number of points.
    pub points: u64,
}

/// Number of stars by what proved them; they add up to `points.used`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct HowProved {
    /// By the supergraph alone, as the paper supposes, and the certificate; in `triangulate` by the pieces alone.
    pub hypothesis: u64,
    /// By a ball of the known radius.
    pub local_radius: u64,
    /// Changed by the exchange.
    pub exchange: u64,
}

/// Totals of the machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MachineReport {
    /// Number of workers.
    pub workers: u32,
    /// Rounds in which messages were sent.
    pub rounds: u64,
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// The paper's phases.
    pub paper: TotalReport,
    /// The phases of agreement and repair.
    pub repair: TotalReport,
}

/// Work and depth of the model (an EREW PRAM with unit-time scans); none where not counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TotalReport {
    /// Operations.
    pub work: Option<u64>,
    /// Steps on the longest chain, a scan counting one.
    pub depth: Option<u64>,
    /// The same with a scan of m items counting `ceil(log2 m)`.
    pub depth_log_scan: Option<u64>,
    /// Brent's bound on the steps with as many processors as points.
    pub brent: Option<u64>,
}

/// One phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseReport {
    /// Its name.
    pub name: &'static str,
    /// Is it one of the paper's?
    pub paper: bool,
    /// Rounds in which it sent.
    pub rounds: u64,
    /// Operations; none where not counted.
    pub work: Option<u64>,
    /// Its longest chain by itself.
    pub depth: Option<u64>,
    /// Its share of the critical path.
    pub critical_depth: Option<u64>,
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Measured wall-clock seconds.
    pub seconds: f64,
}

/// One link of the critical path.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PathReport {
    /// Path number of the node: the root is 1, the children of s are 2s (inside) and 2s + 1.
    pub subproblem: u64,
    /// The phase.
    pub phase: &'static str,
    /// Steps spent there.
    pub depth: u64,
}

/// One round.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RoundReport {
    /// Its number.
    pub round: u32,
    /// The phase it belongs to.
    pub phase: &'static str,
    /// Subproblems whose leader acted.
    pub active: u64,
    /// Results merged from two children.
    pub merged: u64,
    /// Points shipped.
    pub points: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
    /// Bytes of the longest message.
    pub largest: u64,
    /// Separators drawn again.
    pub retries: u64,
    /// Separators drawn.
    pub separators: u64,
}

/// The partition tree. Ratios are none if nothing was split.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TreeReport {
    /// Levels below the root: 0 for a single leaf.
    pub levels: u32,
    /// Number of leaves.
    pub leaves: u64,
    /// Number of nodes, leaves included.
    pub nodes: u64,
    /// Nodes split by a sphere.
    pub spheres: u64,
    /// Nodes split by a plane.
    pub planes: u64,
    /// Larger home side over home points, the largest of all nodes.
    pub largest_split_ratio: Option<f64>,
    /// The mean.
    pub mean_split_ratio: Option<f64>,
    /// Most attempts at a separator.
    pub largest_attempts: u64,
    /// Mean attempts.
    pub mean_attempts: Option<f64>,
    /// Points whose ball meets the separator over `m^(1 - 1/d)`, m the node's home points: the largest.
    pub largest_separator_ratio: Option<f64>,
    /// The mean.
    pub mean_separator_ratio: Option<f64>,
    /// Level by level.
    pub by_level: Vec<LevelReport>,
}

/// One level of the tree.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LevelReport {
    /// 0 for the root.
    pub level: u32,
    /// Nodes.
    pub nodes: u64,
    /// Leaves among them.
    pub leaves: u64,
    /// Home points of all nodes.
    pub points: u64,
    /// Home points of the largest.
    pub largest: u64,
    /// Largest split ratio.
    pub largest_split_ratio: Option<f64>,
    /// Most attempts at a separator.
    pub largest_attempts: u64,
    /// Points whose balls meet a separator.
    pub separator_points: u64,
    /// Largest depth of a node in the phase `partition`; none where not counted.
    pub partition_depth: Option<u64>,
    /// The same in the phase `neighbours`.
    pub neighbours_depth: Option<u64>,
    /// The same in the phase `merge`.
    pub merge_depth: Option<u64>,
}

/// One node of the tree.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NodeReport {
    /// Path number.
    pub id: u64,
    /// Levels below the root.
    pub level: u32,
    /// Home points.
    pub population: u64,
    /// Home points inside the separator, 0 for a leaf.
    pub inside: u64,
    /// Attempts at a separator.
    pub attempts: u64,
    /// `leaf`, `sphere` or `plane`.
    pub kind: &'static str,
    /// Home points inside whose ball meets the separator.
    pub crossing_inside: u64,
    /// The same outside.
    pub crossing_outside: u64,
    /// Points that the leaf holds in the graph phase: home, ghosts, separator points.
    pub members: u64,
    /// Edges of the supergraph with the smaller end at home in the leaf.
    pub edges: u64,
}

/// Size of the supergraph.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GraphReport {
    /// Number of edges.
    pub edges: u64,
    /// Order-free hash of all edges, hexadecimal.
    pub edge_hash: String,
    /// Largest degree.
    pub max_degree: u64,
    /// Mean degree.
    pub mean_degree: f64,
    /// Points held by all leaves over points.
    pub replication: f64,
}

/// Measured wall-clock seconds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Seconds {
    /// Reading or generating the input.
    pub read: f64,
    /// From points in memory to certified stars.
    pub triangulate: f64,
    /// Writing the outputs.
    pub write: f64,
    /// All of it.
    pub total: f64,
}
