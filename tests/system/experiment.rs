//! Sweeps, their lines, and what `fit` says of them.

use std::fs;
use std::process::Command;

use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Graph, Until, Workers};
use septet_core::{count, simulate};
use septet_lab::experiment::fit::{Conclusion, FitError, FitRequest, Key, fit, speedup};
use septet_lab::experiment::{
    Journal, JournalError, Line, Program, Runner, Sweep, of_run, parse_sizes, read_lines,
};

use septet_protocol::ids::{Group, Phase};
use septet_protocol::ledger::RoundTally;

use crate::common::base;
use crate::common::sets::{Draw, plane};
use crate::oracle::{python, source};

fn sweep(sizes: &str, seeds: u64) -> Sweep {
    Sweep {
        sizes: parse_sizes(sizes).unwrap(),
        sizes_text: sizes.to_string(),
        kinds: vec![Kind::Uniform],
        dimension: 2,
        lipschitz: None,
        workers: vec![Workers::Count(1)],
        first_seed: 1,
        seeds,
        weak: false,
        timed: false,
        until: Some(Until::Neighbours),
        spec: base().with(|c| c.tree.leaf = Some(40)),
    }
}

fn lines(sweep: &Sweep) -> Vec<Line> {
    let mut runner = Runner::default();
    sweep.jobs().iter().map(|job| runner.run(sweep, job, &mut |_, _, _| {}).unwrap()).collect()
}

/// A line whose partition has this depth.
fn with_depth(line: &Line, n: u64, seed: u64, depth: f64) -> Line {
    let mut line = Line { n, asked: n, seed, ..line.clone() };
    let partition = line.phases.iter_mut().filter(|row| row.total.phase == Phase::Partition);
    partition.for_each(|row| row.total.depth = depth.round() as u64);
    line
}

/// Lines with `law(n)` and noise, over `octaves` from 2^10 with 4 sizes each and 5 seeds.
fn made(law: impl Fn(f64) -> f64, octaves: u32, noise: f64) -> Vec<Line> {
    let line = &lines(&sweep("200", 1))[0];
    let mut draw = Draw::new(7);
    let sizes = parse_sizes(&format!("2^10..2^{},per-octave=4", 10 + octaves)).unwrap();
    let mut made = Vec::new();
    for n in sizes {
        for seed in 1..=5 {
            let factor = 1.0 + noise * (draw.unit() + draw.unit() - 1.0);
            made.push(with_depth(line, n, seed, 1000.0 * law(n as f64) * factor));
        }
    }
    made
}

fn conclusion(lines: &[Line]) -> Conclusion {
    let answer = fit(lines, &FitRequest::new(Key::Depth, Some("partition"))).unwrap();
    println!("{}", answer.text());
    answer.series[0].conclusion.clone()
}

#[test]
fn a_run_that_stops_counts_what_the_whole_run_counts() {
    let points = plane(Kind::Uniform, 3000, 5);
    let whole = base().with(|c| {
        c.tree.leaf = Some(100);
        c.recursion.graph = Graph::Density { alpha: Alpha::Value(3.0) };
    });
    let run = simulate(&points, &whole).unwrap();
    for (until, last) in
        [(Until::Partition, "partition"), (Until::Neighbours, "neighbours"), (Until::Graph, "graph")]
    {
        let counts = count(&points, Some(until), &whole).unwrap();
        let all = of_run(&run);
        let part = septet_lab::experiment::of_run(&counts);
        assert_eq!((part.end, part.graph, part.totals.repair), (None, None, None));
        let mut seen = Vec::new();
        for phase in part.phases.iter().filter(|p| p.group() == Group::Paper) {
            let (own, same) = (&phase.total, &all.phase(phase.name()).unwrap().total);
            assert_eq!((own.work, own.depth, own.bytes), (same.work, same.depth, same.bytes));
            seen.push(phase.name());
        }
        assert_eq!(seen.last(), Some(&last));
        assert_eq!((part.tree.levels, part.tree.leaves), (all.tree.levels, all.tree.leaves));
    }
    let all = of_run(&run);
    assert_eq!(all.totals.paper.unwrap().total.depth, run.ledger.totals.paper.depth);
    assert_eq!(all.end.unwrap().cells, run.cell_count() as u64);
    let flat: Vec<_> = (0..50).map(|i| glam::DVec2::new(f64::from(i), 0.0)).collect();
    assert_eq!(
        count(&flat, Some(Until::Partition), &whole).unwrap().ending().unwrap().cells,
        0,
        "points on a line"
    );
}

