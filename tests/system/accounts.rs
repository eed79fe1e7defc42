//! Two accounts of work and depth, by the ledger and from the cost trace, on all kinds of runs.

mod messages;

use glam::DVec3;
use septet_core::generate::Kind;
use septet_core::run::CostTrace;
use septet_core::spec::{
    Alpha, Correction, Graph, GraphKind, Neighbours, Partition, Purpose, SeparatorSets, Workers,
};
use septet_core::{Outcome, Spec, independent, simulate};
use septet_geometry::point::Point;
use septet_lab::accounts::{AccountError, Accounts, fold};
use septet_lab::report::{CostHeader, ledger_counts, write_cost_trace};
use septet_protocol::ledger::Ledger;

use crate::common::sets::{plane, space};
use crate::common::{combinations, threaded, with_graph};

const LEAF: u64 = 60;

/// The configuration that keeps the calls of primitives.
fn traced(workers: Workers) -> Spec {
    threaded(workers, 2, LEAF).with(|c| c.keep.costs = true)
}

fn text_of(header: CostHeader, trace: &CostTrace) -> Vec<u8> {
    let mut text = Vec::new();
    write_cost_trace(&mut text, header, trace).unwrap();
    text
}

fn text<P: Point>(points: &[P], spec: &Spec) -> (Outcome, Vec<u8>) {
    let run = simulate(points, spec).unwrap_or_else(|e| panic!("{spec:?}: {e}"));
    let header = CostHeader::of(spec, &run.settled, run.points.used, run.space);
    let text = text_of(header, run.kept.costs.as_ref().expect("kept"));
    (run, text)
}

fn assert_equal(text: &[u8], ledger: &Ledger, what: &str) -> Accounts {
    let accounts = fold(text).unwrap_or_else(|e| panic!("{what}: {e}"));
    let differences = accounts.differences(&ledger_counts(ledger));
    let rows: Vec<String> = differences.iter().map(ToString::to_string).collect();
    assert!(rows.is_empty(), "{what}: {rows:#?}");
    accounts
}

/// Both accounts are equal, and equal for all numbers of workers. Returns the last run.
fn on_machines<P: Point>(points: &[P], what: &str, change: impl Fn(&mut Spec)) -> Outcome {
    let mut first: Option<Accounts> = None;
    let mut last = None;
    for workers in [Workers::Count(1), Workers::Count(3), Workers::Count(16), Workers::Leaves] {
        let spec = traced(workers).with(&change);
        let what = format!("{what}, {workers:?}");
        let (run, text) = text(points, &spec);
        let accounts = assert_equal(&text, &run.ledger, &what);
        assert!(accounts.paper.work > 0 && accounts.paper.depth > 0, "{what}");
        assert_eq!(&accounts, first.get_or_insert_with(|| accounts.clone()), "{what}");
        last = Some(run);
    }
    last.expect("four runs")
}

#[test]
fn accounts_agree_on_all_graphs_in_space() {
    let points = space(Kind::Uniform, 1500, 6);
    for choice in combinations(false) {
        on_machines(&points, &format!("{choice:?}"), |c| *c = with_graph(c, choice));
    }
}

#[test]
fn accounts_agree_on_all_graphs_in_the_plane() {
    let points = plane(Kind::GradedPoint, 2000, 6);
    for choice in combinations(true) {
        on_machines(&points, &format!("{choice:?}"), |c| *c = with_graph(c, choice));
    }
}

#[test]
fn accounts_agree_on_baselines() {
    let points = space(Kind::Uniform, 1500, 2);
    on_machines(&points, "planes", |c| c.tree.partition = Partition::Kd);
    on_machines(&points, "along a curve", |c| c.tree.partition = Partition::Hilbert);
    on_machines(&points, "bottom-up", |c| c.recursion.neighbours = Correction::BottomUp);
    on_machines(&points, "in stages", |c| c.recursion.neighbours = Correction::Stages);
    on_machines(&points, "by pairs", |c| c.recursion.neighbours = Correction::Pairs);
    on_machines(&plane(Kind::Uniform, 2000, 3), "bottom-up in the plane", |c| {
        c.recursion.neighbours = Correction::BottomUp;
    });
}

