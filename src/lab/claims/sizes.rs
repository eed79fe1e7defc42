//! The natural sizes of a run, from points, cells, surfaces and sites alone.

use std::collections::BTreeMap;

use septet_core::Outcome;

use super::floors::{Natural, Term};
use super::measure::{X, degrees, density, kth_nearest2, pairs, stars};
use super::reached::{Extremes, reached};
use super::sample::Sample;
use super::sites::Rounds;
use super::surfaces::Tree;
use super::sweeps::LIST;

/// The limits of the number of samples of a node. Between them, a node draws a quarter of its points.
const SAMPLES: (f64, f64) = (36.0, 100.0);

/// The natural sizes of a run. A size without an entry is undefined, because the run does not have it.
pub(super) struct Sizes(BTreeMap<Natural, f64>);

impl Sizes {
    /// Returns a sum of terms. The sum is NaN if a size is undefined. It is also NaN without items, because no bound
    /// follows then.
    pub(super) fn sum(&self, terms: &[Term]) -> f64 {
        let of = |natural| self.0.get(&natural).copied().unwrap_or(f64::NAN);
        let sum = terms.iter().map(|&(operations, natural)| operations * of(natural)).sum::<f64>();
        if sum > 0.0 { sum } else { f64::NAN }
    }

    /// Returns the sizes of an independent set.
    pub(super) fn of_rounds(rounds: &Rounds) -> Sizes {
        Sizes(BTreeMap::from([
            (Natural::Rounds, rounds.number),
            (Natural::OpenPoints, rounds.open_points),
            (Natural::OpenEdges, rounds.open_edges),
        ]))
    }

    /// Returns the sizes of a run with nearest-neighbour lists.
    pub(super) fn of_lists(run: &Outcome, points: &[X]) -> Sizes {
        let tree = Tree::of_run(run, points);
        let mut sizes = of_tree(&tree, points.len());
        add_balls(&mut sizes, &tree, points, &radii(&kth_nearest2(points, LIST as usize)));
        Sizes(sizes)
    }

    /// Returns the sizes of a run with a density graph of this alpha.
    pub(super) fn of_density(run: &Outcome, sample: Sample, points: &[X], alpha: f64) -> Sizes {
        let tree = Tree::of_run(run, points);
        let mut sizes = of_tree(&tree, points.len());
        let nearest2 = kth_nearest2(points, 1);
        let radii = radii(&nearest2);
        add_balls(&mut sizes, &tree, points, &radii);
        // The length of an edge is at most alpha times the smaller radius of its ends.
        let reach = |i: usize, node: &Extremes| within(node, &points[i], alpha * radii[i].min(node.radius));
        let edges = reached(&tree.division(), points, &radii, reach);
        let candidates = degrees(points.len(), &pairs(points, &nearest2, density(alpha)));
        let stars = stars(points.len(), run.cells(), sample.d);
        let tests: f64 = candidates.iter().zip(&stars).map(|(c, star)| *c as f64 * star.len() as f64).sum();
        let corners = (sample.d + 1) as f64;
        let facets = run.cell_count() as f64 * corners;
        sizes.extend([
            (Natural::PointsAtNodes, edges.at_nodes),
            (Natural::PairsWithMembers, edges.pairs_with_members),
            (Natural::LinkFacets, facets),
            (Natural::VerticesOfFacets, facets * corners),
            (Natural::CandidatesTimesFacets, tests),
            (Natural::LargestDegree, candidates.iter().copied().max().unwrap_or(0) as f64),
        ]);
        Sizes(sizes)
    }
}

fn radii(radii2: &[f64]) -> Vec<f64> {
    radii2.iter().map(|r2| r2.sqrt()).collect()
}

/// Returns the sizes of a tree.
fn of_tree(tree: &Tree, points: usize) -> BTreeMap<Natural, f64> {
    let populations = || tree.nodes.iter().map(|(_, members)| members.len() as f64);
    let samples = |m: f64| (m / 4.0).clamp(SAMPLES.0, SAMPLES.1).min(m);
    let leaves = tree.populations();
    let of_leaves = |of: &dyn Fn(u64) -> f64| leaves.values().map(|&m| of(m)).sum::<f64>();
    let levels = leaves.keys().map(|leaf| leaf.ilog2()).max().unwrap_or(0);
    BTreeMap::from([
        (Natural::One, 1.0),
        (Natural::Points, points as f64),
        (Natural::Splits, tree.nodes.len() as f64),
        (Natural::Levels, f64::from(levels)),
        (Natural::PointsTimesLevels, populations().sum()),
        (Natural::PairsOfSamples, populations().map(|m| samples(m) * samples(m)).sum()),
        (Natural::SortsInLeaves, of_leaves(&|m| m as f64 * (m as f64).log2().ceil())),
        (Natural::PairsInLeaves, of_leaves(&|m| m as f64 * (m as f64 - 1.0))),
    ])
}

/// Returns the reach of a point into a node, or minus infinity if it misses the box of the node's points.
fn within(node: &Extremes, x: &X, reach: f64) -> f64 {
    if node.distance(x) <= reach { reach } else { f64::NEG_INFINITY }
}

/// Adds the sizes of a descent of balls.
fn add_balls(sizes: &mut BTreeMap<Natural, f64>, tree: &Tree, points: &[X], radii: &[f64]) {
    let reach = |i: usize, node: &Extremes| within(node, &points[i], radii[i]);
    let balls = reached(&tree.division(), points, radii, reach);
    sizes.extend([
        (Natural::BallsAtNodes, balls.at_nodes),
        (Natural::BallsToBoth, balls.to_both),
        (Natural::PairsWithVisitors, balls.pairs_with_visitors),
    ]);
}