#[test]
fn a_sweep_goes_on_where_it_was_torn() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("runs.jsonl");
    let sweep = sweep("300,600", 2);
    let all = lines(&sweep);
    let mut journal = Journal::open(&path, &sweep.words()).unwrap();
    all[..3].iter().for_each(|line| journal.append(line).unwrap());
    drop(journal);
    let complete = fs::read(&path).unwrap();
    let torn = [complete.as_slice(), b"{\"schema\":\"septet-sc"].concat();
    fs::write(&path, &torn).unwrap();
    assert_eq!(read_lines(&path).unwrap().lines, all[..3]);
    assert_eq!(read_lines(&path).unwrap().incomplete, 20);
    let mut journal = Journal::open(&path, &sweep.words()).unwrap();
    assert_eq!((journal.done(), journal.dropped), (3, 20));
    let jobs = sweep.jobs();
    let missing: Vec<_> = jobs.iter().filter(|j| !journal.has(j.program, &sweep.command(j))).collect();
    assert_eq!(missing, [&jobs[3]]);
    journal.append(&all[3]).unwrap();
    assert_eq!(read_lines(&path).unwrap().lines, all);
    assert!(fs::read(&path).unwrap().starts_with(&complete));

    let before = fs::read(&path).unwrap();
    let other = Sweep { seeds: 3, ..sweep.clone() };
    let refused = Journal::<Line>::open(&path, &other.words()).unwrap_err();
    assert!(matches!(refused, JournalError::OtherSweep { .. }), "{refused}");
    assert_eq!(fs::read(&path).unwrap(), before, "a refused file does not change");
    let old = Line { version: "0.0.9".to_string(), ..all[0].clone() };
    for (broken, line) in [
        ("{}\n".to_string(), 1),
        (format!("{}\nnonsense\n", serde_json::to_string(&all[0]).unwrap()), 2),
        (format!("{}\n", serde_json::to_string(&old).unwrap()), 0),
    ] {
        fs::write(&path, &broken).unwrap();
        match Journal::<Line>::open(&path, &sweep.words()).unwrap_err() {
            JournalError::Line { line: at, .. } => assert_eq!(at, line),
            JournalError::OtherVersion { there, .. } => assert_eq!((there.as_str(), line), ("0.0.9", 0)),
            error => panic!("{error}"),
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), broken);
    }
}

#[test]
fn growth_laws_are_distinguished_where_sizes_suffice() {
    use septet_lab::experiment::fit::Law;
    let is = |law| Conclusion::Law { law };
    let log = |n: f64| n.log2();
    assert_eq!(conclusion(&made(|n| 3.0 + log(n), 10, 0.02)), is(Law::Log));
    assert_eq!(conclusion(&made(|n| log(n) * log(n), 10, 0.02)), is(Law::LogSquared));
    assert_eq!(conclusion(&made(f64::sqrt, 10, 0.02)), is(Law::Root));
    assert_eq!(conclusion(&made(|_| 5.0, 10, 0.02)), Conclusion::Flat);
    assert_eq!(conclusion(&made(|n| 50.0 - log(n), 10, 0.02)), Conclusion::Falls);
    assert_eq!(conclusion(&made(|n| log(n).ln(), 10, 0.002)), Conclusion::Slower);
    for law in [|n: f64| n * n, |n: f64| n.powf(1.3), |n: f64| n.log2().powi(3)] {
        let lines = made(law, 10, 0.02);
        assert_eq!(conclusion(&lines), Conclusion::NoneOfThese);
        let answer = fit(&lines, &FitRequest::new(Key::Depth, Some("partition"))).unwrap();
        assert!(answer.series[0].words.contains("as a power n^e, e = "), "{}", answer.series[0].words);
    }
    assert_eq!(conclusion(&made(|n| n * log(n), 10, 0.02)), is(Law::LinearLog));
    let short = conclusion(&made(|n| 3.0 + log(n), 2, 0.05));
    let Conclusion::CannotTell { laws } = &short else { panic!("{short:?}") };
    assert!(laws.contains(&Law::Log) && laws.contains(&Law::LogSquared), "{laws:?}");
}

