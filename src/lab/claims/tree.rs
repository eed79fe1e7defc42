//! Theorem 4.4 and Lemma 4.5: levels, depth and work of the tree and the neighbour balls, by phase and by level.
//!
//! In a total over all phases, the constant of the local hulls hides the growth of the recursion. Levels are
//! therefore bounded for every seed, the depth of each level is tested for flatness, and each phase is checked
//! separately.

use std::rc::Rc;

use crate::experiment::Line;
use crate::experiment::fit::{FitError, FitRequest, Key, MARGIN, fit};
use septet_core::Config;
use septet_core::config::Until;
use septet_core::generate::Kind;

use super::lab::{Lab, Sample};
use super::machine::depth_over_levels;
use super::{Claim, ClaimError, Extent, Figure, Reading};

/// Largest leaf: at least the 256 points that the neighbours need, and small enough for many levels.
const LEAF: u64 = 256;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "levels",
        source: "Lemma 4.5, Theorem 4.4",
        statement: "the recursion has O(log n) levels",
        reading: Reading::AsPrinted,
        experiment: "Levels below the root minus 2, over log2(n/leaf); the maximum over all sizes and seeds",
        bound: "1.5: 1.05 to 1.3 measured; the split ratio proves 9.6",
        check: levels,
    },
    Claim {
        name: "partition-level-depth",
        source: "Section 2, Lemma 4.5",
        statement: "a separator is found in constant time with n processors, for every n",
        reading: Reading::AsPrinted,
        experiment: "Slope of the mean depth of a level's splits against log2 of their size: two one-sided tests of 5 %",
        bound: "5 % of the mean depth per doubling; a depth that grows like log m has at least 7 %",
        check: |lab| level_depth(lab, "partition"),
    },
    Claim {
        name: "neighbours-level-depth",
        source: "Section 4.3",
        statement: "the neighbourhood system takes O(log n) time, a constant for every level of the descent",
        reading: Reading::AsPrinted,
        experiment: "Slope of the mean depth of the descent of the neighbour balls per level, tested like `partition-level-depth`",
        bound: "5 % of the mean depth per doubling; a correction node by node has a slope of at least half its depth",
        check: |lab| level_depth(lab, "neighbours"),
    },
    Claim {
        name: "tree-depth",
        source: "Lemma 4.5, Theorem 4.4",
        statement: "tree and neighbour balls take O(log n) depth on an EREW PRAM with unit-time scans",
        reading: Reading::AsPrinted,
        experiment: "Depth of either phase over levels plus 1 (`levels` bounds the levels), at the largest n over the smallest",
        bound: "1.35: a constant per level plus a constant gives at most 1.3; a constant per pair of levels gives at least 1.5",
        check: depth,
    },
    Claim {
        name: "tree-work",
        source: "Lemma 4.5, Theorem 4.4",
        statement: "tree and neighbour balls take O(n log n) work",
        reading: Reading::AsPrinted,
        experiment: "Work of the phases over n log2 n: the mean at the largest size over the mean at the smallest",
        bound: "1.1: over a factor of 8 in n, n^1.2 would have 1.2 and n^(4/3) 1.6; smaller powers cannot be distinguished from a logarithm",
        check: work,
    },
];

fn sweep(lab: &mut Lab, kind: Kind, d: usize) -> Result<Rc<Vec<Line>>, ClaimError> {
    let spaced = kind == Kind::WellSpaced;
    let (octaves, parts, seeds) = match (spaced, lab.options.extent) {
        (_, Extent::Brief) => (3, 1, 3),
        (true, Extent::Quick) => (3, 2, 4),
        (true, Extent::Full) => (8, 4, 10),
        (false, Extent::Quick) => (5, 2, 4),
        (false, Extent::Full) => (12, 2, 5),
    };
    let size = |i: u32| (4096.0 * (f64::from(i) / f64::from(parts)).exp2()).round() as u64;
    let samples: Vec<Sample> = (0..=octaves * parts).map(|i| Sample::new(kind, size(i), d)).collect();
    let name = format!("tree {} {d}", kind.name());
    let stop = |config: Config| {
        config.with(|c| {
            c.until = Some(Until::Neighbours);
            c.machine.leaf = Some(LEAF);
        })
    };
    lab.lines(&name, &samples, seeds, stop)
}

