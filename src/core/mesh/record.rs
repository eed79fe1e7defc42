//! What the machine did while a mesh was made: run by run, and phase by phase of each stage.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use septet_protocol::ids::Phase;
use septet_protocol::ledger::{Ledger, NodeFacts, PhaseTotal};

use crate::run::TrafficTotal;

/// A run that takes an independent set of candidates.
pub const INDEPENDENT_SET: &str = "independent set";

/// A run that triangulates the points so far.
pub const TRIANGULATION: &str = "triangulation";

/// Does such a run count operations?
fn counts(task: &'static str) -> bool {
    task == INDEPENDENT_SET
}

/// One run of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunLine {
    /// The stage of generation that asked for it.
    pub stage: String,
    /// [`INDEPENDENT_SET`] or [`TRIANGULATION`].
    pub task: &'static str,
    /// Points or candidates given to it.
    pub points: u64,
    /// Those of them that are in the independent set from the start.
    pub fixed: u64,
    /// Levels of its partition tree.
    pub levels: u32,
    /// Leaves of the tree.
    pub leaves: u64,
    /// Points divided, summed over the nodes that were split: the levels above each point's leaf, summed over points.
    pub divided: u64,
    /// Points of the leaves with what came to them across separators, where there is a graph.
    pub members: Option<u64>,
    /// Edges of the graph.
    pub edges: Option<u64>,
    /// Rounds in which something was sent.
    pub rounds: u64,
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Operations counted; none of a triangulation, which counts none.
    pub work: Option<u64>,
    /// Steps of the longest chain, where operations are counted.
    pub depth: Option<u64>,
    /// The same of each of its phases, in order; none where operations are not counted.
    pub phases: Vec<RunPhase>,
    /// Measured seconds.
    pub seconds: f64,
}

/// What one phase of a run counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RunPhase {
    /// The phase.
    pub phase: &'static str,
    /// Operations.
    pub work: u64,
    /// Its share of the run's longest chain.
    pub depth: u64,
}

/// One phase of the machine, over all runs of a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseLine {
    /// The stage of generation.
    pub stage: String,
    /// The phase.
    pub phase: Cow<'static, str>,
    /// Runs that had it.
    pub runs: u64,
    /// Rounds in which it sent.
    pub rounds: u64,
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Operations counted, in the runs that count them.
    pub work: Option<u64>,
    /// Its share of the longest chains of those runs, which follow each other.
    pub depth: Option<u64>,
    /// Measured seconds.
    pub seconds: f64,
}

/// All runs of the machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// One by one, in order.
    pub runs: Vec<RunLine>,
    /// Phase by phase, stages in order.
    pub phases: Vec<PhaseLine>,
}

impl Record {
    /// Adds a run, of whose points so many were fixed.
    pub(super) fn add(
        &mut self,
        stage: &str,
        task: &'static str,
        [points, fixed]: [u64; 2],
        ledger: &Ledger,
        seconds: f64,
    ) {
        let TrafficTotal { rounds, messages, bytes } = TrafficTotal::of(ledger);
        let nodes = &ledger.part.nodes;
        let (leaves, inner): (Vec<_>, Vec<_>) = nodes.values().partition(|facts| facts.kind == 0);
        let of_graph =
            |count: fn(&NodeFacts) -> u64| counts(task).then(|| leaves.iter().copied().map(count).sum());
        let phase =
            |p: &PhaseTotal| RunPhase { phase: p.phase.name(), work: p.work, depth: p.critical_depth };
        self.runs.push(RunLine {
            stage: stage.to_owned(),
            task,
            points,
            fixed,
            levels: nodes.keys().map(|node| node.level()).max().unwrap_or(0),
            leaves: leaves.len() as u64,
            divided: inner.iter().map(|facts| facts.population).sum(),
            members: of_graph(|facts| facts.members),
            edges: of_graph(|facts| facts.edges),
            rounds,
            messages,
            bytes,
            work: counts(task).then(|| ledger.phases.iter().map(|p| p.work).sum()),
            depth: counts(task).then(|| ledger.phases.iter().map(|p| p.critical_depth).sum()),
            phases: ledger.phases.iter().filter(|_| counts(task)).map(phase).collect(),
            seconds,
        });
    }

    /// Adds the phases of a run, those that were counted or measured.
    pub(super) fn add_phases(
        &mut self,
        stage: &str,
        task: &'static str,
        ledger: &Ledger,
        seconds: &[(Phase, f64)],
    ) {
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
                if counts(task) {
                    *line.work.get_or_insert(0) += total.work;
                    *line.depth.get_or_insert(0) += total.critical_depth;
                }
            }
        }
    }

    fn phase(&mut self, stage: &str, phase: &'static str) -> &mut PhaseLine {
        let at = self.phases.iter().position(|l| l.stage == stage && l.phase == phase);
        let at = at.unwrap_or_else(|| {
            self.phases.push(PhaseLine {
                stage: stage.to_owned(),
                phase: phase.into(),
                ..PhaseLine::default()
            });
            self.phases.len() - 1
        });
        &mut self.phases[at]
    }
}
