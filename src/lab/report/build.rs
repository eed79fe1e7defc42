//! Converts a run into its report.

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::{COORDINATOR, Group, Phase};
use septet_protocol::ledger::{Ledger, RoundKey, RoundTally, Total};

use septet_core::spec::{Nodes, Setting, Spec};
use septet_core::{Outcome, Settled};

use super::context::RunContext;
use super::parameters::SettledReport;
use super::processes::ProcessReport;
use super::schema::{
    CoordinatorReport, Fallback, HowProved, MachineReport, NodeReport, PathReport, PhaseReport, PointsReport,
    RepairReport, RoundReport, RunReport, RunSeconds, SCHEMA, SupergraphReport, TotalReport,
};
use super::{Parameters, traffic, tree};

impl RunReport {
    /// Returns the report of a run.
    pub fn of(run: &Outcome, spec: &Spec, context: &RunContext<'_>) -> RunReport {
        let counted = run.settled.counted;
        let ledger = &run.ledger;
        let points = &run.points;
        let coordinator = CoordinatorReport::of(ledger);
        RunReport {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            parameters: Parameters::of(spec, context, run.settled.leaf),
            settled: SettledReport::of(&run.settled, context),
            seed: spec.machine.seed,
            supergraph: supergraph(&run.settled),
            points: PointsReport {
                input: points.input + context.skipped,
                used: points.used,
                duplicate: points.duplicate,
                refused: points.refused + context.skipped,
            },
            space: run.space,
            dimension: run.dimension,
            simplices: run.facts.cells,
            hull_facets: run.hull_facets,
            certificate: match run.refutation {
                None => "passed".to_owned(),
                Some(refutation) => format!("failed: {refutation}"),
            },
            repair: RepairReport { rounds: run.exchange_rounds, stars: run.stars_repaired },
            fallback: run.fallback.clone().map(|(reason, points)| Fallback { reason, points }),
            how_proved: how_proved(run),
            machine: machine(run),
            plan: run.plan,
            phases: phases(run),
            critical_path: if counted { path(ledger) } else { Vec::new() },
            rounds: rounds(ledger),
            traffic: traffic::links(ledger, run.settled.workers),
            timeline: traffic::senders(ledger, run.settled.workers),
            tree: tree::summary(run),
            nodes: nodes(run, spec),
            graph: counted.then(|| tree::graph(run)),
            view: run.kept.picture.clone(),
            coordinator,
            control_bytes: coordinator.bytes_in,
            seconds: RunSeconds {
                read: context.read_seconds,
                triangulate: run.times.triangulate,
                write: context.write_seconds,
                total: context.total_seconds,
            },
            rss_before_bytes: context.rss_before_bytes,
            peak_rss_bytes: context.peak_rss_bytes,
            processes: Vec::new(),
        }
    }

    /// Adds the processes.
    #[must_use]
    pub fn with_processes(mut self, transport: &'static str, processes: Vec<ProcessReport>) -> Self {
        self.parameters.options.set("transport", Setting::Text(transport.to_owned()));
        self.processes = processes;
        self
    }
}

/// Returns every node of a counted run, unless the report leaves them out.
fn nodes(run: &Outcome, spec: &Spec) -> Option<Vec<NodeReport>> {
    let listed = || if run.settled.counted { tree::nodes(&run.ledger) } else { Vec::new() };
    (spec.keep.nodes == Nodes::All).then(listed)
}

/// Returns the supergraph of a run.
pub(super) fn supergraph(settled: &Settled) -> SupergraphReport {
    let (kind, alpha, k) = match settled.supergraph {
        Some(Supergraph::Density { alpha }) => ("density", Some(alpha), None),
        Some(Supergraph::Overlap { alpha }) => ("overlap", Some(alpha), None),
        Some(Supergraph::Knn { k }) => ("knn", None, Some(k)),
        None => ("none", None, None),
    };
    SupergraphReport { kind, alpha, k, why: settled.why.clone() }
}