/// Both accounts of one run are equal. Returns the run.
fn on_one_machine<P: Point>(points: &[P], what: &str, change: impl Fn(&mut Spec)) -> Outcome {
    let (run, text) = text(points, &traced(Workers::Count(3)).with(change));
    assert_equal(&text, &run.ledger, what);
    let header = text.split(|&byte| byte == b'\n').next().expect("a header");
    let header: serde_json::Value = serde_json::from_slice(header).unwrap();
    assert_eq!(header["dimension"], P::DIM, "{what}");
    run
}

#[test]
fn accounts_agree_on_all_kinds_of_sets() {
    for kind in Kind::all() {
        on_one_machine(&plane(kind, 500, 3), &format!("{kind} in the plane"), |_| {});
        on_one_machine(&space(kind, 500, 3), &format!("{kind} in space"), |_| {});
    }
}

/// The automatic parameters, with each rule that shares separator points, and with the constants for time.
#[test]
fn accounts_agree_on_automatic_parameters() {
    let (flat, solid) = (plane(Kind::GradedPoint, 1500, 4), space(Kind::WellSpaced, 1500, 4));
    let unions = |choice: &(GraphKind, SeparatorSets, _, _)| choice.1 != SeparatorSets::Ghost;
    for choice in combinations(true).into_iter().filter(unions) {
        on_one_machine(&flat, &format!("{choice:?} in the plane"), |c| *c = with_graph(c, choice));
        on_one_machine(&solid, &format!("{choice:?} in space"), |c| *c = with_graph(c, choice));
    }
    // Without a fixed leaf size, the purpose decides it.
    let timing = |c: &mut Spec| (c.tree.constants.purpose, c.tree.leaf) = (Purpose::Timing, None);
    let leaf = |run: &Outcome| run.settled.leaf;
    assert_eq!(leaf(&on_one_machine(&flat, "timing in the plane", timing)), 500);
    assert!(leaf(&on_one_machine(&solid, "timing in space", timing)) >= 1000);
}

/// A graph that is too small leaves stars for splaying, and a small cap of rounds gathers them.
#[test]
fn accounts_agree_on_repair_and_gathering() {
    let points = space(Kind::Uniform, 900, 8);
    let small = |c: &mut Spec| c.recursion.graph = Graph::Knn { k: Neighbours::Count(3) };
    let run = on_machines(&points, "repair", small);
    assert!(run.exchange_rounds > 1 && run.ledger.totals.repair.depth > 0, "{}", run.exchange_rounds);
    for cap in [0, 2] {
        let gathered = on_machines(&points, "gathering", |c| {
            small(c);
            c.planted.exchange_cap = Some(cap);
        });
        assert!(gathered.fallback.is_some(), "{cap}");
    }
    on_machines(&space(Kind::Clusters, 1500, 4), "clusters", |_| {});
}

/// Balls to the k-th neighbour have the phases of balls to the first one. In clusters, some of them probe.
#[test]
fn accounts_agree_on_balls_to_any_neighbour() {
    for sets in [SeparatorSets::Ghost, SeparatorSets::Both] {
        on_machines(&space(Kind::Clusters, 900, 4), "balls to the fifth neighbour", |c| {
            c.recursion.graph = Graph::Overlap { alpha: Alpha::Value(1.5), k: Neighbours::Count(5) };
            c.recursion.sets = sets;
        });
    }
}

