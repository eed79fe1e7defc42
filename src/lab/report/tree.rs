//! The partition tree and the supergraph, in numbers.

use septet_protocol::ids::Phase;

use septet_core::Outcome;

use super::schema::{GraphReport, LevelDepths, TreeReport};
use crate::rows::{self, LevelRow};

/// Returns the tree and its levels.
pub(super) fn summary(run: &Outcome) -> TreeReport {
    let settled = &run.settled;
    TreeReport {
        samples: settled.counted.then_some(settled.samples),
        tries: settled.counted.then_some(settled.tries),
        tree: rows::tree(&run.ledger, true),
        by_level: levels(run),
    }
}

fn levels(run: &Outcome) -> Vec<LevelRow<LevelDepths>> {
    let counted = run.settled.counted;
    // Only runs whose supergraph is built from nearest-neighbour balls have this phase.
    let has_balls = run.ledger.phases.iter().any(|total| total.phase == Phase::Neighbours);
    rows::levels(&run.ledger, true, |_, sums| {
        let depth = |phase| counted.then(|| sums.deepest(phase));
        LevelDepths {
            partition_depth: depth(Phase::Partition),
            neighbours_depth: depth(Phase::Neighbours).filter(|_| has_balls),
            merge_depth: depth(Phase::Merge),
            depths: sums.depths().filter(|_| counted).map(|(phase, depth)| (phase.name(), depth)).collect(),
        }
    })
}

/// Returns the size of the supergraph.
pub(super) fn graph(run: &Outcome) -> GraphReport {
    GraphReport {
        size: rows::graph(&run.ledger, run.stars),
        edge_hash: format!("{:016x}", run.ledger.part.edge_hash),
    }
}
