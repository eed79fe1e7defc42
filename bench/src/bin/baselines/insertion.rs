//! Compares the paper's recursion with incremental insertion.

use std::error::Error;

use septet_core::generate::Kind;
use septet_core::model::Points;
use septet_core::{Spec, simulate};
use septet_geometry::point::Point;
use septet_lab::baselines::incremental;

use super::plan::{Plan, announce};
use super::table::{Table, mean, whole};

const NAMES: [&str; 13] = [
    "set",
    "d",
    "n",
    "recursion: depth",
    "its repair: depth",
    "insertion: depth",
    "insertion: depth with unions 1",
    "insertion: chain",
    "recursion: work",
    "its repair: work",
    "insertion: work",
    "recursion: n processors",
    "insertion: n processors",
];

/// Sets that satisfy the hypothesis of the theorem, and sets that do not.
const KINDS: [Kind; 2] = [Kind::WellSpaced, Kind::Uniform];

/// Returns a row for each dimension, kind and size.
pub fn table(plan: &Plan) -> Result<Table, Box<dyn Error>> {
    let mut table = Table::new(&NAMES);
    for &dimension in &plan.dimensions {
        for kind in KINDS {
            for &n in &plan.sizes {
                announce("insertion", kind, n, dimension);
                let mut sum = Sum::default();
                for (set, spec) in &plan.sets(kind, n, dimension)? {
                    match &set.points {
                        Points::Plane(points) => sum.add(points, spec)?,
                        Points::Space(points) => sum.add(points, spec)?,
                        Points::Higher(_) => unreachable!("the plan has dimensions 2 and 3"),
                    }
                }
                table.push(sum.row(kind, dimension, n));
            }
        }
    }
    Ok(table)
}

/// Sums over the seeds, in the order of the columns.
#[derive(Default)]
struct Sum {
    runs: u64,
    counts: [u64; 10],
}

impl Sum {
    fn add<P: Point>(&mut self, points: &[P], spec: &Spec) -> Result<(), Box<dyn Error>> {
        let run = simulate(points, spec)?;
        let baseline = incremental(points, spec)?;
        if baseline.cells != run.cells() {
            return Err("insertion and recursion give different cells".into());
        }
        let (paper, repair) = (&run.ledger.totals.paper, &run.ledger.totals.repair);
        let row = [
            paper.depth,
            repair.depth,
            baseline.clock.steps,
            baseline.clock.hashed,
            baseline.clock.chain,
            paper.work,
            repair.work,
            baseline.rounds.iter().map(|r| r.work).sum(),
            paper.brent + repair.brent,
            baseline.brent,
        ];
        self.runs += 1;
        self.counts.iter_mut().zip(row).for_each(|(sum, count)| *sum += count);
        Ok(())
    }

    fn row(&self, kind: Kind, dimension: usize, n: u64) -> Vec<String> {
        let mut row = vec![kind.to_string(), dimension.to_string(), n.to_string()];
        // Depths are small, so their means have one decimal.
        let shown = |(at, &sum): (usize, &u64)| {
            if at < 5 { mean(sum, self.runs) } else { whole(sum, self.runs) }
        };
        row.extend(self.counts.iter().enumerate().map(shown));
        row
    }
}
