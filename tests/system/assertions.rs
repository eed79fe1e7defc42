//! Assertions on counts pass for valid counts, and describe the violation for others.

use septet_core::generate::Kind;
use septet_core::simulate;
use septet_core::spec::Workers;
use septet_lab::assert_counts;
use septet_lab::assertions::{
    Broken, HasCounts, bytes, depth_of_levels, grows_like, level_depth_flat, levels, levels_over_leaf,
    merges, messages_per_worker, no_repair, rounds, same_counts, surface_bytes,
};
use septet_lab::experiment::Line;
use septet_lab::experiment::fit::{FitRequest, Key, Law};
use septet_protocol::ids::{Group, Phase};

use crate::common::sets::plane;
use crate::common::{base, simulated};

fn line(workers: Workers) -> Line {
    let spec = simulated(workers, 1, 60).with(|c| c.recursion.spacing = Some(0.0));
    let run = simulate(&plane(Kind::WellSpaced, 2000, 3), &spec).unwrap();
    run.lines().remove(0)
}

fn says(result: Result<(), Broken>, words: &[&str]) {
    let text = result.expect_err("beyond the bound").to_string();
    println!("{text}\n");
    for word in words {
        assert!(text.contains(word), "`{word}` is not in:\n{text}");
    }
}

#[test]
fn nothing_passes_where_there_is_nothing() {
    let line = line(Workers::Count(2));
    says(rounds(&line, "merges", 9.0, 99.0), &["rounds of merges"]);
    says(messages_per_worker(&line, "merges", 9.0, 99.0), &["messages of merges"]);
    says(bytes(&line, "merges", 1e9), &["bytes of merges"]);
    says(depth_of_levels(&line, "merges", 1000), &["in merges"]);
    says(same_counts(&line), &["there is only one run"]);
    says(no_repair(&Vec::<Line>::new()), &["no run"]);
}

#[test]
fn bounds_hold_or_name_the_round() {
    let line = line(Workers::Leaves);
    assert_counts!(
        line,
        levels(1.5, -7.0),
        levels_over_leaf(1.5, 2.0),
        depth_of_levels("partition", 1000),
        rounds("merge", 1.5, -6.0),
        merges(1.5, -7.0),
        messages_per_worker("merge", 0.0, 4.0),
        bytes("separator-sets", 1e5),
        no_repair(),
    );
    let merged: Vec<u32> = line.rounds.iter().filter(|r| r.tally.merged > 0).map(|r| r.key.round).collect();
    let sent: Vec<u32> = line
        .rounds
        .iter()
        .filter(|r| r.key.phase == Phase::Merge && r.tally.messages > 0)
        .map(|r| r.key.round)
        .collect();
    says(levels(&line, 0.0, 2.0), &["levels of the tree: ", "0 log2 n + 2", "level 3", "<- above the bound"]);
    says(levels_over_leaf(&line, 0.1, 0.0), &["log2(n/leaf)", "level 1"]);
    says(depth_of_levels(&line, "partition", 3), &["partition: ", "level 0", "largest node of"]);
    says(rounds(&line, "merge", 0.0, 2.0), &[&format!("round {} of merge", sent[2])]);
    says(merges(&line, 0.0, 3.0), &[&format!("round {} of merge", merged[3]), "0 log2 n + 3"]);
    says(
        messages_per_worker(&line, "partition", 0.0, 0.5),
        &["round", "of partition", "messages of partition"],
    );
    says(bytes(&line, "separator-sets", 1e-3), &["n^(1-1/d)", "of separator-sets"]);
    let lost =
        Line { tree: septet_lab::rows::TreeRow { nodes: line.tree.nodes + 2, ..line.tree }, ..line.clone() };
    says(merges(&lost, 2.0, 0.0), &["results merged: "]);
    let mut repaired = line.clone();
    repaired.end.as_mut().unwrap().stars_repaired = 7;
    says(no_repair(&repaired), &["7 above 0"]);
    says(no_repair(&Line { end: None, ..line.clone() }), &["NaN"]);
    says(levels(&Vec::<Line>::new(), 9.0, 9.0), &["no runs"]);
}

