//! Section 2 and Lemma 4.5: the depth of one level does not depend on the number of points of its nodes.

use crate::experiment::fit::{ClusterRow, Estimate, clustered};

use super::bounds::LEVELS;
use super::claim::LEVEL;
use super::counted::{Counted, NodeCounts};
use super::lab::Lab;
use super::sweeps::{Sweep, lists, recursions, trees};
use super::{Claim, ClaimError, Figure, Reading, Role, Statistics};

/// Largest growth of the depth of a level for each doubling of the points of its nodes, in steps.
const STEPS: f64 = 0.5;

/// The smallest node of the fit, in points. Larger nodes draw a constant number of samples.
const CAPPED: u64 = 1600;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "level-depth",
    role: Role::Test,
    statistics: Some(Statistics {
        level: LEVEL,
        fault: "slow:partition:log",
        caught: 20,
        of: 20,
        smallest: "slow:partition:log:0.55, at 6 of 6 seeds",
    }),
    source: "Section 2, Section 4.3, Lemma 4.5",
    statement: "a level of the recursion takes constant time with n processors, for any size of its nodes",
    reading: Reading::AsPrinted,
    experiment: "Fit of the depth of a node per attempt against log2 of its points m, over all split nodes of at \
                 least 1,600 points. The upper end of the one-sided 95 % interval of the slope, errors clustered by \
                 run; for smaller nodes and for all nodes that probe, the largest depth",
    bound: "0.5 steps per doubling: a single scan of m items that is charged log2 m steps adds 1. For smaller nodes and \
            probes, 1.15 times the largest depth over the seeds 1 to 3: the primitives of a level have a constant depth",
    check: levels,
}];

fn levels(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let mut figures = Vec::new();
    for sweep in [recursions(lab)?, lists(lab)?, trees(lab)?].concat() {
        for level in LEVELS {
            let phase = level.name;
            // A sweep without a large ball does not probe. A phase that must occur has figures even without charges.
            if !(sweep.must_have(phase) || level.probes && sweep.has(phase)) {
                continue;
            }
            let below = if level.probes { u64::MAX } else { CAPPED };
            figures.extend((!level.probes).then(|| slope(&sweep, phase, seed)));
            figures.push(cap(&sweep, Nodes { phase, below }, seed, level.depth.of(sweep.dimension())));
        }
    }
    Ok(figures)
}

/// Returns the depth of a node in a phase, if it has one. In `partition`, this is the depth per attempt at the
/// separator.
fn depth(node: &NodeCounts, phase: &str) -> Option<f64> {
    let attempts = if phase == "partition" { node.facts.attempts.max(1) } else { 1 };
    Some(*node.depth.get(phase)? as f64 / attempts as f64)
}

/// Returns the figure of the growth of a level. It has no value if fewer than three runs have nodes of at least
/// [`CAPPED`] points.
fn slope(sweep: &Sweep, phase: &str, seed: u64) -> Figure {
    let slope = growth(&sweep.runs, phase);
    let estimate = slope.map_or(f64::NAN, |slope| slope.value);
    let what = format!("steps of {phase} per doubling of a node, estimated {estimate:.3}");
    let figure =
        Figure::at_most(what, &sweep.name, seed, slope.map_or(f64::NAN, |slope| slope.upper()), STEPS);
    figure.with_p(slope.map_or(f64::NAN, |slope| slope.p_below(STEPS)))
}

/// Returns the slope of the depth of a level against log2 of the points of its nodes, over nodes of at least [`CAPPED`] points.
pub(super) fn growth(runs: &[Counted], phase: &str) -> Option<Estimate> {
    let mut rows = Vec::new();
    for (cluster, run) in (0..).zip(runs) {
        for node in run.splits().filter(|node| node.facts.population >= CAPPED) {
            let Some(y) = depth(node, phase) else { continue };
            rows.push(ClusterRow { cluster, columns: vec![(node.facts.population as f64).log2()], y });
        }
    }
    clustered(&rows, 1)
}

/// The split nodes with fewer points than `below`, in a phase.
#[derive(Clone, Copy)]
struct Nodes<'a> {
    phase: &'a str,
    below: u64,
}

fn cap(sweep: &Sweep, Nodes { phase, below }: Nodes<'_>, seed: u64, bound: f64) -> Figure {
    let largest = sweep.largest(|run| {
        let smaller = run.splits().filter(|node| node.facts.population < below);
        let largest = smaller.filter_map(|node| depth(node, phase)).reduce(f64::max);
        // A run without a large ball does not probe.
        largest.unwrap_or(if below == u64::MAX { 0.0 } else { f64::NAN })
    });
    let size = if below == CAPPED { "below 1,600 points" } else { "of any size" };
    let what = format!("steps of {phase} at a node {size}");
    Figure::at_most(what, &sweep.name, seed, largest, bound)
}
