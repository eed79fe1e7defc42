//! Compares the descent of all balls from the root with the bottom-up correction.

use std::error::Error;

use septet_core::generate::Kind;
use septet_core::model::Points;
use septet_core::spec::{Correction, Until, Words};
use septet_core::{Spec, count};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;

use super::plan::{Plan, announce};
use super::table::{Table, mean, whole};

/// Maximum number of points per leaf, small enough for trees of several levels.
const LEAF: u64 = 64;

const NAMES: [&str; 9] =
    ["set", "d", "n", "correction", "levels", "depth", "depth / levels", "work", "rounds"];

/// Returns a row for each dimension, size and correction, on uniform sets. The counts are sums over the phases `probe`,
/// which only the descent has, and `neighbours`.
pub fn table(plan: &Plan) -> Result<Table, Box<dyn Error>> {
    let mut table = Table::new(&NAMES);
    for &dimension in &plan.dimensions {
        for &n in &plan.sizes {
            announce("correction", Kind::Uniform, n, dimension);
            let sets = plan.sets(Kind::Uniform, n, dimension)?;
            for correction in [Correction::Descent, Correction::BottomUp] {
                let mut sum = Sum::default();
                for (set, spec) in &sets {
                    let spec = spec.clone().with(|c| {
                        c.recursion.neighbours = correction;
                        c.tree.leaf = Some(LEAF);
                    });
                    match &set.points {
                        Points::Plane(points) => sum.add(points, &spec)?,
                        Points::Space(points) => sum.add(points, &spec)?,
                        Points::Higher(_) => unreachable!("the plan has dimensions 2 and 3"),
                    }
                }
                table.push(sum.row(dimension, n, correction));
            }
        }
    }
    Ok(table)
}

/// Sums over the seeds.
#[derive(Default)]
struct Sum {
    runs: u64,
    levels: u64,
    depth: u64,
    work: u64,
    rounds: u64,
}

impl Sum {
    fn add<P: Point>(&mut self, points: &[P], spec: &Spec) -> Result<(), septet_core::Error> {
        let ledger = count(points, Some(Until::Neighbours), spec)?.ledger;
        self.runs += 1;
        self.levels += u64::from(ledger.part.nodes.keys().map(|node| node.level()).max().unwrap_or(0));
        for phase in ledger.phases.iter().filter(|p| matches!(p.phase, Phase::Probe | Phase::Neighbours)) {
            self.depth += phase.depth;
            self.work += phase.work;
            self.rounds += phase.rounds;
        }
        Ok(())
    }

    fn row(&self, dimension: usize, n: u64, correction: Correction) -> Vec<String> {
        vec![
            Kind::Uniform.to_string(),
            dimension.to_string(),
            n.to_string(),
            correction.name().to_string(),
            mean(self.levels, self.runs),
            mean(self.depth, self.runs),
            format!("{:.2}", self.depth as f64 / self.levels.max(1) as f64),
            whole(self.work, self.runs),
            mean(self.rounds, self.runs),
        ]
    }
}
