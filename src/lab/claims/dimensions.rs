//! Theorem 2.1 and Section 4.3 in dimensions 2 to 6: separators, levels, depth and replication.
//!
//! **Statement.** In `R^d`, a separator of `m` balls crosses `O(m^(1-1/d))` of them, and each side has at most
//! `(d + 1) / (d + 2)` of the points, and a small share more. So the tree has `O(log n)` levels, each of constant depth, and the
//! leaves have `O(n)` points in total. All constants depend on `d`.
//!
//! **Departures.** Dimensions 4 to 6 need a build that has them (the feature `dimensions`). Others show 2 and 3.

use std::rc::Rc;

use crate::experiment::RunError;
use septet_core::Error;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Graph, SpecError, Until, Workers};

use super::counted::Counted;
use super::exponent::exponent;
use super::figure::largest;
use super::lab::{Lab, Runs};
use super::level_depth::growth;
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// The balls are those of the nearest neighbours themselves, because larger ones cover most of a set of this size from 5
/// dimensions on.
const ALPHA: f64 = 1.0;

/// Number of runs of each dimension.
const RUNS: u64 = 3;

/// The excess of the exponents over `1 - 1/d`. Over 3 octaves of nodes, the largest separators in a trial grew by 3 to 11 % more
/// than the theorem's power: an excess of at most 0.05.
const EXCESS: f64 = 0.1;

/// The largest growth of the depth of a level for each doubling of its points, in steps, as for `level-depth`.
const STEPS: f64 = 0.5;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "dimensions",
    role: Role::Illustration,
    statistics: None,
    source: "Theorem 2.1, Section 4.3, Lemma 4.5, in d dimensions",
    statement: "for a fixed d, separators cross O(n^(1-1/d)) balls, and the recursion has O(log n) levels of constant depth and \
                O(n) points",
    reading: Reading::AsPrinted,
    experiment: "Three uniform sets in each of 2 to 6 dimensions (4 to 6 if the build has them), leaves of 15 * 2^d points, alpha 1: the fit of log |B_O| against log m over nodes of at least 500 points; levels over \
                 log(n / leaf) / log(1 / s), where s = (d + 1) / (d + 2) + 0.05 is the largest share of a side; the growth of the depth of the partition \
                 per attempt and doubling of m, over nodes of at least 1,600 points; points of all leaves over points, as a share of the number of \
                 leaves",
    bound: "1 - 1/d + 0.1, twice the excess of a trial at up to 4,000 points; 1 and 1 more level, a theorem for separators that are accepted; 0.5 steps, as for \
            level-depth; 1, because a leaf has each point once at most. In 5 and 6 dimensions most points are in most sets at these sizes",
    check: dimensions,
}];

fn dimensions(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for d in 2..=6 {
        let runs = match runs(lab, d) {
            Err(ClaimError::Run(RunError::Run(Error::Spec(SpecError::Dimensions { .. })))) => break,
            runs => runs?,
        };
        figures.extend(of_dimension(&runs, d, lab.seed()));
        if lab.has_detected(&figures) {
            break;
        }
    }
    Ok(figures)
}

/// Returns the largest leaf: in `d` dimensions, a smaller one has more balls that cross its boundary than points.
fn leaf(d: usize) -> u64 {
    15 << d
}

fn runs(lab: &mut Lab, d: usize) -> Result<Rc<Vec<Counted>>, ClaimError> {
    let n = if lab.brief() { 1 << 12 } else { lab.size(1 << 16, 1 << 18) };
    let samples = &[Sample::new(Kind::Uniform, n, d)];
    let name = format!("dimensions {}", samples[0].name());
    lab.counted(&Runs { name: &name, samples, seeds: RUNS, until: Some(Until::Graph) }, |spec| {
        spec.with(|c| {
            c.tree.leaf = Some(leaf(d));
            c.machine.workers = Workers::Count(1);
            c.recursion.graph = Graph::Density { alpha: Alpha::Value(ALPHA) };
        })
    })
}

fn of_dimension(runs: &[Counted], d: usize, seed: u64) -> Vec<Figure> {
    let on = format!("uniform {d}D n={} {} runs", runs[0].line.n, runs.len());
    let share = (d as f64 + 1.0) / (d as f64 + 2.0) + 0.05;
    let power = 1.0 - 1.0 / d as f64;
    let estimate = exponent(runs).map_or(f64::NAN, |estimate| estimate.value);
    let levels = |run: &Counted| {
        let levels = run.nodes.iter().map(|node| node.level).max().unwrap_or(0);
        let expected = (run.line.n as f64 / leaf(d) as f64).ln() / (1.0 / share).ln();
        f64::from(levels) / (expected + 1.0)
    };
    let replication = |run: &Counted| run.per_point(|node| node.facts.compared());
    let leaves = |run: &Counted| run.nodes.iter().filter(|node| node.facts.is_leaf()).count() as f64;
    let most = largest(runs.iter().map(replication));
    let slope = growth(runs, "partition").map_or(f64::NAN, |slope| slope.value);
    let figure = |what: String, value, bound| Figure::at_most(what, &on, seed, value, bound);
    vec![
        figure(format!("exponent of |B_O| in m, where 1 - 1/d = {power:.3}"), estimate, power + EXCESS),
        figure("levels over their theorem's number".into(), largest(runs.iter().map(levels)), 1.0),
        figure("steps of partition per doubling of a node".into(), slope, STEPS),
        figure(
            format!("points of all leaves over points, {most:.2}, over leaves"),
            largest(runs.iter().map(|run| replication(run) / leaves(run))),
            1.0,
        ),
    ]
}
