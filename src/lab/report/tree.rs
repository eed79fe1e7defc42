//! The partition tree and the supergraph, in numbers.

use septet_protocol::ids::Phase;
use septet_protocol::ledger::LevelSums;

use septet_core::Outcome;

use super::schema::{GraphReport, TreeLevelReport, TreeReport};

/// Returns the ratios of the tree, and its levels.
pub(super) fn summary(run: &Outcome) -> TreeReport {
    let sums = &run.ledger.tree;
    let total = sums.total();
    let splits = total.nodes - total.leaves;
    let settled = &run.settled;
    TreeReport {
        samples: settled.counted.then_some(settled.samples),
        tries: settled.counted.then_some(settled.tries),
        levels: sums.levels().map(|(level, _)| level).last().unwrap_or(0),
        leaves: total.leaves,
        nodes: total.nodes,
        spheres: total.spheres,
        planes: total.planes,
        largest_split_ratio: total.split.largest(),
        mean_split_ratio: total.split.mean(),
        largest_attempts: total.largest_attempts,
        mean_attempts: (splits > 0).then(|| total.attempts as f64 / splits as f64),
        largest_separator_ratio: total.separator.largest(),
        mean_separator_ratio: total.separator.mean(),
        by_level: levels(run),
    }
}

fn levels(run: &Outcome) -> Vec<TreeLevelReport> {
    let counted = run.settled.counted;
    // Only runs whose supergraph is built from nearest-neighbour balls have this phase.
    let has_balls = run.ledger.phases.iter().any(|total| total.phase == Phase::Neighbours);
    let row = |(level, sums): (u32, &LevelSums)| {
        let depth = |phase| counted.then(|| sums.deepest(phase));
        TreeLevelReport {
            level,
            nodes: sums.nodes,
            leaves: sums.leaves,
            points: sums.points,
            largest: sums.largest,
            largest_split_ratio: sums.split.largest(),
            largest_attempts: sums.largest_attempts,
            separator_points: sums.separator_points,
            partition_depth: depth(Phase::Partition),
            neighbours_depth: depth(Phase::Neighbours).filter(|_| has_balls),
            merge_depth: depth(Phase::Merge),
            depths: sums.depths().filter(|_| counted).map(|(phase, depth)| (phase.name(), depth)).collect(),
        }
    };
    run.ledger.tree.levels().map(row).collect()
}

/// Returns the size of the supergraph.
pub(super) fn graph(run: &Outcome) -> GraphReport {
    let total = run.ledger.tree.total();
    let points = run.points.used.max(1) as f64;
    GraphReport {
        edges: total.edges,
        edge_hash: format!("{:016x}", run.ledger.part.edge_hash),
        max_degree: total.max_degree,
        mean_degree: 2.0 * total.edges as f64 / points,
        replication: total.members as f64 / points,
    }
}
