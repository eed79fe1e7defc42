//! The paper's claims on how a run grows, with one worker per leaf: every split and merge is a message.

use crate::common::sets::{plane, space};
use crate::common::simulated;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Graph, Workers};
use septet_core::{Outcome, simulate};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_lab::assert_counts;
use septet_lab::assertions::HasCounts;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;

/// Rounds of the phases that go over the tree: at most A log2 n + B. Measured from 2^12 to 2^15 points: 21 to
/// 52 of partition (4 a level, 9 in groups of more than 33 ranks), 10 to 12 of the descent (2 a level, at most),
/// 8 to 11 of the merge (1 a level, 1 to the coordinator and 2 for its decision).
const ROUNDS: [(&str, f64, f64); 3] =
    [("partition", 10.0, -95.0), ("neighbours", 2.0, -12.0), ("merge", 1.25, -6.0)];

fn rounds_are_logarithmic(run: &Outcome, what: &str) {
    let log = (run.points.used as f64).log2();
    for (phase, slope, constant) in ROUNDS {
        assert_counts!(run, rounds(phase, slope, constant));
    }
    // Each is one round of messages. Measured: up to 14 of 46 changed stars at 2^12 points in the plane.
    assert!(run.exchange_rounds as f64 <= 1.5 * log, "{what}: {} rounds of exchange", run.exchange_rounds);
}

/// Balls that cross a separator of m points: at most 5 alpha m^(1 - 1/d). Attempts: 1.5 on average.
fn separators_are_small(run: &Outcome, what: &str) {
    let Some(Supergraph::Density { alpha }) = run.settled.supergraph else { panic!("{what}: no alpha") };
    let power = 1.0 - 1.0 / run.space as f64;
    let split: Vec<_> = run.ledger.part.nodes.values().filter(|facts| !facts.is_leaf()).collect();
    let mut largest = 0.0f64;
    for facts in &split {
        let crossing = (facts.crossing_inside + facts.crossing_outside) as f64;
        largest = largest.max(crossing / (alpha * (facts.population as f64).powf(power)));
    }
    println!("{what}: |B_O| / (alpha m^(1-1/d)) at most {largest:.2}");
    assert!(largest <= 5.0, "{what}: separator of {largest} alpha m^(1-1/d)");
    let attempts: u64 = split.iter().map(|facts| facts.attempts).sum();
    let mean = attempts as f64 / split.len().max(1) as f64;
    assert!(mean <= 1.5, "{what}: {mean} attempts per separator");
}

/// The depth of a split does not depend on its size.
fn depth_is_flat(run: &Outcome, what: &str) {
    let part = &run.ledger.part;
    let once = part.nodes.iter().filter(|(_, facts)| {
        !facts.is_leaf() && facts.attempts == 1 && facts.population > 2 * run.settled.leaf
    });
    let depths: Vec<u64> =
        once.map(|(node, _)| part.charges[&Account::member(Phase::Partition, *node)].cost.depth()).collect();
    // Measured: 5 splits or more.
    assert!(depths.len() >= 4, "{what}: {} splits above twice the leaf", depths.len());
    let (low, high) = (depths.iter().min().unwrap(), depths.iter().max().unwrap());
    println!("{what}: depth of a split {low} to {high}, {} splits", depths.len());
    assert!(*high as f64 <= 1.5 * *low as f64, "{what}: depth of a split from {low} to {high}");
}

fn grow<P: Point>(kind: Kind, make: fn(Kind, u64, u64) -> Vec<P>, leaf: u64) {
    let mut lines = Vec::new();
    for exponent in 12..=15 {
        let points = make(kind, 1 << exponent, 31);
        let spec = simulated(Workers::Leaves, 2, leaf)
            .with(|c| c.recursion.graph = Graph::Density { alpha: Alpha::Value(2.5) });
        let run = simulate(&points, &spec).unwrap();
        let what = format!("{kind}, {}D, 2^{exponent}", P::DIM);
        assert_eq!(run.fallback, None, "{what}");
        let leaves = run.ledger.part.nodes.values().filter(|facts| facts.is_leaf()).count();
        assert_eq!(run.settled.workers as usize, leaves, "{what}: one worker per leaf");
        // Levels below the root, and rounds that merge results: one for each level and that of the leaves.
        assert_counts!(run, levels_over_leaf(1.5, 2.0), merges(1.25, -7.0));
        rounds_are_logarithmic(&run, &what);
        separators_are_small(&run, &what);
        depth_is_flat(&run, &what);
        let (total, log) = (run.ledger.totals.paper, (run.points.used as f64).log2());
        println!("{what}: depth {} = {:.0} log2 n", total.depth, total.depth as f64 / log);
        lines.extend(run.lines());
    }
    assert_counts!(lines, level_depth_flat("partition", 0.05), level_depth_flat("neighbours", 0.05));
}

#[test]
fn counts_grow_as_claimed_on_uniform_sets_in_space() {
    grow(Kind::Uniform, space, 500);
}

#[test]
fn counts_grow_as_claimed_on_well_spaced_sets_in_space() {
    grow(Kind::WellSpaced, space, 500);
}

#[test]
fn counts_grow_as_claimed_on_uniform_sets_in_the_plane() {
    grow(Kind::Uniform, plane, 250);
}

#[test]
fn counts_grow_as_claimed_on_well_spaced_sets_in_the_plane() {
    grow(Kind::WellSpaced, plane, 250);
}
