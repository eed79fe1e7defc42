//! Converts a run into its report.

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::ledger::Ledger;

use septet_core::spec::{Nodes, Setting, Spec};
use septet_core::{Outcome, Settled, TrafficTotal};

use super::context::RunContext;
use super::input::InputReport;
use super::parameters::SettledReport;
use super::periodic::PeriodicReport;
use super::processes::ProcessReport;
use super::schema::{
    CoordinatorReport, Fallback, HowProved, MachineReport, PointsReport, RepairReport, RunReport, RunSeconds,
    SCHEMA, SupergraphReport,
};
use super::stats::StatsReport;
use super::{Parameters, traffic, tree};
use crate::rows::{self, GroupTotal, NodeRow, PhaseRow};

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
                hidden: points.hidden,
            },
            input: InputReport::of(context, points.duplicate),
            periodic: PeriodicReport::of(run, spec),
            space: run.space,
            dimension: run.dimension,
            simplices: run.facts.cells,
            hull_facets: run.hull_facets,
            stats: context.stats.map(StatsReport::of),
            certificate: match run.refutation {
                None => "passed".to_owned(),
                Some(refutation) => format!("failed: {refutation}"),
            },
            repair: repair(run),
            fallback: run.fallback.clone().map(|(reason, points)| Fallback { reason, points }),
            how_proved: how_proved(run),
            machine: machine(run),
            plan: run.plan,
            phases: phases(run),
            critical_path: if counted { ledger.critical_path.clone() } else { Vec::new() },
            rounds: rows::rounds(ledger).collect(),
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

    /// Whether the points have weights.
    pub fn has_weights(&self) -> bool {
        self.points.hidden.is_some()
    }

    /// Adds the processes.
    #[must_use]
    pub fn with_processes(mut self, transport: &'static str, processes: Vec<ProcessReport>) -> Self {
        self.parameters.options.set("transport", &Setting::Text(transport.to_owned()));
        self.processes = processes;
        self
    }
}

/// Returns every node of a counted run, unless the report leaves them out.
fn nodes(run: &Outcome, spec: &Spec) -> Option<Vec<NodeRow>> {
    let listed = || if run.settled.counted { rows::nodes(&run.ledger) } else { Vec::new() };
    (spec.keep.nodes == Nodes::All).then(listed)
}

/// Returns the supergraph of a run.
pub(super) fn supergraph(settled: &Settled) -> SupergraphReport {
    let (kind, alpha, k) = match settled.supergraph {
        Some(Supergraph::Density { alpha }) => ("density", Some(alpha), None),
        Some(Supergraph::Overlap { alpha, k }) => ("overlap", Some(alpha), Some(k)),
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

fn repair(run: &Outcome) -> RepairReport {
    let rounds = || run.ledger.part.rounds.values();
    RepairReport {
        rounds: run.exchange_rounds,
        stars: run.stars_repaired,
        probes: rounds().map(|tally| tally.probes).sum(),
        probe_visits: rounds().map(|tally| tally.probe_visits).sum(),
    }
}

fn how_proved(run: &Outcome) -> HowProved {
    if run.refutation.is_some() {
        return HowProved { direct: 0, hypothesis: 0, local_radius: 0, exchange: 0 };
    }
    let certified = if run.cell_count() == 0 { 0 } else { run.stars };
    let others = certified.saturating_sub(run.stars_local + run.stars_repaired);
    // Only the algorithm of the paper is counted, and only that algorithm has a hypothesis.
    let (direct, hypothesis) = if run.settled.counted { (0, others) } else { (others, 0) };
    HowProved { direct, hypothesis, local_radius: run.stars_local, exchange: run.stars_repaired }
}

fn machine(run: &Outcome) -> MachineReport {
    let counted = run.settled.counted;
    let known = |group: GroupTotal| GroupTotal { total: group.total.known(counted), traffic: group.traffic };
    let whole = GroupTotal {
        total: run.ledger.totals.sum(),
        traffic: TrafficTotal::of_phases(
            run.ledger.phases.iter().filter(|total| total.phase.group().counts_work()),
        ),
    };
    MachineReport {
        workers: run.settled.workers,
        total: known(whole),
        traffic: TrafficTotal::of(&run.ledger),
        totals: rows::groups(&run.ledger).map(known),
    }
}

fn phases(run: &Outcome) -> Vec<PhaseRow<Option<u64>>> {
    let counted = run.settled.counted;
    let known = |row: PhaseRow| PhaseRow { total: row.total.known(counted), seconds: row.seconds };
    rows::phases(&run.ledger, &run.times.phases).into_iter().map(known).collect()
}
