//! The log of the machine during the generation of a mesh: by runs, and by stages and phases.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use septet_protocol::ids::Phase;
use septet_protocol::ledger::{Ledger, NodeFacts, PhaseTotal};

use crate::result::outcome::TrafficTotal;

/// The task of a run that selects an independent set of candidates.
pub const INDEPENDENT_SET: &str = "independent set";

/// The task of a run that triangulates the current points.
pub const TRIANGULATION: &str = "triangulation";

/// The task of a run in which the ranks evaluate a part of Section 5 at cells, sites or simplices.
pub const EVALUATION: &str = "evaluation";

/// Returns `true` if runs of this task have a graph.
fn has_graph(task: &'static str) -> bool {
    task == INDEPENDENT_SET
}

/// Returns the depth of a phase: its share of the longest chain, or its own depth if its group is in no chain.
pub(super) fn depth_of(total: &PhaseTotal) -> u64 {
    if total.phase.group().counts_work() { total.critical_depth } else { total.depth }
}

/// One run of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RunLine {
    /// The stage of generation that started the run.
    pub stage: String,
    /// [`INDEPENDENT_SET`], [`TRIANGULATION`] or [`EVALUATION`].
    pub task: &'static str,
    /// The number of input points or candidates, or of items of the first level of an evaluation.
    pub points: u64,
    /// The number of these points that are fixed members of the independent set.
    pub fixed: u64,
    /// Levels of its partition tree.
    pub levels: u32,
    /// Leaves of the tree.
    pub leaves: u64,
    /// Points divided, summed over the split nodes. Equals the number of levels above the leaf of a point, summed over
    /// all points.
    pub divided: u64,
    /// Points of the leaves, including their ghosts, if the run has a graph.
    pub members: Option<u64>,
    /// Edges of the graph, if the run has one.
    pub edges: Option<u64>,
    /// Rounds in which messages were sent.
    pub rounds: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
    /// Operations counted.
    pub work: u64,
    /// Steps of the longest chain.
    pub depth: u64,
    /// Counts of each phase, in order.
    pub phases: Vec<RunPhase>,
    /// Measured seconds.
    pub seconds: f64,
}

/// The counts of one phase of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RunPhase {
    /// The phase.
    pub phase: &'static str,
    /// Operations.
    pub work: u64,
    /// Its share of the longest chain of the run.
    pub depth: u64,
}

/// One phase of the machine, over all runs of a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StagePhase {
    /// The stage of generation.
    pub stage: String,
    /// The phase.
    pub phase: Cow<'static, str>,
    /// The number of runs with this phase.
    pub runs: u64,
    /// Rounds in which the phase sent messages.
    pub rounds: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
    /// Operations, summed over the runs.
    pub work: u64,
    /// Its share of the longest chains of these runs, summed because the runs are sequential.
    pub depth: u64,
    /// Measured seconds.
    pub seconds: f64,
}

/// The sizes of a run's input.
#[derive(Clone, Copy, Debug)]
pub(super) struct SiteCounts {
    /// Points or candidates.
    pub(super) points: u64,
    /// Points among them that the run keeps fixed.
    pub(super) fixed: u64,
}

/// All runs of the machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunLog {
    /// The runs in order.
    pub runs: Vec<RunLine>,
    /// The phases of each stage, in the order of the stages.
    pub phases: Vec<StagePhase>,
}

impl RunLog {
    /// Adds a run.
    pub(super) fn add(
        &mut self,
        stage: &str,
        task: &'static str,
        sites: SiteCounts,
        ledger: &Ledger,
        seconds: f64,
    ) {
        let TrafficTotal { rounds, messages, bytes } = TrafficTotal::of(ledger);
        let nodes = &ledger.part.nodes;
        let (leaves, inner): (Vec<_>, Vec<_>) = nodes.values().partition(|facts| facts.is_leaf());
        let of_graph =
            |count: fn(&NodeFacts) -> u64| has_graph(task).then(|| leaves.iter().copied().map(count).sum());
        let phase = |p: &PhaseTotal| RunPhase { phase: p.phase.name(), work: p.work, depth: depth_of(p) };
        self.runs.push(RunLine {
            stage: stage.to_owned(),
            task,
            points: sites.points,
            fixed: sites.fixed,
            levels: nodes.keys().map(|node| node.level()).max().unwrap_or(0),
            leaves: leaves.len() as u64,
            divided: inner.iter().map(|facts| facts.population).sum(),
            members: of_graph(|facts| facts.members),
            edges: of_graph(|facts| facts.edges),
            rounds,
            messages,
            bytes,
            work: ledger.phases.iter().map(|p| p.work).sum(),
            depth: ledger.phases.iter().map(depth_of).sum(),
            phases: ledger.phases.iter().map(phase).collect(),
            seconds,
        });
    }

    /// Adds the phases of a run that have counts or times.
    pub(super) fn add_phases(&mut self, stage: &str, ledger: &Ledger, seconds: &[(Phase, f64)]) {
        for phase in Phase::ALL {
            let total = ledger.phases.iter().find(|t| t.phase == phase);
            let timed = seconds.iter().filter(|(p, _)| *p == phase);
            if total.is_none() && timed.clone().next().is_none() {
                continue;
            }
            let line = self.phase(stage, phase.name());
            line.runs += 1;
            line.seconds += timed.map(|(_, s)| s).sum::<f64>();
            if let Some(total) = total {
                line.rounds += total.rounds;
                line.messages += total.messages;
                line.bytes += total.bytes;
                line.work += total.work;
                line.depth += depth_of(total);
            }
        }
    }

    /// Adds a line for a phase of a stage, without counts.
    pub(super) fn begin(&mut self, stage: &str, phase: Phase) {
        self.phase(stage, phase.name());
    }

    /// Returns Brent's bound on the steps of all runs with this number of processors: `ceil((W - D) / p) + D` for each
    /// phase of each run, summed because the runs are sequential.
    pub fn brent(&self, processors: u64) -> u64 {
        let phases = self.runs.iter().flat_map(|run| &run.phases);
        phases.map(|p| p.work.saturating_sub(p.depth).div_ceil(processors.max(1)) + p.depth).sum()
    }

    fn phase(&mut self, stage: &str, phase: &'static str) -> &mut StagePhase {
        let at = self.phases.iter().position(|l| l.stage == stage && l.phase == phase);
        let at = at.unwrap_or_else(|| {
            self.phases.push(StagePhase {
                stage: stage.to_owned(),
                phase: phase.into(),
                ..StagePhase::default()
            });
            self.phases.len() - 1
        });
        &mut self.phases[at]
    }
}
