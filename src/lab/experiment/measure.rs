//! Converts the ledger of a run into a line.

use std::collections::BTreeMap;

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::{ByGroup, NodeId, Phase};
use septet_protocol::ledger::Ledger;

use septet_core::Outcome;

use super::line::{DepthLine, Line, Program, RunOptions, SCHEMA, Splits};
use crate::rows::{self, LevelRow, PhaseRow};

/// Returns the line of a run made through the library. Kind and options are empty, and the seed is 0.
pub fn of_run(run: &Outcome) -> Line {
    let Outcome { facts, ledger, times, .. } = run;
    let (space, points, settled, end) = (facts.space, facts.points.used, &facts.settled, run.ending());
    let counted = settled.counted;
    let whole = end.is_some();
    let totals = rows::groups(ledger).map(|total| counted.then_some(total));
    let moved = rows::rounds(ledger).filter(|row| row.tally.messages > 0 || row.tally.merged > 0);
    Line {
        schema: SCHEMA.to_string(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        sweep: String::new(),
        command: String::new(),
        program: if counted { Program::Simulate } else { Program::Triangulate },
        kind: String::new(),
        dimension: space,
        seed: 0,
        asked: points,
        n: points,
        workers: settled.workers,
        leaf: settled.leaf,
        samples: settled.samples,
        tries: settled.tries,
        settings: RunOptions::default(),
        supergraph: settled.supergraph.filter(|_| whole).map(named),
        phases: phases(ledger, &times.phases),
        totals: ByGroup { repair: totals.repair.filter(|_| whole), ..totals },
        tree: rows::tree(ledger, whole),
        levels: if counted { levels(ledger, whole) } else { Vec::new() },
        rounds: moved.collect(),
        graph: (counted && whole).then(|| rows::graph(ledger, points)),
        end,
        seconds: times.total,
    }
}

fn named(supergraph: Supergraph) -> String {
    match supergraph {
        Supergraph::Density { alpha } | Supergraph::Overlap { alpha, k: 1 } => {
            format!("{} {alpha}", supergraph.name())
        }
        Supergraph::Overlap { alpha, k } => format!("{} {alpha}, k {k}", supergraph.name()),
        Supergraph::Knn { k } => format!("{} {k}", supergraph.name()),
    }
}

/// Returns the phases with counts.
fn phases(ledger: &Ledger, seconds: &[(Phase, f64)]) -> Vec<PhaseRow> {
    let counted = |row: &PhaseRow| ledger.phases.contains(&row.total);
    rows::phases(ledger, seconds).into_iter().filter(counted).collect()
}

fn levels(ledger: &Ledger, whole: bool) -> Vec<LevelRow<Splits>> {
    let mut splits = splits(ledger);
    rows::levels(ledger, whole, |level, _| splits.remove(&level).unwrap_or_default())
}

/// Returns the split nodes of each level.
fn splits(ledger: &Ledger) -> BTreeMap<u32, Splits> {
    let mut rows: BTreeMap<u32, Splits> = BTreeMap::new();
    let split = |node: &NodeId| ledger.part.nodes.get(node).filter(|facts| !facts.is_leaf());
    for (node, facts) in ledger.part.nodes.iter().filter(|(_, facts)| !facts.is_leaf()) {
        let row = rows.entry(node.level()).or_default();
        row.splits += 1;
        row.split_points += facts.population;
    }
    let charges =
        Phase::ALL.into_iter().flat_map(|phase| ledger.part.members(phase).map(move |c| (phase, c)));
    for (phase, (node, charge)) in charges.filter(|(_, (node, _))| split(node).is_some()) {
        let row = rows.entry(node.level()).or_default();
        let depth: &mut DepthLine = row.depth.entry(phase.name().to_string()).or_default();
        depth.nodes += 1;
        depth.sum += charge.cost.depth();
        depth.largest = depth.largest.max(charge.cost.depth());
        depth.work += charge.cost.work();
    }
    rows
}