#[test]
fn constant_counts_are_found_constant_or_undecided() {
    use septet_lab::experiment::fit::Law;
    assert_eq!(conclusion(&made(|_| 5.0, 3, 0.02)), Conclusion::Flat);
    assert_eq!(conclusion(&made(|_| 5.0, 3, 0.9)), Conclusion::Unclear, "noise above the margin");
    assert_eq!(
        conclusion(&made(|n| 20.0 + 0.1 * n.log2(), 2, 0.9)),
        Conclusion::Unclear,
        "a trend below the noise"
    );
    assert_eq!(conclusion(&made(f64::log2, 10, 0.05)), Conclusion::Law { law: Law::Log });
    assert_eq!(conclusion(&made(|_| 0.0, 3, 0.0)), Conclusion::Flat);
    let zero = fit(&made(|_| 0.0, 3, 0.0), &FitRequest::new(Key::Depth, Some("partition"))).unwrap();
    assert!(!zero.text().contains("NaN") && !zero.text().contains("inf"), "{}", zero.text());

    let lines = made(f64::log2, 3, 0.02);
    let request = FitRequest { resamples: 10, ..FitRequest::new(Key::Depth, Some("partition")) };
    assert!(fit(&lines, &request).unwrap().series[0].resampled.is_some());
    let few: Vec<Line> = lines.into_iter().filter(|line| line.seed < 3).collect();
    let refused = fit(&few, &request).unwrap_err();
    assert!(matches!(refused, FitError::TooFewSeeds { seeds: 2, least: 3, .. }), "{refused}");
    assert!(refused.remedy().unwrap().to_string().contains("`seeds = 3`"), "{refused}");
}

#[test]
fn seconds_of_other_threads_stand_apart() {
    let mut lines = made(f64::log2, 3, 0.0);
    let twice: Vec<Line> = lines.clone();
    for mut line in twice {
        line.settings.threads += 1;
        lines.push(line);
    }
    let answer = |key| fit(&lines, &FitRequest::new(key, Some("partition"))).unwrap().series;
    assert_eq!(answer(Key::Depth).len(), 1, "counts do not depend on threads");
    let apart = answer(Key::Seconds);
    assert_eq!(apart.len(), 2, "{apart:?}");
    assert!(apart.iter().all(|s| s.name.contains("threads")), "{apart:?}");
}

#[test]
fn the_level_test_needs_its_margin() {
    let mut lines = lines(&sweep("500..4000,per-octave=2", 3));
    let request = FitRequest::new(Key::LevelDepth, Some("partition"));
    let bend = |lines: &mut [Line], slope: f64| {
        for (at, level) in lines.iter_mut().flat_map(|line| &mut line.levels).enumerate() {
            if let Some(depth) = level.detail.depth.get_mut("partition") {
                let log = (level.detail.split_points as f64 / level.detail.splits as f64).log2();
                let noise = if at % 2 == 0 { 1.0 } else { -1.0 };
                depth.sum = ((1000.0 + noise + 1000.0 * slope * (log - 9.0)) * depth.nodes as f64) as u64;
            }
        }
    };
    for (slope, conclusion) in [
        (0.0, Conclusion::SizeFree),
        (0.03, Conclusion::SizeFree),
        (-0.03, Conclusion::SizeFree),
        (0.2, Conclusion::SizeBound),
        (-0.2, Conclusion::SizeBound),
    ] {
        bend(&mut lines, slope);
        let answer = fit(&lines, &request).unwrap();
        println!("{}", answer.text());
        assert_eq!(answer.series[0].conclusion, conclusion, "slope {slope}");
        let test = answer.series[0].levels.unwrap();
        assert!((test.slope.value / 1000.0 - slope).abs() < 0.01, "{slope}: {}", test.slope.value);
    }
    let noisy = FitRequest { margin: 2e-5, ..request };
    bend(&mut lines, 0.0);
    assert_eq!(fit(&lines, &noisy).unwrap().series[0].conclusion, Conclusion::SizeUnclear);
}

#[test]
fn incompatible_runs_are_refused() {
    let lines = lines(&sweep("200,400", 1));
    let ask = |y, phase| fit(&lines, &FitRequest::new(y, phase)).unwrap_err();
    for key in [Key::Depth, Key::Work, Key::Rounds, Key::Messages, Key::Bytes, Key::Seconds] {
        assert!(matches!(ask(key, None), FitError::Mixes { .. }), "{key:?}");
    }
    assert!(matches!(ask(Key::Levels, Some("partition")), FitError::NoPhase { .. }));
    assert!(matches!(ask(Key::Depth, Some("hulls")), FitError::UnknownPhase { .. }));
    assert!(matches!(ask(Key::LevelDepth, Some("paper")), FitError::OnePhase));
    assert!(matches!(ask(Key::Levels, None), FitError::TooFewSizes { sizes: 2, .. }));
    assert!(matches!(ask(Key::Edges, None), FitError::Nothing { .. }));
    assert!(matches!(ask(Key::Depth, Some("repair")), FitError::Nothing { .. }));
    assert!(matches!("speed".parse::<Key>(), Err(FitError::UnknownKey { .. })));
}