#[test]
fn the_same_counts_over_workers() {
    let all = [line(Workers::Count(1)), line(Workers::Count(5)), line(Workers::Leaves)];
    assert_counts!(all, same_counts());
    let differs = |change: &dyn Fn(&mut Line), word: &str| {
        let mut other = all[1].clone();
        change(&mut other);
        says(same_counts(&[&all[0], &other]), &["between 1 and 5 workers", word]);
    };
    differs(&|l| l.tree.attempts += 1, "the tree");
    differs(&|l| l.levels[1].attempts += 1, "level 1");
    differs(
        &|l| l.phases.iter_mut().filter(|p| p.group() == Group::Paper).for_each(|p| p.total.depth += 1),
        "of partition: ",
    );
    differs(&|l| l.graph.as_mut().unwrap().edges -= 1, "the graph");
    differs(&|l| l.end.as_mut().unwrap().cells += 1, "the result");
}

/// A sweep with the depth of partition and the bytes of separator sets as given.
fn sweep(depth: impl Fn(f64) -> f64, bytes: impl Fn(f64) -> f64) -> Vec<Line> {
    let line = line(Workers::Count(4));
    let mut lines = Vec::new();
    for exponent in 0..9u32 {
        for seed in 1..4u64 {
            let n = 1000u64 << exponent;
            let wobble = 1.0 + 0.002 * ((u64::from(exponent) * 7 + seed * 5) % 3) as f64;
            let mut line = Line { n, asked: n, seed, ..line.clone() };
            for phase in &mut line.phases {
                match phase.name() {
                    "partition" => phase.total.depth = (depth(n as f64) * wobble) as u64,
                    "separator-sets" => phase.total.bytes = (bytes(n as f64) * wobble) as u64,
                    _ => {}
                }
            }
            lines.push(line);
        }
    }
    lines
}

#[test]
fn growth_holds_or_shows_the_fit() {
    let request = FitRequest::new(Key::Depth, Some("partition"));
    let log = sweep(|n| 1000.0 * n.log2(), |n| 900.0 * n.sqrt());
    assert_counts!(log, grows_like(&request, Law::Log, 0.1), surface_bytes("separator-sets", 0.02));
    let bent = sweep(|n| 100.0 * n.log2() * n.log2(), |n| 900.0 * n.powf(0.7));
    says(
        grows_like(&bent, &request, Law::Log, 1.0),
        &["expected log n", "quadratic term", "R^2", "first round"],
    );
    // A bend below the detectable one excludes higher laws as half of the count, but not as a share of 1 in 10,000.
    let bending = sweep(|n| 1000.0 * n.log2() + 0.01 * n.log2() * n.log2(), |n| 900.0 * n.sqrt());
    assert_counts!(bending, grows_like(&request, Law::Log, 0.5));
    says(grows_like(&bending, &request, Law::Log, 1e-4), &["log n: a share of", "is not excluded"]);
    says(
        surface_bytes(&bent, "separator-sets", 0.02),
        &["exponent of bytes", "above 0.52", "round to check"],
    );
    let bytes = FitRequest::new(Key::Bytes, Some("separator-sets"));
    assert_counts!(bent, exponent(&bytes, 0.75));
    says(grows_like(&bent[..2].to_vec(), &request, Law::Log, 1.0), &["1 sizes do not determine"]);

    let mut levels = log.clone();
    let tilt = |lines: &mut [Line], slope: f64| {
        for level in lines.iter_mut().flat_map(|line| &mut line.levels) {
            if let Some(depth) = level.detail.depth.get_mut("partition") {
                let log = (level.detail.split_points as f64 / level.detail.splits as f64).log2();
                depth.sum = ((1000.0 + 1000.0 * slope * (log - 8.0)) * depth.nodes as f64) as u64;
            }
        }
    };
    tilt(&mut levels, 0.0);
    assert_counts!(levels, level_depth_flat("partition", 0.05));
    tilt(&mut levels, 0.3);
    says(
        level_depth_flat(&levels, "partition", 0.05),
        &["slope per doubling", "margin, stated in advance", "first level away from the mean: level "],
    );
    says(level_depth_flat(&levels[..1].to_vec(), "partition", 0.05), &["do not determine a slope"]);
}

#[test]
#[should_panic(expected = "levels(0.0, 1.0): levels of the tree")]
fn the_macro_panics_with_the_message() {
    let spec = base().with(|c| c.tree.leaf = Some(60));
    let run = simulate(&plane(Kind::Uniform, 500, 3), &spec).unwrap();
    assert_counts!(run, levels(0.0, 1.0));
}
