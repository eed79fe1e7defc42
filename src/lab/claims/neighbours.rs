//! Section 4.3, first step: all nearest neighbours as published, by Frieze, Miller and Teng, and by Callahan and Kosaraju.
//!
//! Both find the radii of the descent, which is septet's default. The correction in stages has a depth like log n: its fit is
//! that of the claim `depth-law`. The separators of a run do not depend on the correction.

use std::rc::Rc;

use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Correction, DEFAULT_ALPHA, Graph, Until, Words};

use super::claim::LEVEL;
use super::counted::Counted;
use super::depth_law::of_phase;
use super::lab::{Lab, Runs};
use super::sample::Sample;
use super::sweeps::{LEAF, Sweep, sizes};
use super::{Claim, ClaimError, Extent, Figure, Reading, Role, Statistics};

/// The size of leaves whose well-separated pairs are counted, in points. All pairs of a leaf would be 500 a point.
const LEAF_OF_PAIRS: u64 = 1000;

/// The bounds on the number of well-separated pairs a point, in the plane and in space.
const PAIRS: [(usize, f64); 2] = [(2, 15.0), (3, 30.0)];

/// The sets whose depths are fitted, and the runs of each size. The heights of subtrees vary most on a line.
const SETS: [(Kind, usize, u64); 3] = [(Kind::Uniform, 2, 1), (Kind::Uniform, 3, 1), (Kind::Line, 3, 2)];

/// The smallest number of points of a fit. A tree with fewer levels than about 2 d has fewer than d stages at most nodes.
const SMALLEST: u64 = 2048;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "neighbours-published",
    role: Role::Test,
    statistics: Some(Statistics {
        level: LEVEL,
        fault: "always-punt",
        caught: 6,
        of: 6,
        smallest: "always-punt, at 6 of 6 seeds",
    }),
    source: "Section 4.3, step 1; Frieze, Miller and Teng (1993); Callahan and Kosaraju (1995)",
    statement: "all nearest neighbours take O(log n) depth, by sphere separators with punting or by well-separated pairs",
    reading: Reading::AsRead {
        instead: "the depth is claimed for `fmt`; the pairs of `pairs` are those within leaves, and only counted",
        because: "septet has the fair split tree of each leaf, not of all points, and balls descend across leaves",
    },
    experiment: "Radii of `fmt` and `pairs` that differ from those of `descent` in a bit, on uniform sets, clusters, a line, \
                 a graded set and a lattice. Fit of the depth of phase neighbours with `fmt` as in depth-law, over seven \
                 octaves from 2,048 points, on a line with two runs of each size. Well-separated pairs a point in leaves of 1,000 points, s = 2",
    bound: "0 radii, by definition; 10 % for the quadratic share, as in depth-law; 15 pairs in the plane and 30 in space: \
            all pairs of a leaf are up to 500 a point",
    check: |lab| Ok([radii(lab)?, depths(lab)?, pairs(lab)?].concat()),
}];

/// Returns the configuration with a correction, in leaves of one size.
fn with_correction(spec: Spec, correction: Correction, leaf: u64) -> Spec {
    spec.with(|c| {
        c.tree.leaf = Some(leaf);
        c.recursion.graph = Graph::Density { alpha: Alpha::Value(DEFAULT_ALPHA) };
        c.recursion.neighbours = correction;
    })
}

fn radii(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let n = lab.size(6000, 40_000);
    let mut figures = Vec::new();
    for kind in [Kind::Uniform, Kind::Clusters, Kind::Line, Kind::GradedPoint, Kind::Grid] {
        for d in [2, 3] {
            let sample = Sample::new(kind, n, d);
            let expected = radii2(lab, sample, Correction::Descent)?;
            for correction in [Correction::Stages, Correction::Pairs] {
                let found = radii2(lab, sample, correction)?;
                let same = found.iter().zip(&expected).filter(|(a, b)| a == b).count();
                let differ = found.len().max(expected.len()) - same;
                let what = format!("radii of `{}` that differ, of {}", correction.name(), expected.len());
                figures.push(Figure::at_most(what, sample.name(), lab.seed(), differ as f64, 0.0));
            }
        }
    }
    Ok(figures)
}

/// Returns the input index of each point and the bits of the squared radius of its ball.
fn radii2(lab: &mut Lab, sample: Sample, correction: Correction) -> Result<Vec<(u64, u64)>, ClaimError> {
    let seed = lab.seed();
    let run = lab.counts(sample, seed, Some(Until::Neighbours), |spec| {
        with_correction(spec, correction, LEAF).with(|c| c.keep.graph = true)
    })?;
    let radii2 = run.kept.radii2.unwrap_or_default();
    Ok(radii2.into_iter().map(|(point, radius2)| (point, radius2.to_bits())).collect())
}

fn depths(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let octaves = if lab.options.extent == Extent::Brief { 4 } else { 7 };
    let mut figures = Vec::new();
    for (kind, d, seeds) in SETS {
        let samples = sizes(SMALLEST, octaves, kind, d);
        let runs = of_stages(lab, &samples, seeds)?;
        let name = format!("{} {d}D n={SMALLEST}..{}, {} runs", kind.name(), SMALLEST << octaves, runs.len());
        let punts: u64 = runs.iter().map(|run| run.line.tree.punts).sum();
        let sweep = Sweep { name, phases: &["neighbours"], runs };
        let mut figure = of_phase(&sweep, "neighbours", lab.seed());
        figure.what = format!("{}, {punts} punts", figure.what);
        figures.push(figure);
    }
    Ok(figures)
}

/// Returns the runs with the correction in stages, of as many seeds for each set.
fn of_stages(lab: &mut Lab, samples: &[Sample], seeds: u64) -> Result<Rc<Vec<Counted>>, ClaimError> {
    let name = format!("stages {}", samples.first().map(Sample::name).unwrap_or_default());
    let runs = Runs { name: &name, samples, seeds, until: Some(Until::Neighbours) };
    lab.counted(&runs, |spec| with_correction(spec, Correction::Stages, LEAF))
}

fn pairs(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let (n, seed) = (lab.size(30_000, 200_000), lab.seed());
    let mut figures = Vec::new();
    for (d, most) in PAIRS {
        let sample = Sample::new(Kind::Uniform, n, d);
        let name = format!("pairs {}", sample.name());
        let runs = Runs { name: &name, samples: &[sample], seeds: 1, until: Some(Until::Neighbours) };
        let runs = lab.counted(&runs, |spec| with_correction(spec, Correction::Pairs, LEAF_OF_PAIRS))?;
        for run in runs.iter() {
            let found = run.line.tree.pairs as f64 / run.line.n as f64;
            figures.push(Figure::at_most("well-separated pairs a point", sample.name(), seed, found, most));
            // A set without pairs has no nearest neighbours.
            figures.push(Figure::at_least("well-separated pairs a point", sample.name(), seed, found, 0.5));
        }
    }
    Ok(figures)
}