/// A count of a round is a count that `fit` knows, without a list of its own.
#[test]
fn counts_of_rounds_can_be_fitted() {
    for count in RoundTally::COUNTS {
        assert!(count.name.parse::<Key>().is_ok_and(Key::of_phase), "{}", count.name);
    }
    let sweep = Sweep { workers: vec![Workers::Count(3)], ..sweep("200,400,800,1600,3200", 2) };
    let lines = lines(&sweep);
    let load: Key = "largest-load".parse().unwrap();
    assert_eq!((load.name(), serde_json::to_value(load).unwrap()), ("largest-load", "largest-load".into()));
    let answer = fit(&lines, &FitRequest::new(load, Some("partition"))).unwrap();
    assert_eq!((answer.series.len(), answer.series[0].runs), (1, lines.len()));
    for line in &lines {
        let loads = line.rounds.iter().filter(|row| row.key.phase == Phase::Partition);
        let most = loads.map(|row| row.tally.largest_load).max().unwrap();
        assert!(most * 3 >= line.n && most < line.n, "{most} of {} points", line.n);
    }
    let text = serde_json::to_string(&lines[0]).unwrap();
    assert_eq!(serde_json::from_str::<Line>(&text).unwrap(), lines[0]);
    // A line of an earlier version has fewer counts.
    let mut old: serde_json::Value = serde_json::from_str(&text).unwrap();
    old.as_object_mut().unwrap().remove("selection");
    for phase in old["phases"].as_array_mut().unwrap() {
        phase.as_object_mut().unwrap().remove("group");
    }
    for round in old["rounds"].as_array_mut().unwrap() {
        for count in ["active", "separators", "retries", "largest_load"] {
            round.as_object_mut().unwrap().remove(count);
        }
    }
    let old: Line = serde_json::from_value(old).unwrap();
    assert_eq!((old.phases, old.totals.selection), (lines[0].phases.clone(), None));
}

#[test]
fn speed_up_is_against_the_serial_kernel() {
    let timed = Sweep { timed: true, seeds: 2, ..sweep("400,800", 2) };
    let timed = Sweep { until: None, ..timed };
    let timed = Sweep { workers: vec![Workers::Count(1), Workers::Count(3)], ..timed };
    timed.check().unwrap();
    let mut lines = lines(&timed);
    let cells = |line: &Line| line.end.unwrap().cells;
    for line in &lines {
        let same = lines.iter().filter(|l| (l.asked, l.seed) == (line.asked, line.seed));
        assert!(same.into_iter().all(|l| cells(l) == cells(line)), "{}", line.title());
    }
    for line in &mut lines {
        line.seconds = match (line.program, line.workers) {
            (Program::Serial, _) => 2.0,
            (_, 1) => 4.0,
            _ => 1.0,
        };
    }
    // A second, slower serial run of the same points is not the best.
    let slow = lines.iter().find(|l| l.program == Program::Serial).cloned().unwrap();
    lines.push(Line { seconds: 9.0, ..slow });
    let rows = speedup(&lines).unwrap();
    let of =
        |workers: &str| rows.iter().filter(|r| r.workers == workers).map(|r| r.speedup).collect::<Vec<_>>();
    assert_eq!(of("1"), [0.5, 0.5], "one worker is compared with the serial kernel as well");
    assert_eq!(of("3"), [2.0, 2.0]);
    assert_eq!(rows[0].efficiency, rows[0].speedup / 2.0, "per thread");
    lines.retain(|line| line.program != Program::Serial);
    assert!(matches!(speedup(&lines), Err(FitError::NoSerial { .. })));
}

#[test]
#[ignore = "needs Python with numpy and scipy"]
fn scipy_computes_the_same() {
    let python = python();
    let directory = tempfile::tempdir().unwrap();
    let (data, answer) = (directory.path().join("runs.jsonl"), directory.path().join("fit.json"));
    let lines = lines(&sweep("300..3000,per-octave=3", 4));
    let text: String = lines.iter().map(|l| serde_json::to_string(l).unwrap() + "\n").collect();
    fs::write(&data, text).unwrap();
    for (key, phase) in [
        (Key::Levels, None),
        (Key::Depth, Some("partition")),
        (Key::Work, Some("neighbours")),
        (Key::LevelDepth, Some("partition")),
        (Key::LevelDepth, Some("neighbours")),
    ] {
        let report = fit(&lines, &FitRequest::new(key, phase)).unwrap();
        fs::write(&answer, serde_json::to_string(&report).unwrap()).unwrap();
        let mut command = Command::new(&python);
        let output = command.arg(source("fit_check.py")).arg(&data).arg(&answer).output().unwrap();
        let printed = String::from_utf8_lossy(&output.stdout);
        println!("{key:?} {phase:?}: {}", printed.trim());
        let complained = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && printed.starts_with("ok "), "{key:?}: {printed}{complained}");
    }
}
