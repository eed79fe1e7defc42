//! Checks of single runs. Every run must satisfy the bound. A check of a phase fails if a run does not have this
//! phase.

use crate::experiment::fit::{FitRequest, Key};
use crate::experiment::{Line, Splits};
use crate::rows::{LevelRow, PhaseRow};
use septet_protocol::ids::Phase;
use septet_protocol::ledger::RoundRow;

use super::broken::{Broken, Row, compare, describe, nothing, short};
use super::counts::HasCounts;

fn logarithm(n: f64, slope: f64, constant: f64) -> f64 {
    slope * n.max(1.0).log2() + constant
}

fn law(slope: f64, constant: f64) -> String {
    let (sign, size) = if constant < 0.0 { ('-', -constant) } else { ('+', constant) };
    format!("{} log2 n {sign} {}", short(slope), short(size))
}

/// Checks that the partition tree has at most `slope log2 n + constant` levels below the root.
///
/// # Errors
/// Fails if a run has more.
pub fn levels(counted: &impl HasCounts, slope: f64, constant: f64) -> Result<(), Broken> {
    tree_levels(&counted.lines(), &law(slope, constant), |line| logarithm(line.n as f64, slope, constant))
}

/// Checks that the partition tree has at most `slope log2(n / leaf) + constant` levels below the root.
///
/// # Errors
/// Fails if a run has more.
pub fn levels_over_leaf(counted: &impl HasCounts, slope: f64, constant: f64) -> Result<(), Broken> {
    let text = law(slope, constant).replace("log2 n", "log2(n/leaf)");
    tree_levels(&counted.lines(), &text, |line| {
        logarithm(line.n as f64 / line.leaf.max(1) as f64, slope, constant)
    })
}

fn tree_levels(lines: &[Line], text: &str, bound: impl Fn(&Line) -> f64) -> Result<(), Broken> {
    let count = |line: &Line| (f64::from(line.tree.levels), bound(line));
    let first = |line: &Line, bound: f64| {
        let level = line.levels.iter().find(|level| f64::from(level.level) > bound)?;
        let LevelRow { level, nodes, points, .. } = level;
        Some(format!("level above the bound: level {level}, {nodes} nodes with {points} points"))
    };
    compare(lines, "levels of the tree", text, count, Some(&FitRequest::new(Key::Levels, None)), first)
}

/// Checks that the depth of every subproblem that was split is at most `most` in this phase, at every level and size.
///
/// # Errors
/// Fails if a level has a larger depth.
pub fn depth_of_levels(counted: &impl HasCounts, phase: &str, most: u64) -> Result<(), Broken> {
    let of_level = |level: &LevelRow<Splits>| level.detail.depth.get(phase).map_or(0, |depth| depth.largest);
    let count = |line: &Line| {
        // A run without a level in this phase fails the check.
        let largest = line.levels.iter().filter(|l| l.detail.depth.contains_key(phase)).map(of_level).max();
        (largest.map_or(f64::NAN, |depth| depth as f64), most as f64)
    };
    let first = |line: &Line, bound: f64| {
        let level = line.levels.iter().find(|level| of_level(level) as f64 > bound)?;
        let (depth, LevelRow { level: number, largest, .. }) = (of_level(level), level);
        Some(format!(
            "level above the bound: level {number}, depth {depth}, largest node of {largest} points"
        ))
    };
    let question = FitRequest::new(Key::LevelDepth, Some(phase));
    let what = format!("largest depth of a subproblem in {phase}");
    compare(&counted.lines(), &what, "the limit", count, Some(&question), first)
}

/// Checks that the phase sends messages in at most `slope log2 n + constant` rounds.
///
/// # Errors
/// Fails if a run has more such rounds.
pub fn rounds(counted: &impl HasCounts, phase: &str, slope: f64, constant: f64) -> Result<(), Broken> {
    let count = |line: &Line| {
        let rounds = line.phase(phase).map_or(f64::NAN, |p| p.total.rounds as f64);
        (rounds, logarithm(line.n as f64, slope, constant))
    };
    let first = |line: &Line, bound: f64| {
        let sent = |r: &&RoundRow| r.key.phase.name() == phase && r.tally.messages > 0;
        line.rounds.iter().filter(sent).nth(bound.max(0.0) as usize).map(describe)
    };
    let question = FitRequest::new(Key::Rounds, Some(phase));
    let what = format!("rounds of {phase}");
    compare(&counted.lines(), &what, &law(slope, constant), count, Some(&question), first)
}

/// Checks that results of subproblems are merged in at most `slope log2 n + constant` rounds. The number of merged
/// results must be the number of leaves minus one.
///
/// # Errors
/// Fails if a run has more such rounds, or a different number of merged results.
pub fn merges(counted: &impl HasCounts, slope: f64, constant: f64) -> Result<(), Broken> {
    let lines = counted.lines();
    let merging =
        |line: &Line| line.rounds.iter().filter(|r| r.tally.merged > 0).copied().collect::<Vec<_>>();
    for line in &lines {
        let merged: u64 = merging(line).iter().map(|r| r.tally.merged).sum();
        let splits = line.tree.nodes - line.tree.leaves;
        if merged != splits {
            return Err(Broken {
                what: format!("results merged: {merged} of {splits} splits"),
                table: vec![Row::at_most(line, merged as f64, splits as f64)],
                fit: None,
                first: merging(line).first().map(describe),
            });
        }
    }
    let count = |line: &Line| (merging(line).len() as f64, logarithm(line.n as f64, slope, constant));
    let first = |line: &Line, bound: f64| merging(line).get(bound.max(0.0) as usize).map(describe);
    compare(&lines, "rounds that merge results", &law(slope, constant), count, None, first)
}