#[test]
fn accounts_agree_on_independent_sets() {
    let places = space(Kind::Uniform, 1500, 5);
    let sizes = vec![0.12; places.len()];
    for workers in [Workers::Count(1), Workers::Count(3), Workers::Count(16), Workers::Leaves] {
        for fixed in [0, 50] {
            let spec = traced(workers);
            let (places, sizes) =
                if fixed == 0 { (&places[..], &sizes[..]) } else { (&places[..1200], &sizes[..1200]) };
            let run = independent(places, sizes, fixed, &spec).unwrap();
            let header = CostHeader::of(&spec, &run.settled, places.len() as u64, 3);
            let text = text_of(header, run.kept.costs.as_ref().unwrap());
            let accounts = assert_equal(&text, &run.ledger, &format!("{workers:?}, {fixed} fixed"));
            assert!(accounts.phases.iter().any(|phase| phase.phase == "independent" && phase.depth > 0));
        }
    }
}

#[test]
fn degenerate_sets_have_both_accounts() {
    let flat: Vec<DVec3> = (0..40).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
    let (run, text) = text(&flat, &traced(Workers::Count(2)));
    assert_equal(&text, &run.ledger, "a line");
    let lattice = crate::common::sets::grid([7, 7, 7], 1.0);
    on_machines(&lattice, "a lattice", |_| {});
}

#[test]
fn a_run_without_a_request_keeps_no_calls() {
    let run = simulate(&space(Kind::Uniform, 300, 1), &threaded(Workers::Count(2), 2, LEAF)).unwrap();
    assert!(run.kept.costs.is_none());
}

/// A change of one row of a trace: without it, without its references, or with other items.
fn broken(text: &str, row: usize, change: &dyn Fn(&str) -> Option<String>) -> Result<Accounts, AccountError> {
    let lines = text
        .lines()
        .enumerate()
        .filter_map(|(at, line)| if at == row + 1 { change(line) } else { Some(line.to_owned()) });
    fold(lines.map(|line| line + "\n").collect::<String>().as_bytes())
}

#[test]
fn changed_traces_are_detected() {
    let spec = traced(Workers::Count(3));
    let (run, text) = text(&space(Kind::Uniform, 400, 3), &spec);
    let text = String::from_utf8(text).unwrap();
    let counts = ledger_counts(&run.ledger);
    let found = |result: Result<Accounts, AccountError>| {
        result.is_err() || !result.unwrap().differences(&counts).is_empty()
    };
    assert!(!found(broken(&text, usize::MAX - 1, &|_| None)));
    let rows = text.lines().count() - 1;
    let replaced = |line: &str, from: &str, to: &dyn Fn(u64) -> String| {
        let (head, tail) = line.split_once(from)?;
        let end = tail.find(|c: char| !c.is_ascii_digit()).unwrap_or(tail.len());
        let value: u64 = tail[..end].parse().ok()?;
        Some(format!("{head}{from}{}{}", to(value), &tail[end..]))
    };
    let mut changed = 0;
    for row in (0..rows).step_by(7) {
        assert!(found(broken(&text, row, &|_| None)), "row {row} removed");
        let line = text.lines().nth(row + 1).unwrap();
        if let Some((head, _)) = line.split_once("\"after\":[").filter(|_| row > 0) {
            let loose = format!("{head}\"after\":[]}}");
            assert!(found(broken(&text, row, &|_| Some(loose.clone()))), "row {row} without references");
        }
        let is_call = !line.contains("\"barrier\"") && !line.contains("\"lanes\"");
        if let Some(other) =
            replaced(line, "\"items\":", &|items| (items + 1).to_string()).filter(|_| is_call)
        {
            assert!(found(broken(&text, row, &|_| Some(other.clone()))), "row {row} with another item");
            changed += 1;
        }
    }
    assert!(changed > 20, "{changed}");
}

#[test]
fn traces_are_small_enough() {
    let (run, text) = text(&space(Kind::WellSpaced, 20_000, 1), &traced(Workers::Count(4)));
    assert_equal(&text, &run.ledger, "20,000 points");
    println!("{} bytes, {} rows", text.len(), run.kept.costs.map_or(0, |trace| trace.rows().len()));
    assert!(text.len() < 50_000_000, "{} bytes", text.len());
}