/// A sweep and its name.
type Named = (String, Rc<Vec<Line>>);

/// Returns the sweeps.
fn sweeps(lab: &mut Lab) -> Result<Vec<Named>, ClaimError> {
    let mut all = Vec::new();
    let sets = [(Kind::WellSpaced, 3), (Kind::WellSpaced, 2), (Kind::Uniform, 3), (Kind::Uniform, 2)];
    for &(kind, d) in &sets[..if lab.brief() { 1 } else { 4 }] {
        let lines = sweep(lab, kind, d)?;
        let sizes = || lines.iter().map(|line| line.n);
        let (least, most) = (sizes().min().unwrap_or(0), sizes().max().unwrap_or(0));
        all.push((format!("{} {d}D n={least}..{most}, {} runs", kind.name(), lines.len()), lines));
    }
    Ok(all)
}

fn levels(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let slope = |line: &Line| (f64::from(line.tree.levels) - 2.0) / (line.n as f64 / line.leaf as f64).log2();
    let figure = |(on, lines): Named| {
        let largest = lines.iter().map(slope).fold(f64::NEG_INFINITY, f64::max);
        Figure::at_most("(levels - 2) / log2(n/leaf), largest of all runs", on, seed, largest, 1.5)
    };
    Ok(sweeps(lab)?.into_iter().map(figure).collect())
}

fn level_depth(lab: &mut Lab, phase: &str) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let mut figures = Vec::new();
    for (on, lines) in sweeps(lab)? {
        let report = match fit(&lines, &FitRequest::new(Key::LevelDepth, Some(phase))) {
            Ok(report) => report,
            Err(error @ FitError::TooFewLevels { .. }) => {
                figures.push(Figure::at_most(error.to_string(), &on, seed, f64::NAN, MARGIN));
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        for test in report.series.iter().filter_map(|series| series.levels) {
            let share = 100.0 * test.slope.value / test.mean;
            let what = format!("smallest margin found flat (slope {share:.2} % of {:.0} steps)", test.mean);
            figures.push(Figure::at_most(what, &on, seed, test.smallest_margin, MARGIN));
        }
    }
    Ok(figures)
}

/// Phases of the tree and the neighbour balls.
const PHASES: [&str; 3] = ["partition", "probe", "neighbours"];

fn depth(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for (_, lines) in sweeps(lab)? {
        let Some(line) = lines.first() else { continue };
        let kind = format!("{} {}D", line.kind, line.dimension);
        for phase in ["partition", "neighbours"] {
            figures.extend(depth_over_levels(&lines, phase, &kind));
        }
    }
    Ok(figures)
}

fn work(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let mut figures = Vec::new();
    for (on, lines) in sweeps(lab)? {
        let relative = |line: &Line| {
            let work: u64 = PHASES.iter().filter_map(|name| line.phase(name)).map(|p| p.work).sum();
            work as f64 / (line.n as f64 * (line.n as f64).log2())
        };
        let mean = |asked: Option<u64>| {
            let of: Vec<f64> = lines.iter().filter(|line| Some(line.asked) == asked).map(relative).collect();
            of.iter().sum::<f64>() / of.len() as f64
        };
        let asked = || lines.iter().map(|line| line.asked);
        let (first, last) = (mean(asked().min()), mean(asked().max()));
        let what = format!("work over n log2 n, {last:.0} at the largest n over {first:.0} at the smallest");
        figures.push(Figure::at_most(what, on, seed, last / first, 1.1));
    }
    Ok(figures)
}