/// Checks that the phase sends at most `slope log2 n + constant` messages per worker.
///
/// # Errors
/// Fails if a run sends more.
pub fn messages_per_worker(
    counted: &impl HasCounts,
    phase: &str,
    slope: f64,
    constant: f64,
) -> Result<(), Broken> {
    let count = |line: &Line| {
        let messages = line.phase(phase).map_or(f64::NAN, |p| p.total.messages as f64);
        (messages / f64::from(line.workers.max(1)), logarithm(line.n as f64, slope, constant))
    };
    let first = |line: &Line, bound: f64| {
        beyond(line, phase, bound * f64::from(line.workers.max(1)), |round| round.tally.messages)
    };
    let question = FitRequest::new(Key::Messages, Some(phase));
    let what = format!("messages of {phase} per worker");
    compare(&counted.lines(), &what, &law(slope, constant), count, Some(&question), first)
}

/// Checks that the phase sends at most `factor n^(1 - 1/d)` bytes: a multiple of the size of one separator set.
///
/// # Errors
/// Fails if a run sends more.
pub fn bytes(counted: &impl HasCounts, phase: &str, factor: f64) -> Result<(), Broken> {
    let count = |line: &Line| {
        let surface = (line.n as f64).powf(1.0 - 1.0 / line.dimension as f64);
        (line.phase(phase).map_or(f64::NAN, |p| p.total.bytes as f64), factor * surface)
    };
    let first = |line: &Line, bound: f64| beyond(line, phase, bound, |round| round.tally.bytes);
    let question = FitRequest::new(Key::Bytes, Some(phase));
    let text = format!("{} n^(1-1/d)", short(factor));
    compare(&counted.lines(), &format!("bytes of {phase}"), &text, count, Some(&question), first)
}

/// Describes the first round of a phase at which the running sum of `of` exceeds the bound.
fn beyond(line: &Line, phase: &str, bound: f64, of: impl Fn(&RoundRow) -> u64) -> Option<String> {
    let mut sum = 0;
    let over = |round: &&RoundRow| {
        sum += of(round);
        sum as f64 > bound
    };
    line.rounds.iter().filter(|r| r.key.phase.name() == phase).find(over).map(describe)
}

/// Checks that no star changed after the local hulls, that there was no splaying, and that no points were gathered.
/// The supergraph then contained the triangulation.
///
/// # Errors
/// Fails if a run repaired stars, or stopped early.
pub fn no_repair(counted: &impl HasCounts) -> Result<(), Broken> {
    let count = |line: &Line| {
        let end = line.end.map(|end| end.exchange_rounds + end.stars_repaired + end.gathered);
        (end.map_or(f64::NAN, |sum| sum as f64), 0.0)
    };
    let first = |line: &Line, _: f64| {
        line.rounds.iter().find(|r| r.key.phase == Phase::Repair && r.tally.messages > 0).map(describe)
    };
    let question = FitRequest::new(Key::ExchangeRounds, None);
    let what = "rounds of splaying, stars changed and points gathered";
    compare(&counted.lines(), what, "none", count, Some(&question), first)
}

/// Checks that the counts that do not depend on the number of workers are equal in all runs. These are the numbers of
/// points, the tree, its levels, the graph, the result, and the work and depth of every phase of the paper and of
/// repair.
///
/// # Errors
/// Fails if there are fewer than two runs, or if two runs differ. The error names the difference.
pub fn same_counts(counted: &impl HasCounts) -> Result<(), Broken> {
    let lines = counted.lines();
    let Some((reference, others)) = lines.split_first() else { return Err(nothing("same counts")) };
    if others.is_empty() {
        let what = "same counts: there is only one run".to_string();
        return Err(Broken { what, table: Vec::new(), fit: None, first: None });
    }
    for line in others {
        if let Some(first) = difference(reference, line) {
            return Err(Broken {
                what: format!("counts differ between {} and {} workers", reference.workers, line.workers),
                table: Vec::new(),
                fit: None,
                first: Some(first),
            });
        }
    }
    Ok(())
}

/// Returns the first count in which two runs differ.
fn difference(a: &Line, b: &Line) -> Option<String> {
    let differs = |what: String, a: &dyn std::fmt::Debug, b: &dyn std::fmt::Debug| {
        Some(format!("difference: {what}: {a:?} and {b:?}"))
    };
    if a.n != b.n {
        return differs("points".to_string(), &a.n, &b.n);
    }
    if a.tree != b.tree {
        return differs("the tree".to_string(), &a.tree, &b.tree);
    }
    for (x, y) in a.levels.iter().zip(&b.levels) {
        let of = |level: &LevelRow<Splits>| {
            let mut level = level.clone();
            level.detail.depth.retain(|_, depth| depth.sum > 0);
            level
        };
        if of(x) != of(y) {
            return differs(format!("level {}", x.level), x, y);
        }
    }
    let counts = |p: &PhaseRow| [p.total.work, p.total.depth, p.total.depth_log_scan, p.total.exact_tests];
    for phase in a.phases.iter().filter(|p| p.group().counts_work()) {
        let own = counts(phase);
        let other = b.phase(phase.name()).map_or([0; 4], counts);
        if own != other {
            let what =
                format!("work, depth, depth with scans at log m, and exact tests, of {}", phase.name());
            return differs(what, &own, &other);
        }
    }
    let sums = |line: &Line| line.totals.paper.map(|sums| sums.total);
    if sums(a) != sums(b) {
        return differs("the paper's phases together".to_string(), &sums(a), &sums(b));
    }
    if a.graph != b.graph {
        return differs("the graph".to_string(), &a.graph, &b.graph);
    }
    (a.end != b.end).then(|| format!("difference: the result: {:?} and {:?}", a.end, b.end))
}
