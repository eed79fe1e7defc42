//! Cost traces as JSON lines.

use std::io::{self, Write};

use serde::Serialize;

use septet_core::Settled;
use septet_core::run::{CostRow, CostTrace};
use septet_core::spec::{Spec, Words};
use septet_geometry::cost::{Call, LaneStep, Step, Tape};
use septet_protocol::ledger::{Ledger, Total};

use super::SupergraphReport;
use super::build::supergraph;
use crate::accounts::{ReportedCounts, ReportedPhase, ReportedTotal, ReportedTotals, SCHEMA};

/// The first line of a cost trace: the version, the size of the run, and the parameters on which the counts depend.
#[derive(Clone, Debug, Serialize)]
pub struct CostHeader {
    schema: &'static str,
    version: &'static str,
    points: u64,
    dimension: usize,
    seed: u64,
    workers: u32,
    constants: &'static str,
    leaf: u64,
    samples: u64,
    tries: u32,
    supergraph: SupergraphReport,
    separator_sets: &'static str,
    partition: &'static str,
    neighbours: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    fault: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exchange_cap: Option<u32>,
    rows: u64,
}

impl CostHeader {
    /// Returns the header of a run over `points` distinct points.
    pub fn of(spec: &Spec, settled: &Settled, points: u64, dimension: usize) -> Self {
        CostHeader {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            points,
            dimension,
            seed: spec.machine.seed,
            workers: settled.workers,
            constants: spec.tree.constants.purpose.name(),
            leaf: settled.leaf,
            samples: settled.samples,
            tries: settled.tries,
            supergraph: supergraph(settled),
            separator_sets: spec.recursion.sets.name(),
            partition: spec.tree.partition.name(),
            neighbours: spec.recursion.neighbours.name(),
            fault: spec.planted.fault.map(|fault| fault.to_string()),
            exchange_cap: spec.planted.exchange_cap,
            rows: 0,
        }
    }
}

/// A row of a cost trace.
#[derive(Serialize)]
struct Row<'a> {
    #[expect(clippy::struct_field_names, reason = "the name in the format")]
    row: u64,
    phase: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    node: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rank: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    round: Option<u32>,
    #[serde(flatten)]
    entry: Entry,
    after: &'a [u64],
}

/// A call of a primitive, or a vector step whose items have their own calls.
#[derive(Serialize)]
struct Entry {
    primitive: &'static str,
    items: u64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    calls: Vec<Calls>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    longest: Vec<Entry>,
}

/// Equal calls of the lanes of a vector step.
#[derive(Serialize)]
struct Calls {
    primitive: &'static str,
    items: u64,
    times: u64,
}

impl Entry {
    fn of(step: &Step) -> Self {
        match step {
            Step::Call(Call { primitive, items }) => Entry::plain(primitive.name(), *items),
            Step::Lanes(LaneStep { lanes, calls, longest }) => {
                let calls = calls.iter().map(|(&Call { primitive, items }, &times)| Calls {
                    primitive: primitive.name(),
                    items,
                    times,
                });
                Entry {
                    calls: calls.collect(),
                    longest: Entry::all(longest),
                    ..Entry::plain("lanes", *lanes)
                }
            }
        }
    }

    fn all(tape: &Tape) -> Vec<Self> {
        tape.steps().iter().map(Entry::of).collect()
    }

    fn plain(primitive: &'static str, items: u64) -> Self {
        Entry { primitive, items, calls: Vec::new(), longest: Vec::new() }
    }
}

/// Writes a cost trace: the header, then one line for each row.
///
/// # Errors
/// Fails if `out` fails.
pub fn write_cost_trace(out: &mut impl Write, header: CostHeader, trace: &CostTrace) -> io::Result<()> {
    let header = CostHeader { rows: trace.rows().len() as u64, ..header };
    line(out, &header)?;
    for (row, &CostRow { phase, node, step, rank, round, ref entry, ref after }) in (0..).zip(trace.rows()) {
        let entry = entry.as_ref().map_or_else(|| Entry::plain("barrier", 0), Entry::of);
        let phase = phase.name();
        line(out, &Row { row, phase, node: node.map(|node| node.0), step, rank, round, entry, after })?;
    }
    Ok(())
}

/// Returns the counts of a ledger in the form of a report.
pub fn ledger_counts(ledger: &Ledger) -> ReportedCounts {
    let total = |total: &Total| ReportedTotal {
        work: Some(total.work),
        depth: Some(total.depth),
        brent: Some(total.brent),
    };
    let phases = ledger.phases.iter().map(|phase| ReportedPhase {
        name: phase.phase.name().to_owned(),
        work: Some(phase.work),
        depth: Some(phase.depth),
    });
    let machine = ReportedTotals {
        paper: total(&ledger.totals.paper),
        repair: total(&ledger.totals.repair),
        selection: Some(total(&ledger.totals.selection)),
    };
    ReportedCounts { machine, phases: phases.collect() }
}

fn line(out: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *out, value)?;
    out.write_all(b"\n")
}
