//! A line of a sweep: one run, what it takes to make it again, and its counts.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use septet_core::config::Until;
use septet_core::run::count::Ending;

/// Name and version of the schema of [`Line`]. The number changes when a field changes its meaning or
/// disappears; new fields may appear under the same number.
pub const SCHEMA: &str = "septet-scale/1";

/// What was run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Program {
    /// The paper's recursion to its floor, counted.
    Simulate,
    /// `triangulate`, timed.
    Triangulate,
    /// The serial kernel alone: no machine, no message; timed.
    Serial,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// [`SCHEMA`].
    pub schema: String,
    /// Version of septet.
    pub version: String,
    /// The words of the sweep it belongs to; empty for a single run.
    pub sweep: String,
    /// The command that makes it again, alone; empty for a run of the library's.
    pub command: String,
    /// What was run.
    pub program: Program,
    /// Kind of the set; empty for points of the caller's.
    pub kind: String,
    /// 2 or 3.
    pub dimension: usize,
    /// Seed of the set and of every draw.
    pub seed: u64,
    /// Points asked for.
    pub asked: u64,
    /// Distinct points.
    pub n: u64,
    /// Workers, as settled.
    pub workers: u32,
    /// Largest leaf, as settled.
    pub leaf: u64,
    /// The options, as asked for.
    pub settings: Settings,
    /// The supergraph settled on, such as `density 2.5`; none if none was built.
    pub supergraph: Option<String>,
    /// Phase by phase, those that occurred.
    pub phases: Vec<PhaseLine>,
    /// The paper's phases together; none where not counted.
    pub paper: Option<Spread>,
    /// The phases of agreement and repair together.
    pub repair: Option<Spread>,
    /// The partition tree.
    pub tree: TreeLine,
    /// Its levels, the root first.
    pub levels: Vec<LevelLine>,
    /// Rounds in which something moved.
    pub rounds: Vec<RoundLine>,
    /// Edges, largest degree and replication of the supergraph; none if none was built.
    pub graph: Option<GraphLine>,
    /// What a whole run left; none if it stopped before.
    pub end: Option<Ending>,
    /// Measured wall-clock seconds.
    pub seconds: f64,
}

/// Options of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// A number, or `leaves`.
    pub workers: String,
    /// Was the size meant for each worker?
    pub weak: bool,
    /// Threads that ran the workers.
    pub threads: usize,
    /// `density`, `overlap` or `knn`.
    pub supergraph: String,
    /// A number, or `auto`.
    pub alpha: String,
    /// A number, `auto`, or a factor of ln n such as `10ln`.
    pub k: String,
    /// `both`, `smaller` or `ghost`.
    pub separator_sets: String,
    /// `sphere` or `kd`.
    #[serde(default)]
    pub partition: String,
    /// `descent` or `naive`.
    #[serde(default)]
    pub neighbours: String,
    /// A number, or `auto`.
    pub leaf: String,
    /// `channel` or `sim`.
    pub transport: String,
    /// Seed of the order of delivery, `sim` only.
    pub delivery_seed: Option<u64>,
    /// Lipschitz constant of graded kinds, if given.
    pub lipschitz: Option<f64>,
    /// The last phase, if the run stopped early.
    pub until: Option<Until>,
}

/// One phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseLine {
    /// Its name.
    pub name: String,
    /// Is it one of the paper's?
    pub paper: bool,
    /// Is it one of repair's?
    pub repair: bool,
    /// Rounds in which it sent.
    pub rounds: u64,
    /// Operations.
    pub work: u64,
    /// Its longest chain by itself, a scan counting one.
    pub depth: u64,
    /// The same with a scan of m items counting `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Its share of the run's longest chain.
    pub critical_depth: u64,
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Measured wall-clock seconds.
    pub seconds: f64,
}

/// Totals of a group of phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spread {
    /// Operations.
    pub work: u64,
    /// The longest chain, a scan counting one.
    pub depth: u64,
    /// The same with a scan of m items counting `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Brent's bound on the steps with as many processors as points.
    pub brent: u64,
    /// Rounds.
    pub rounds: u64,
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// The partition tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TreeLine {
    /// Levels below the root.
    pub levels: u32,
    /// Leaves.
    pub leaves: u64,
    /// Nodes, leaves included.
    pub nodes: u64,
    /// Nodes split by a plane.
    pub planes: u64,
    /// Attempts at separators, of all splits.
    pub attempts: u64,
    /// Larger home side over home points, the largest of all splits.
    pub largest_split_ratio: f64,
    /// Points whose ball meets the separator over `m^(1 - 1/d)`, the largest of all splits; none if the run
    /// stopped before it counted them.
    pub largest_separator_ratio: Option<f64>,
}

/// One level of the tree.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LevelLine {
    /// 0 for the root.
    pub level: u32,
    /// Nodes.
    pub nodes: u64,
    /// Nodes that were split.
    pub splits: u64,
    /// Home points of all nodes.
    pub points: u64,
    /// Home points of the nodes that were split.
    pub split_points: u64,
    /// Home points of the largest node.
    pub largest: u64,
    /// Attempts at separators.
    pub attempts: u64,
    /// Points whose balls meet a separator; none if the run stopped before it counted them.
    pub separator_points: Option<u64>,
    /// Depth by phase, over the nodes that were split.
    pub depth: BTreeMap<String, DepthLine>,
}

/// Depth of the split nodes of a level in a phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DepthLine {
    /// Nodes charged.
    pub nodes: u64,
    /// Sum of their depths.
    pub sum: u64,
    /// The largest.
    pub largest: u64,
    /// Sum of their work.
    pub work: u64,
}

/// One round.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RoundLine {
    /// Its number.
    pub round: u32,
    /// The phase it belongs to.
    pub phase: String,
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
}

/// Size of the supergraph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GraphLine {
    /// Edges.
    pub edges: u64,
    /// Largest degree.
    pub max_degree: u64,
    /// Points held by all leaves over points.
    pub replication: f64,
}

impl Line {
    /// The phase of this name, if it occurred.
    pub fn phase(&self, name: &str) -> Option<&PhaseLine> {
        self.phases.iter().find(|phase| phase.name == name)
    }

    /// What names the run in a message.
    pub fn title(&self) -> String {
        let kind = if self.kind.is_empty() { "points" } else { &self.kind };
        format!("{} {kind}, {}D, {} workers, seed {}", self.n, self.dimension, self.workers, self.seed)
    }
}