impl CoordinatorReport {
    /// Sums the traffic of the coordinator over all phases.
    fn of(ledger: &Ledger) -> Self {
        let mut sums = CoordinatorReport { bytes_in: 0, bytes_out: 0 };
        for (link, traffic) in &ledger.part.links {
            sums.bytes_in += if link.to == COORDINATOR { traffic.bytes } else { 0 };
            sums.bytes_out += if link.from == COORDINATOR { traffic.bytes } else { 0 };
        }
        sums
    }
}

fn how_proved(run: &Outcome) -> HowProved {
    if run.refutation.is_some() {
        return HowProved { direct: 0, hypothesis: 0, local_radius: 0, exchange: 0 };
    }
    let certified = if run.cell_count() == 0 { 0 } else { run.points.used };
    let others = certified.saturating_sub(run.stars_local + run.stars_repaired);
    // Only the algorithm of the paper is counted, and only that algorithm has a hypothesis.
    let (direct, hypothesis) = if run.settled.counted { (0, others) } else { (others, 0) };
    HowProved { direct, hypothesis, local_radius: run.stars_local, exchange: run.stars_repaired }
}

fn machine(run: &Outcome) -> MachineReport {
    let phases = &run.ledger.phases;
    let total = |t: &Total| {
        let known = |x: u64| run.settled.counted.then_some(x);
        TotalReport {
            work: known(t.work),
            depth: known(t.depth),
            depth_log_scan: known(t.depth_log_scan),
            brent: known(t.brent),
        }
    };
    MachineReport {
        workers: run.settled.workers,
        rounds: phases.iter().map(|p| p.rounds).sum(),
        messages: phases.iter().map(|p| p.messages).sum(),
        bytes: phases.iter().map(|p| p.bytes).sum(),
        totals: run.ledger.totals.as_ref().map(total),
    }
}

/// Returns the phases that were counted or measured, in order. A phase that occurred twice has one row.
fn phases(run: &Outcome) -> Vec<PhaseReport> {
    let counted = run.settled.counted;
    let row = |phase: Phase| {
        let total = run.ledger.phases.iter().find(|t| t.phase == phase);
        let timed = run.times.phases.iter().any(|(p, _)| *p == phase);
        if total.is_none() && !timed {
            return None;
        }
        let of = |f: fn(&septet_protocol::ledger::PhaseTotal) -> u64| total.map_or(0, f);
        Some(PhaseReport {
            name: phase.name(),
            paper: phase.group() == Group::Paper,
            group: phase.group(),
            rounds: of(|t| t.rounds),
            work: counted.then(|| of(|t| t.work)),
            depth: counted.then(|| of(|t| t.depth)),
            critical_depth: counted.then(|| of(|t| t.critical_depth)),
            messages: of(|t| t.messages),
            bytes: of(|t| t.bytes),
            seconds: run.times.phases.iter().filter(|(p, _)| *p == phase).map(|(_, s)| s).sum(),
        })
    };
    Phase::ALL.into_iter().filter_map(row).collect()
}

fn path(ledger: &Ledger) -> Vec<PathReport> {
    let step = |s: &septet_protocol::ledger::PathStep| PathReport {
        subproblem: s.node.0,
        phase: s.phase.name(),
        depth: s.depth,
    };
    ledger.critical_path.iter().map(step).collect()
}

fn rounds(ledger: &Ledger) -> Vec<RoundReport> {
    let row = |(key, t): (&RoundKey, &RoundTally)| RoundReport {
        round: key.round,
        phase: key.phase.name(),
        active: t.active,
        merged: t.merged,
        points: t.points,
        largest_load: t.largest_load,
        messages: t.messages,
        bytes: t.bytes,
        largest: t.largest,
        retries: t.retries,
        separators: t.separators,
    };
    ledger.part.rounds.iter().map(row).collect()
}
