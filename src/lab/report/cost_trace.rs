//! Cost traces as JSON lines.

use std::io::{self, Write};

use serde::Serialize;

use septet_core::Settled;
use septet_core::run::{CostRow, CostTrace};
use septet_core::spec::{Spec, Words};
#[cfg(feature = "schema")]
use septet_geometry::cost::Primitive;
use septet_geometry::cost::{Call, LaneStep, Step, Tape};
use septet_protocol::ledger::{Ledger, Total};

use super::SupergraphReport;
use super::build::supergraph;
use crate::accounts::{ReportedCounts, ReportedPhase, ReportedTotal, ReportedTotals, SCHEMA};

/// A line of a cost trace. The first line is the header. Every other line is a row.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum CostLine<'a> {
    /// The first line.
    Header(CostHeader),
    /// Another line.
    Row(Row<'a>),
}

/// The run, and the parameters on which its counts depend.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CostHeader {
    /// Name and version of the format.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// Version of septet.
    version: &'static str,
    /// Number of distinct points.
    points: u64,
    /// 2 or 3.
    dimension: usize,
    /// Seed of every draw.
    seed: u64,
    /// Number of workers.
    workers: u32,
    /// Purpose of the constants of the partition tree: `counting` or `timing`.
    constants: &'static str,
    /// Largest number of points in a leaf.
    leaf: u64,
    /// Largest expected number of samples of a draw.
    samples: u64,
    /// Number of great circles of a draw.
    tries: u32,
    /// The supergraph.
    supergraph: SupergraphReport,
    /// Rule for separator sets: `both`, `smaller` or `ghost`.
    separator_sets: &'static str,
    /// Rule that divides subproblems: `sphere` or `kd`.
    partition: &'static str,
    /// Correction of nearest-neighbour balls: `descent`, `naive`, `fmt` or `pairs`.
    neighbours: &'static str,
    /// Repair of stars that disagree: `probe` or `splay`.
    repair: &'static str,
    /// Planted fault; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    fault: Option<String>,
    /// Maximum number of splaying rounds before the fallback; absent for `6 log2 n`.
    #[serde(skip_serializing_if = "Option::is_none")]
    exchange_cap: Option<u32>,
    /// Number of rows that follow.
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
            repair: spec.recursion.repair.name(),
            fault: spec.planted.fault.map(|fault| fault.to_string()),
            exchange_cap: spec.planted.exchange_cap,
            rows: 0,
        }
    }
}

/// A call of a primitive, a vector step whose items have their own calls, or a barrier.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Row<'a> {
    /// Position of the row, from 0.
    #[expect(clippy::struct_field_names, reason = "the name in the format")]
    row: u64,
    /// The phase.
    phase: &'static str,
    /// The subproblem; the root is 1. Absent for a barrier of a whole phase.
    #[serde(skip_serializing_if = "Option::is_none")]
    node: Option<u64>,
    /// Number of the step, if the subproblems step together; level of the corrected node if the balls are corrected
    /// naively.
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<u32>,
    /// The rank that made the call; absent for a barrier.
    #[serde(skip_serializing_if = "Option::is_none")]
    rank: Option<u32>,
    /// The round in which the rank charged the call; absent for a barrier.
    #[serde(skip_serializing_if = "Option::is_none")]
    round: Option<u32>,
    #[serde(flatten)]
    entry: Entry,
    /// Positions of earlier rows that end before this row starts.
    after: &'a [u64],
}

/// A call of a lane.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Entry {
    /// A name of the price table in the guide, `lanes` or `barrier`.
    #[cfg_attr(feature = "schema", schemars(schema_with = "primitives"))]
    primitive: &'static str,
    /// Number of items; of `lanes`, number of lanes.
    items: u64,
    /// Of `lanes` only: the calls of all lanes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    calls: Vec<Calls>,
    /// Of `lanes` only: the calls of the longest lane in their order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    longest: Vec<Entry>,
}

/// Returns the schema of a name of a primitive.
#[cfg(feature = "schema")]
fn primitives(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let names = [&Primitive::ALL.map(Primitive::name)[..], &["lanes", "barrier"]].concat();
    schemars::json_schema!({ "enum": names })
}

/// Equal calls of all lanes of a vector step.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Calls {
    /// A name of the price table in the guide.
    #[cfg_attr(feature = "schema", schemars(schema_with = "primitives"))]
    primitive: &'static str,
    /// Number of items of each call.
    items: u64,
    /// Number of times that the call occurs.
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
    line(out, &CostLine::Header(header))?;
    for (row, &CostRow { phase, node, step, rank, round, ref entry, ref after }) in (0..).zip(trace.rows()) {
        let entry = entry.as_ref().map_or_else(|| Entry::plain("barrier", 0), Entry::of);
        let phase = phase.name();
        let node = node.map(|node| node.0);
        line(out, &CostLine::Row(Row { row, phase, node, step, rank, round, entry, after }))?;
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

fn line(out: &mut impl Write, value: &CostLine<'_>) -> io::Result<()> {
    serde_json::to_writer(&mut *out, value)?;
    out.write_all(b"\n")
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use septet_core::spec::{OPTIONS, Series};

    use super::*;

    #[test]
    fn the_header_has_every_option_on_which_work_and_depth_depend() {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let spec = Spec::default();
        let run = septet_core::simulate(&corners, &spec).unwrap();
        let header = serde_json::to_value(CostHeader::of(&spec, &run.settled, 3, 2)).unwrap();
        for row in OPTIONS.iter().filter(|row| row.series != Series::Omitted) {
            let is_field = header.get(row.key).is_some() || header["supergraph"].get(row.key).is_some();
            assert!(is_field, "{}", row.name);
        }
    }
}
