//! The partition tree and the supergraph, in numbers.

use std::collections::BTreeMap;

use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::{Ledger, NodeFacts, NodeKind};

use septet_core::run::Run;

use super::schema::{GraphReport, NodeReport, TreeLevelReport, TreeReport};

/// Largest value and mean of a sequence.
#[derive(Default)]
struct Spread {
    largest: Option<f64>,
    sum: f64,
    count: f64,
}

impl Spread {
    fn add(&mut self, x: f64) {
        self.largest = Some(self.largest.map_or(x, |l| l.max(x)));
        self.sum += x;
        self.count += 1.0;
    }

    fn mean(&self) -> Option<f64> {
        (self.count > 0.0).then(|| self.sum / self.count)
    }
}

/// Returns the size of the larger side over the number of owned points of the node.
fn split_ratio(facts: &NodeFacts) -> f64 {
    facts.inside.max(facts.population - facts.inside) as f64 / facts.population.max(1) as f64
}

/// Returns the ratios of the tree, and its levels.
pub(super) fn summary(run: &Run) -> TreeReport {
    let mut tree = TreeReport::default();
    let (mut split, mut attempts, mut separator) = <(Spread, Spread, Spread)>::default();
    let exponent = 1.0 - 1.0 / run.space as f64;
    for (node, facts) in &run.ledger.part.nodes {
        tree.levels = tree.levels.max(node.level());
        tree.nodes += 1;
        match facts.kind {
            NodeKind::Leaf => {
                tree.leaves += 1;
                continue;
            }
            NodeKind::Sphere => tree.spheres += 1,
            NodeKind::Plane => tree.planes += 1,
        }
        split.add(split_ratio(facts));
        attempts.add(facts.attempts as f64);
        tree.largest_attempts = tree.largest_attempts.max(facts.attempts);
        let crossing = facts.crossing_inside + facts.crossing_outside;
        separator.add(crossing as f64 / (facts.population.max(1) as f64).powf(exponent));
    }
    let settled = &run.settled;
    TreeReport {
        samples: settled.counted.then_some(settled.samples),
        tries: settled.counted.then_some(settled.tries),
        largest_split_ratio: split.largest,
        mean_split_ratio: split.mean(),
        mean_attempts: attempts.mean(),
        largest_separator_ratio: separator.largest,
        mean_separator_ratio: separator.mean(),
        by_level: levels(run),
        ..tree
    }
}

fn levels(run: &Run) -> Vec<TreeLevelReport> {
    let mut levels: BTreeMap<u32, TreeLevelReport> = BTreeMap::new();
    for (node, facts) in &run.ledger.part.nodes {
        let level = node.level();
        let row =
            levels.entry(level).or_insert_with(|| TreeLevelReport { level, ..TreeLevelReport::default() });
        row.nodes += 1;
        row.points += facts.population;
        row.largest = row.largest.max(facts.population);
        if facts.is_leaf() {
            row.leaves += 1;
            continue;
        }
        let ratio = split_ratio(facts);
        row.largest_split_ratio = Some(row.largest_split_ratio.map_or(ratio, |r| r.max(ratio)));
        row.largest_attempts = row.largest_attempts.max(facts.attempts);
        row.separator_points += facts.crossing_inside + facts.crossing_outside;
    }
    if run.settled.counted {
        let has_balls = run.ledger.phases.iter().any(|total| total.phase == Phase::Neighbours);
        for row in levels.values_mut() {
            let depth = |phase| Some(deepest(&run.ledger, phase, row.level));
            row.partition_depth = depth(Phase::Partition);
            // Only runs whose supergraph is built from nearest-neighbour balls have this phase.
            row.neighbours_depth = depth(Phase::Neighbours).filter(|_| has_balls);
            row.merge_depth = depth(Phase::Merge);
        }
    }
    levels.into_values().collect()
}

/// Returns the largest depth of a node at a level in a phase.
fn deepest(ledger: &Ledger, phase: Phase, level: u32) -> u64 {
    let first = NodeId(1 << level);
    let last = NodeId((1 << level) + ((1 << level) - 1));
    let level = ledger.part.members(phase).filter(|(node, _)| (first..=last).contains(node));
    level.map(|(_, charge)| charge.cost.depth()).max().unwrap_or(0)
}

/// Returns every node.
pub(super) fn nodes(ledger: &Ledger) -> Vec<NodeReport> {
    let row = |(node, f): (&NodeId, &NodeFacts)| NodeReport {
        id: node.0,
        level: node.level(),
        population: f.population,
        inside: f.inside,
        attempts: f.attempts,
        kind: f.kind.name(),
        crossing_inside: f.crossing_inside,
        crossing_outside: f.crossing_outside,
        members: f.members,
        edges: f.edges,
    };
    ledger.part.nodes.iter().map(row).collect()
}

/// Returns the size of the supergraph.
pub(super) fn graph(run: &Run) -> GraphReport {
    let nodes = run.ledger.part.nodes.values();
    let edges = nodes.clone().map(|f| f.edges).sum::<u64>();
    let members = nodes.clone().map(|f| f.members).sum::<u64>();
    let points = run.points.used.max(1) as f64;
    GraphReport {
        edges,
        edge_hash: format!("{:016x}", run.ledger.part.edge_hash),
        max_degree: nodes.map(|f| f.max_degree).max().unwrap_or(0),
        mean_degree: 2.0 * edges as f64 / points,
        replication: members as f64 / points,
    }
}
