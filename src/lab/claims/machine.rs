//! The algorithm on the machine: results are merged round by round, and counts do not depend on the number of workers.

use crate::assertions::{HasCounts, same_counts};
use crate::experiment::Line;
use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::spec::Workers;

use super::lab::{Lab, Runs};
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

const LEAF: u64 = 256;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "merged-per-round",
        role: Role::Illustration,
        statistics: None,
        source: "Theorem 4.4, on the machine",
        statement: "results of subproblems are merged round by round, in O(log n) rounds",
        reading: Reading::AsPrinted,
        experiment: "One worker per leaf: rounds that merge results, minus 2, over log2(n/leaf); merged results in total \
                     against splits; most results merged in one round against half the leaves",
        bound: "1.5, as for the levels; equal to the splits; half the leaves",
        check: merged,
    },
    Claim {
        name: "rounds",
        role: Role::Illustration,
        statistics: None,
        source: "Theorem 4.4, on the machine",
        statement: "the machine's rounds follow the levels: per level, 4 down for separators, 2 for balls, 1 up",
        reading: Reading::AsPrinted,
        experiment: "One worker per leaf: rounds of partition, neighbours and merge over the levels of the recursion, \
                     plus 1, plus the levels of the tree that carries decisions to all workers; a level of the \
                     partition counts twice while more than 33 workers share it",
        bound: "6, 2 and 1: the rounds of a level, and half as many again if a separator is redrawn",
        check: rounds,
    },
    Claim {
        name: "free-of-workers",
        role: Role::Test,
        statistics: None,
        source: "Theorem 4.4",
        statement: "time with n processors is a property of the algorithm: work and depth do not depend on the machine",
        reading: Reading::AsPrinted,
        experiment: "Tree, graph, work and depth of every phase with 1, 3 and 16 workers and with one per leaf",
        bound: "0 runs that differ",
        check: free_of_workers,
    },
];

fn sizes(lab: &Lab) -> &'static [u64] {
    lab.by_extent(&[4096, 8192, 16_384], &[4096, 16_384, 65_536, 262_144])
}

/// Returns the lines of runs with one worker per leaf.
fn lines(lab: &mut Lab, d: usize) -> Result<Vec<Line>, ClaimError> {
    let samples: Vec<Sample> = sizes(lab).iter().map(|&n| Sample::new(Kind::WellSpaced, n, d)).collect();
    let leaves = |spec: Spec| {
        spec.with(|c| {
            c.machine.workers = Workers::Leaves;
            c.tree.leaf = Some(LEAF);
        })
    };
    let seeds = lab.by_extent(2, 5);
    let name = format!("leaves {d}");
    let runs = lab.counted(&Runs { name: &name, samples: &samples, seeds, until: None }, leaves)?;
    Ok(runs.iter().map(|run| run.line.clone()).collect())
}

fn named(line: &Line) -> String {
    format!("well-spaced {}D n={}, {} workers", line.dimension, line.n, line.workers)
}

fn merged(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for line in [lines(lab, 2)?, lines(lab, 3)?].concat() {
        let merged: Vec<u64> = line.rounds.iter().map(|r| r.tally.merged).filter(|&m| m > 0).collect();
        let slope = (merged.len() as f64 - 2.0) / (line.n as f64 / line.leaf as f64).log2();
        let profile: Vec<String> = merged.iter().map(u64::to_string).collect();
        let what =
            format!("(rounds that merge - 2) / log2(n/leaf); merged round by round: {}", profile.join(" "));
        let (on, seed) = (named(&line), line.seed);
        figures.push(Figure::at_most(what, &on, seed, slope, 1.5));
        let sum: u64 = merged.iter().sum();
        let off = sum.abs_diff(line.tree.nodes - line.tree.leaves) as f64;
        figures.push(Figure::at_most(format!("results merged, {sum}, minus splits"), &on, seed, off, 0.0));
        let most = merged.iter().max().map_or(f64::NAN, |&most| most as f64);
        let half = (line.tree.leaves / 2) as f64;
        figures.push(Figure::at_most("most results merged in one round", &on, seed, most, half));
    }
    Ok(figures)
}

fn rounds(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for line in [lines(lab, 2)?, lines(lab, 3)?].concat() {
        for (phase, bound) in [("partition", 6.0), ("neighbours", 2.0), ("merge", 1.0)] {
            let rounds = line.phase(phase).map_or(f64::NAN, |p| p.total.rounds as f64);
            let (levels, tree) = (line.tree.levels, levels_of_ranks(line.workers));
            let again = if phase == "partition" { large_levels(line.workers) } else { 0 };
            let per_level = rounds / f64::from(levels + 1 + tree + again);
            let what = format!("rounds of {phase}, {rounds}, over {levels} levels plus {}", 1 + tree + again);
            figures.push(Figure::at_most(what, named(&line), line.seed, per_level, bound));
        }
    }
    Ok(figures)
}

/// Returns the number of levels below the coordinator in a tree of fan 32 that contains all workers.
fn levels_of_ranks(workers: u32) -> u32 {
    let (mut levels, mut reached, mut width) = (0, 0, 1);
    while reached < u64::from(workers) {
        (levels, width) = (levels + 1, 32 * width);
        reached += width;
    }
    levels
}

/// Returns the number of levels of the partition at which more than 33 workers share a node, if every node halves them.
/// The tree of such a group has a second level.
fn large_levels(workers: u32) -> u32 {
    (0..32).take_while(|level| workers.div_ceil(1 << level) > 33).count() as u32
}

fn free_of_workers(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let n = lab.by_extent(4096, 65_536);
    let mut figures = Vec::new();
    for d in [2, 3] {
        let sample = Sample::new(Kind::WellSpaced, n, d);
        let mut all: Vec<Line> = Vec::new();
        for workers in [Workers::Count(1), Workers::Count(3), Workers::Count(16), Workers::Leaves] {
            let change = |spec: Spec| {
                spec.with(|c| {
                    c.machine.workers = workers;
                    c.tree.leaf = Some(LEAF);
                })
            };
            all.extend(lab.run(sample, lab.seed(), change)?.lines());
        }
        let differ = all[1..].iter().filter(|line| same_counts(&[&all[0], *line]).is_err()).count();
        let depths: Vec<String> = all
            .iter()
            .map(|line| line.totals.paper.map_or(0, |paper| paper.total.depth).to_string())
            .collect();
        let what = format!("runs that differ from one worker's; depths {}", depths.join(" "));
        figures.push(Figure::at_most(what, sample.name(), lab.seed(), differ as f64, 0.0));
    }
    Ok(figures)
}
