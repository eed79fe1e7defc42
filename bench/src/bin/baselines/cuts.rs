//! Compares sphere separators with k-d planes.

use std::error::Error;

use septet_core::generate::{Generated, Kind};
use septet_core::model::Points;
use septet_core::spec::{Partition, Words};
use septet_core::{Outcome, Spec, simulate};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;

use super::plan::{Plan, announce};
use super::table::{Table, mean, whole};

const NAMES: [&str; 21] = [
    "set",
    "d",
    "n",
    "cut",
    "supergraph",
    "levels",
    "leaves",
    "split mean",
    "split max",
    "attempts",
    "separator ratio mean",
    "separator ratio max",
    "separator points / n",
    "members / n",
    "work",
    "depth",
    "rounds",
    "messages",
    "bytes",
    "exchange rounds",
    "gathered",
];

/// Returns a row for each kind, dimension, size and separator.
pub fn table(plan: &Plan) -> Result<Table, Box<dyn Error>> {
    let mut table = Table::new(&NAMES);
    for &dimension in &plan.dimensions {
        for &kind in &plan.kinds {
            for &n in &plan.sizes {
                announce("cuts", kind, n, dimension);
                both(&plan.sets(kind, n, dimension)?, kind, dimension, n, &mut table)?;
            }
        }
    }
    Ok(table)
}

/// Returns the rows of both separators on the same sets, and checks that the cells are equal.
fn both(
    sets: &[(Generated, Spec)],
    kind: Kind,
    dimension: usize,
    n: u64,
    table: &mut Table,
) -> Result<(), Box<dyn Error>> {
    let mut made: Vec<Vec<Vec<u64>>> = Vec::new();
    for partition in [Partition::Sphere, Partition::Kd, Partition::Hilbert] {
        let mut counts = Counts::default();
        let mut cells = Vec::new();
        for (set, spec) in sets {
            let spec = spec.clone().with(|c| c.tree.partition = partition);
            cells.push(match &set.points {
                Points::Plane(points) => count(points, &spec, &mut counts)?,
                Points::Space(points) => count(points, &spec, &mut counts)?,
                Points::Higher(_) => unreachable!("the plan has dimensions 2 and 3"),
            });
        }
        made.push(cells);
        table.push(counts.row(kind, dimension, n, partition));
    }
    if made.iter().any(|cells| *cells != made[0]) {
        return Err("the separators give different cells".into());
    }
    Ok(())
}

/// Adds the counts of a run and returns its cells.
fn count<P: Point>(points: &[P], spec: &Spec, counts: &mut Counts) -> Result<Vec<u64>, septet_core::Error> {
    let run = simulate(points, spec)?;
    counts.add(&run);
    Ok(run.cells().to_vec())
}

/// The compared counts: sums and maxima over the seeds.
#[derive(Default)]
struct Counts {
    runs: u64,
    supergraphs: Vec<String>,
    levels: u64,
    leaves: u64,
    splits: f64,
    split_sum: f64,
    split_largest: f64,
    attempts: u64,
    ratio_sum: f64,
    ratio_largest: f64,
    crossing: u64,
    members: u64,
    points: u64,
    work: u64,
    depth: u64,
    rounds: u64,
    messages: u64,
    bytes: u64,
    exchange_rounds: u64,
    gathered: u64,
}

impl Counts {
    fn add(&mut self, run: &Outcome) {
        self.runs += 1;
        let name = name(run.settled.supergraph);
        if !self.supergraphs.contains(&name) {
            self.supergraphs.push(name);
        }
        self.add_tree(run);
        self.points += run.points.used;
        self.depth += run.ledger.totals.paper.depth;
        self.work += run.ledger.totals.paper.work;
        // Loading and collecting are the same for both separators.
        let sent = run.ledger.phases.iter().filter(|p| !matches!(p.phase, Phase::Load | Phase::Collect));
        for phase in sent {
            self.rounds += phase.rounds;
            self.messages += phase.messages;
            self.bytes += phase.bytes;
        }
        self.exchange_rounds += run.exchange_rounds;
        self.gathered += run.fallback.as_ref().map_or(0, |f| f.1);
    }

    fn add_tree(&mut self, run: &Outcome) {
        let nodes = &run.ledger.part.nodes;
        self.levels += u64::from(nodes.keys().map(|node| node.level()).max().unwrap_or(0));
        let power = 1.0 - 1.0 / run.space as f64;
        for facts in nodes.values() {
            self.members += facts.members;
            if facts.is_leaf() {
                self.leaves += 1;
                continue;
            }
            let m = facts.population as f64;
            let split = facts.inside.max(facts.population - facts.inside) as f64 / m;
            let crossing = facts.crossing_inside + facts.crossing_outside;
            let ratio = crossing as f64 / m.powf(power);
            self.splits += 1.0;
            self.split_sum += split;
            self.split_largest = self.split_largest.max(split);
            self.attempts += facts.attempts;
            self.ratio_sum += ratio;
            self.ratio_largest = self.ratio_largest.max(ratio);
            self.crossing += crossing;
        }
    }

    fn row(&self, kind: Kind, dimension: usize, n: u64, partition: Partition) -> Vec<String> {
        let splits = self.splits.max(1.0);
        let points = self.points.max(1) as f64;
        vec![
            kind.to_string(),
            dimension.to_string(),
            n.to_string(),
            partition.name().to_string(),
            self.supergraphs.join("; "),
            mean(self.levels, self.runs),
            mean(self.leaves, self.runs),
            format!("{:.3}", self.split_sum / splits),
            format!("{:.3}", self.split_largest),
            format!("{:.2}", self.attempts as f64 / splits),
            format!("{:.2}", self.ratio_sum / splits),
            format!("{:.2}", self.ratio_largest),
            format!("{:.2}", self.crossing as f64 / points),
            format!("{:.2}", self.members as f64 / points),
            whole(self.work, self.runs),
            whole(self.depth, self.runs),
            mean(self.rounds, self.runs),
            whole(self.messages, self.runs),
            whole(self.bytes, self.runs),
            mean(self.exchange_rounds, self.runs),
            mean(self.gathered, self.runs),
        ]
    }
}

fn name(supergraph: Option<Supergraph>) -> String {
    match supergraph {
        Some(Supergraph::Density { alpha }) => format!("density {alpha:.2}"),
        Some(Supergraph::Overlap { alpha, .. }) => format!("overlap {alpha:.2}"),
        Some(Supergraph::Knn { k }) => format!("knn {k}"),
        None => "none".to_string(),
    }
}
