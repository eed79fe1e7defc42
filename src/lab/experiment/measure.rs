//! Converts the ledger of a run into a line.

use std::collections::BTreeMap;

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::{ByGroup, NodeId, Phase};
use septet_protocol::ledger::{Ledger, NodeFacts, NodeKind};

use septet_core::Outcome;

use super::line::{DepthLine, GraphLine, LevelLine, Line, Program, RunOptions, SCHEMA, TreeLine};
use crate::rows::{self, PhaseRow};

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
        tree: tree(ledger, space, whole),
        levels: if counted { levels(ledger, whole) } else { Vec::new() },
        rounds: moved.collect(),
        graph: (counted && whole).then(|| graph_line(ledger, points)),
        end,
        seconds: times.total,
    }
}

fn named(supergraph: Supergraph) -> String {
    match supergraph {
        Supergraph::Density { alpha } | Supergraph::Overlap { alpha } => {
            format!("{} {alpha}", supergraph.name())
        }
        Supergraph::Knn { k } => format!("{} {k}", supergraph.name()),
    }
}

/// Returns the phases with counts.
fn phases(ledger: &Ledger, seconds: &[(Phase, f64)]) -> Vec<PhaseRow> {
    let counted = |row: &PhaseRow| ledger.phases.contains(&row.total);
    rows::phases(ledger, seconds).into_iter().filter(counted).collect()
}

fn tree(ledger: &Ledger, dimension: usize, whole: bool) -> TreeLine {
    let exponent = 1.0 - 1.0 / dimension as f64;
    let mut tree = TreeLine::default();
    for (node, facts) in &ledger.part.nodes {
        tree.levels = tree.levels.max(node.level());
        tree.nodes += 1;
        if facts.is_leaf() {
            tree.leaves += 1;
            continue;
        }
        tree.planes += u64::from(facts.kind == NodeKind::Plane);
        tree.attempts += facts.attempts;
        let m = facts.population.max(1) as f64;
        let larger = facts.inside.max(facts.population - facts.inside) as f64;
        tree.largest_split_ratio = tree.largest_split_ratio.max(larger / m);
        if whole {
            let ratio = (facts.crossing_inside + facts.crossing_outside) as f64 / m.powf(exponent);
            tree.largest_separator_ratio = Some(tree.largest_separator_ratio.map_or(ratio, |r| r.max(ratio)));
        }
    }
    tree
}

fn levels(ledger: &Ledger, whole: bool) -> Vec<LevelLine> {
    let mut rows: BTreeMap<u32, LevelLine> = BTreeMap::new();
    let nodes = &ledger.part.nodes;
    for (node, facts) in nodes {
        let level = node.level();
        let row = rows.entry(level).or_insert_with(|| LevelLine { level, ..LevelLine::default() });
        row.add(facts, whole);
    }
    let split = |node: &NodeId| nodes.get(node).is_some_and(|facts| !facts.is_leaf());
    let charges =
        Phase::ALL.into_iter().flat_map(|phase| ledger.part.members(phase).map(move |c| (phase, c)));
    for (phase, (node, charge)) in charges.filter(|(_, (node, _))| split(node)) {
        let Some(row) = rows.get_mut(&node.level()) else { continue };
        let depth: &mut DepthLine = row.depth.entry(phase.name().to_string()).or_default();
        depth.nodes += 1;
        depth.sum += charge.cost.depth();
        depth.largest = depth.largest.max(charge.cost.depth());
        depth.work += charge.cost.work();
    }
    rows.into_values().collect()
}

impl LevelLine {
    fn add(&mut self, facts: &NodeFacts, whole: bool) {
        self.nodes += 1;
        self.points += facts.population;
        self.largest = self.largest.max(facts.population);
        if !facts.is_leaf() {
            self.splits += 1;
            self.split_points += facts.population;
            self.attempts += facts.attempts;
            let crossing = facts.crossing_inside + facts.crossing_outside;
            self.separator_points = whole.then(|| self.separator_points.unwrap_or(0) + crossing);
        }
    }
}

fn graph_line(ledger: &Ledger, points: u64) -> GraphLine {
    let nodes = ledger.part.nodes.values();
    GraphLine {
        edges: nodes.clone().map(|f| f.edges).sum(),
        max_degree: nodes.clone().map(|f| f.max_degree).max().unwrap_or(0),
        replication: nodes.map(|f| f.members).sum::<u64>() as f64 / points.max(1) as f64,
    }
}
