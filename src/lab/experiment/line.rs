//! A line of a sweep: one run, the command that repeats it, and its counts.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use septet_core::Ending;
use septet_core::spec::{Setting, Until};
use septet_protocol::ids::ByGroup;
use septet_protocol::ledger::RoundRow;

use crate::rows::{GraphRow, GroupTotal, LevelRow, PhaseRow, TreeRow};

/// Name and version of the schema of [`Line`]. The number changes if a field changes its meaning or disappears. New
/// fields may appear under the same number.
pub const SCHEMA: &str = "septet-scale/1";

/// The program of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Program {
    /// The paper's recursion down to the leaf size, with counts.
    Simulate,
    /// `triangulate`, with times.
    Triangulate,
    /// The serial kernel without a machine or messages, with times.
    Serial,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Line {
    /// Name and version of this schema.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    pub schema: String,
    /// Version of septet.
    pub version: String,
    /// The words that identify the sweep of the run; empty for a single run.
    pub sweep: String,
    /// The command that repeats this run only; empty for a run of the library.
    pub command: String,
    /// The program.
    pub program: Program,
    /// Kind of the point set; empty for a point set of the caller.
    pub kind: String,
    /// Number of coordinates: 2 or 3.
    pub dimension: usize,
    /// Seed of the set and of every draw.
    pub seed: u64,
    /// Number of points requested.
    pub asked: u64,
    /// Number of distinct points.
    pub n: u64,
    /// Number of workers of the run.
    pub workers: u32,
    /// Largest number of points in a leaf.
    pub leaf: u64,
    /// Largest expected number of samples from which a separator is drawn.
    #[serde(default)]
    pub samples: u64,
    /// Number of great circles that are drawn for a separator.
    #[serde(default)]
    pub tries: u32,
    /// The options as requested.
    pub settings: RunOptions,
    /// The supergraph of the run, such as `density 2.5`. `None` without a supergraph, or if the run stopped early.
    pub supergraph: Option<String>,
    /// The phases that occurred.
    pub phases: Vec<PhaseRow>,
    /// The totals of the groups of phases. `None` if not counted, and for repair if the run stopped early.
    #[serde(flatten)]
    pub totals: ByGroup<Option<GroupTotal>>,
    /// The partition tree.
    pub tree: TreeRow,
    /// The levels of the tree, beginning with the root. Empty if not counted.
    pub levels: Vec<LevelRow<Splits>>,
    /// Rounds in which messages were sent or results were merged.
    pub rounds: Vec<RoundRow>,
    /// Edges, largest degree and replication of the supergraph. `None` if not counted, or if the run stopped early.
    pub graph: Option<GraphRow>,
    /// The result of a complete run. `None` if the run stopped early.
    pub end: Option<Ending>,
    /// Measured wall-clock seconds.
    pub seconds: f64,
}

/// Options of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RunOptions {
    /// A number, or `leaves`.
    pub workers: String,
    /// Whether the requested size is the number of points per worker.
    pub weak: bool,
    /// Number of threads that ran the workers.
    pub threads: usize,
    /// Lipschitz constant of graded kinds, if given.
    pub lipschitz: Option<f64>,
    /// The last phase, if the run stopped early.
    pub until: Option<Until>,
    /// The other options on which counts depend, by their keys.
    #[serde(flatten)]
    #[cfg_attr(feature = "schema", schemars(schema_with = "options"))]
    pub options: BTreeMap<String, Setting>,
}

/// Returns the schema of the options on which counts depend.
#[cfg(feature = "schema")]
fn options(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    use septet_core::spec::{Commands, Matters, options_of};
    let rows = options_of(Commands::SCALE).filter(|row| row.matters >= Matters::Counts);
    crate::option_schema::Fields::default().and(rows).object()
}

impl RunOptions {
    /// Returns an option as text, if the line has it.
    pub fn text(&self, key: &str) -> Option<String> {
        self.options.get(key).and_then(Setting::text)
    }
}

/// The split nodes of a level.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Splits {
    /// Number of nodes that were split.
    pub splits: u64,
    /// Number of owned points of the nodes that were split.
    pub split_points: u64,
    /// Depth by phase, for the nodes that were split.
    pub depth: BTreeMap<String, DepthLine>,
}

/// Depth of the split nodes of a level in a phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DepthLine {
    /// Number of nodes that were charged in this phase.
    pub nodes: u64,
    /// Sum of the depths of these nodes.
    pub sum: u64,
    /// The largest depth.
    pub largest: u64,
    /// Sum of the work of these nodes.
    pub work: u64,
}

impl Line {
    /// Returns the phase with this name, if it occurred.
    pub fn phase(&self, name: &str) -> Option<&PhaseRow> {
        self.phases.iter().find(|phase| phase.name() == name)
    }

    /// Returns a title of the run for messages.
    pub fn title(&self) -> String {
        let kind = if self.kind.is_empty() { "points" } else { &self.kind };
        format!("{} {kind}, {}D, {} workers, seed {}", self.n, self.dimension, self.workers, self.seed)
    }
}
