//! Planted faults do what their texts say, with the same counts for any number of workers.

use std::collections::BTreeSet;

use glam::DVec3;

use crate::common::sets::{plane, space};
use crate::common::{assert_same_counts, combinations, simulated, with_graph};
use septet_core::generate::Kind;
use septet_core::spec::{
    Alpha, Correction, FAULTS, Fault, Graph, GraphKind, Neighbours, SeparatorSets, Workers,
};
use septet_core::{Outcome, Spec, independent, simulate, triangulate};
use septet_geometry::point::Point;
use septet_geometry::separator::Ablation;
use septet_protocol::ids::{Flow, Group, NodeId, Phase};
use septet_protocol::ledger::{Account, Charge, Ledger, NodeKind, Role};

const LEAF: u64 = 60;

/// The numbers of workers that must agree.
const WORKERS: [u32; 3] = [1, 3, 16];

type Choice = (GraphKind, SeparatorSets, Alpha, Neighbours);

const DENSITY: Choice = (GraphKind::Density, SeparatorSets::Ghost, Alpha::Value(2.5), Neighbours::Auto);

fn planted(text: &str) -> Fault {
    text.parse().unwrap_or_else(|e| panic!("{e}"))
}

/// A machine with this fault, if there is one.
fn machine(workers: u32, fault: Option<&str>) -> Spec {
    simulated(Workers::Count(workers), 0, LEAF).with(|c| {
        c.planted.fault = fault.map(planted);
        c.keep.graph = true;
    })
}

fn run<P: Point>(points: &[P], workers: u32, choice: Choice, fault: Option<&str>) -> Outcome {
    let spec = with_graph(&machine(workers, fault), choice);
    simulate(points, &spec).unwrap_or_else(|e| panic!("{choice:?}, {workers} workers, {fault:?}: {e}"))
}

/// Runs with a fault on all numbers of workers, which must find the cells of the right run and agree on all counts.
fn runs<P: Point>(points: &[P], choice: Choice, fault: &str, right: &Outcome) -> Vec<Outcome> {
    let all: Vec<Outcome> = WORKERS.iter().map(|&p| run(points, p, choice, Some(fault))).collect();
    for (faulty, workers) in all.iter().zip(WORKERS) {
        let what = format!("{fault}, {choice:?}, {workers} workers");
        assert!(faulty.cells() == right.cells(), "{what}: other cells");
        assert_same_counts(&all[0].ledger, &faulty.ledger, &what);
    }
    all
}

fn leaves(ledger: &Ledger) -> u64 {
    ledger.part.nodes.values().filter(|facts| facts.is_leaf()).count() as u64
}

fn members(ledger: &Ledger) -> u64 {
    ledger.part.nodes.values().map(|facts| facts.members).sum()
}

fn visits(ledger: &Ledger) -> u64 {
    ledger.part.nodes.values().map(|facts| facts.visits).sum()
}

fn bytes(ledger: &Ledger) -> u64 {
    ledger.phases.iter().map(|phase| phase.bytes).sum()
}

/// Every point reaches every leaf: members, messages and work rise, and the result is the same. With own separators, all
/// points are one set.
fn flooded<P: Point>(points: &[P]) {
    let n = points.len() as u64;
    for choice in combinations(false) {
        let right = run(points, 1, choice, None);
        let all = runs(points, choice, "flood", &right);
        for (flooded, workers) in all.iter().zip(WORKERS) {
            let what = format!("{choice:?}, {workers} workers");
            let plain = run(points, workers, choice, None);
            assert!(flooded.kept.graph == plain.kept.graph, "{what}: another graph");
            if choice.1 == SeparatorSets::Own {
                // No separator divides a set whose balls all meet it, so all points are in one set.
                assert_eq!(members(&flooded.ledger), n, "{what}");
                continue;
            }
            assert!(flooded.ledger.totals.paper.work > plain.ledger.totals.paper.work, "{what}");
            assert!(workers == 1 || bytes(&flooded.ledger) > bytes(&plain.ledger), "{what}: no more bytes");
            let leaves = leaves(&flooded.ledger);
            assert!(leaves > 8, "{what}: {leaves} leaves");
            if choice.0 == GraphKind::Knn && choice.1 == SeparatorSets::Ghost {
                assert!(visits(&flooded.ledger) >= n * (leaves - 1), "{what}");
                assert!(visits(&plain.ledger) < n * (leaves - 1) / 2, "{what}");
            } else {
                assert_eq!(members(&flooded.ledger), n * leaves, "{what}");
                assert!(members(&plain.ledger) < n * leaves, "{what}");
            }
        }
    }
}

#[test]
fn a_flood_reaches_every_leaf_in_space() {
    flooded(&space(Kind::Uniform, 900, 3));
}

#[test]
fn a_flood_reaches_every_leaf_in_the_plane() {
    flooded(&plane(Kind::Clusters, 900, 3));
}

#[test]
fn far_ghosts_are_more_ghosts() {
    let points = space(Kind::Uniform, 900, 4);
    for choice in combinations(false).into_iter().filter(|choice| choice.0 != GraphKind::Knn) {
        let right = run(&points, 1, choice, None);
        let mut before = members(&right.ledger);
        for fault in ["far-ghosts:1.5", "flood"] {
            let all = runs(&points, choice, fault, &right);
            assert!(all[0].kept.graph == right.kept.graph, "{fault}, {choice:?}: another graph");
            let found = members(&all[0].ledger);
            // Sets with their own separators are divided less often if more balls meet the separators.
            assert!(
                found > before || choice.1 == SeparatorSets::Own,
                "{fault}, {choice:?}: {found}, {before}"
            );
            before = found;
        }
        let same = runs(&points, choice, "far-ghosts:1", &right);
        assert_same_counts(&same[0].ledger, &right.ledger, "the factor 1");
    }
}

/// Half the points are missing in other leaves: the graph loses edges, and splaying finds the cells all the same.
#[test]
fn halves_lose_edges() {
    let points = space(Kind::Uniform, 1500, 5);
    for choice in combinations(false).into_iter().filter(|choice| choice.0 != GraphKind::Knn) {
        let right = run(&points, 1, choice, None);
        let edges: BTreeSet<_> = right.kept.graph.iter().flatten().collect();
        let ghost = choice.1 == SeparatorSets::Ghost;
        for (fault, acts) in [("half-ghosts", ghost), ("half-separators", !ghost)] {
            let all = runs(&points, choice, fault, &right);
            let found: BTreeSet<_> = all[0].kept.graph.iter().flatten().collect();
            let what = format!("{fault}, {choice:?}: {} of {} edges", found.len(), edges.len());
            assert!(found.is_subset(&edges), "{what}");
            assert_eq!(found.len() < edges.len(), acts, "{what}");
        }
    }
}

/// Balls that stay at the first neighbour have the graph and the counts of k = 1.
#[test]
fn first_balls_are_those_of_one_neighbour() {
    let points = space(Kind::Clusters, 900, 5);
    for sets in [SeparatorSets::Ghost, SeparatorSets::Both] {
        let of = |k| (GraphKind::Overlap, sets, Alpha::Value(1.5), Neighbours::Count(k));
        let (one, four) = (run(&points, 1, of(1), None), run(&points, 1, of(4), None));
        let faulty = &runs(&points, of(4), "first-ball", &four)[0];
        assert!(faulty.kept.graph == one.kept.graph && one.kept.graph != four.kept.graph, "{sets:?}");
        assert_same_counts(&faulty.ledger, &one.ledger, "first-ball");
    }
}

/// With the fault, every split node punts, for any number of workers. Without it, none of these does.
#[test]
fn every_node_punts() {
    let points = plane(Kind::Uniform, 900, 5);
    for (fault, workers) in
        [None, Some(planted("always-punt"))].into_iter().flat_map(|f| WORKERS.map(|w| (f, w)))
    {
        let spec = simulated(Workers::Count(workers), 5, LEAF).with(|c| {
            c.recursion.graph = Graph::Density { alpha: Alpha::Value(2.5) };
            c.recursion.neighbours = Correction::Stages;
            c.planted.fault = fault;
        });
        let total = simulate(&points, &spec).unwrap().ledger.tree.total();
        let expected = if fault.is_some() { total.nodes - total.leaves } else { 0 };
        assert_eq!(total.punts, expected, "{fault:?}, {workers} workers");
    }
}

#[test]
fn ablations_draw_other_separators() {
    let points = space(Kind::Clusters, 1500, 6);
    let right = run(&points, 1, DENSITY, None);
    let root = |run: &Outcome| run.ledger.part.nodes[&NodeId::ROOT];
    for ablation in Ablation::ALL {
        let all = runs(&points, DENSITY, ablation.name(), &right);
        assert_ne!(root(&all[0]).separator, root(&right).separator, "{ablation:?}");
        let is_planar = [Ablation::RandomPlanes, Ablation::MedianPlanes].contains(&ablation);
        let inner = all[0].ledger.part.nodes.values().filter(|facts| !facts.is_leaf());
        let planes = inner.clone().filter(|facts| facts.kind == NodeKind::Plane).count();
        let expected = if is_planar { inner.count() } else { 0 };
        assert!(planes >= expected && (is_planar || root(&all[0]).kind == NodeKind::Sphere), "{ablation:?}");
        let spec = machine(3, Some(ablation.name()));
        let direct = triangulate(&points, &spec).unwrap_or_else(|e| panic!("{ablation:?}: {e}"));
        assert!(direct.cells() == right.cells(), "{ablation:?}: other cells of `triangulate`");
    }
}

/// The faults of charges that every phase of the paper must be able to have.
const OF_PHASES: [&str; 5] =
    ["free:PHASE", "work:PHASE:2", "work:PHASE:0.5", "slow:PHASE:log", "slow:PHASE:root3"];

/// Returns work and depth of a charge under a fault. `points` is the number of points to which a law applies.
fn expected(fault: &str, charge: &Charge, points: u64) -> [u64; 2] {
    let (work, depth, points) = (charge.cost.work(), charge.cost.depth(), points as f64);
    match fault {
        "free:PHASE" => [1, 1],
        "work:PHASE:2" => [2 * work, depth],
        "work:PHASE:0.5" => [work.div_ceil(2), depth],
        "slow:PHASE:log" => [work, depth + (points.ln() / 2f64.ln()).round() as u64],
        "slow:PHASE:root3" => [work, depth + points.powf(1.0 / 3.0).round() as u64],
        _ => unreachable!("{fault}"),
    }
}

/// Returns `true` if the account is the sum over the steps of a node, which the ledger computes from their charges.
fn is_sum(account: Account) -> bool {
    account.phase.flow() == Flow::Steps && account.role == Role::Member
}

/// Plants the faults of each phase that a run charges. Only the charges of that phase change, as the fault says. Returns
/// the phases.
fn charged(what: &str, run: impl Fn(u32, Option<&str>) -> Ledger) -> BTreeSet<Phase> {
    let right = run(1, None);
    let phases: BTreeSet<Phase> = right.part.charges.keys().map(|account| account.phase).collect();
    let phases: BTreeSet<Phase> = phases.into_iter().filter(|phase| phase.group() == Group::Paper).collect();
    let all = right.part.nodes[&NodeId::ROOT].population;
    for &phase in &phases {
        for fault in OF_PHASES {
            let text = fault.replace("PHASE", phase.name());
            let faulty = run(1, Some(&text));
            assert_eq!(faulty.part.charges.len(), right.part.charges.len(), "{what}, {text}");
            for (account, charge) in right.part.charges.iter().filter(|(account, _)| !is_sum(**account)) {
                let cost = faulty.part.charges[account].cost;
                if account.phase != phase {
                    assert_eq!(cost, charge.cost, "{what}, {text}: {account:?}");
                    continue;
                }
                let facts = right.part.nodes[&account.node];
                let points = if facts.is_leaf() { all } else { facts.population };
                let found = [cost.work(), cost.depth()];
                assert_eq!(found, expected(fault, charge, points), "{what}, {text}: {account:?}");
            }
            assert_same_counts(&faulty, &run(5, Some(&text)), &format!("{what}, {text}, 5 workers"));
        }
    }
    phases
}

#[test]
fn charges_of_every_phase_can_be_wrong() {
    // Within a leaf, the balls differ so much that some of them probe.
    let graded = |p: DVec3| DVec3::new(p.x.powi(5), p.y.powi(5), p.z.powi(5));
    let points: Vec<DVec3> = space(Kind::Uniform, 400, 7).into_iter().map(graded).collect();
    let of = |choice| charged(&format!("{choice:?}"), |p, fault| run(&points, p, choice, fault).ledger);
    let mut phases = of(DENSITY);
    phases.extend(of((GraphKind::Density, SeparatorSets::Both, Alpha::Value(2.5), Neighbours::Auto)));
    phases.extend(of((GraphKind::Density, SeparatorSets::Own, Alpha::Value(2.5), Neighbours::Auto)));
    phases.extend(of((GraphKind::Knn, SeparatorSets::Ghost, Alpha::Auto, Neighbours::Count(12))));
    let sizes: Vec<f64> = points.iter().map(|p| 1e-3 + 0.1 * p.distance(points[0])).collect();
    phases.extend(charged("independent", |p, fault| {
        independent(&points, &sizes, 0, &machine(p, fault))
            .unwrap_or_else(|e| panic!("{fault:?}: {e}"))
            .ledger
    }));
    let paper: BTreeSet<Phase> =
        Group::Paper.phases().filter(|phase| !Phase::OF_MESHES.contains(phase)).collect();
    assert_eq!(phases, paper);
}

/// A phase that costs one step at each node has a depth of one step for each level of the tree, or 1 if it is local.
#[test]
fn a_free_phase_has_one_step_on_each_level() {
    let points = space(Kind::Uniform, 1500, 8);
    let right = run(&points, 1, DENSITY, None);
    let levels = right.ledger.part.nodes.keys().map(|node| u64::from(node.level())).max().unwrap();
    let depth = |fault: &str, phase: Phase| {
        let run = run(&points, 3, DENSITY, Some(fault));
        run.ledger.phases.iter().find(|total| total.phase == phase).unwrap().depth
    };
    assert_eq!(depth("free:hulls", Phase::Hulls), 1);
    assert_eq!(depth("free:radii", Phase::Radii), 1);
    assert_eq!(depth("free:partition", Phase::Partition), levels + 1);
    let before = right.ledger.phases.iter().find(|total| total.phase == Phase::Hulls).unwrap().depth;
    // The chain of a phase within leaves has one node.
    assert_eq!(depth("slow:hulls:root3:10", Phase::Hulls), before + 114);
}

#[test]
fn radii_are_charged_as_loops() {
    let points = space(Kind::Uniform, 1500, 9);
    let right = run(&points, 1, DENSITY, None);
    let sizes =
        right.ledger.part.nodes.values().filter(|facts| facts.is_leaf()).map(|facts| facts.population);
    let largest = sizes.max().unwrap();
    for (fault, work, depth) in [("sequential-leaf", None, largest * largest), ("free-loop", Some(1500), 1)] {
        for faulty in runs(&points, DENSITY, fault, &right) {
            let radii = faulty.ledger.phases.iter().find(|total| total.phase == Phase::Radii).unwrap();
            assert_eq!(radii.depth, depth, "{fault}");
            assert!(work.is_none_or(|work| work == radii.work), "{fault}");
        }
    }
}

/// The guide explains every fault, in the words of the list.
#[test]
fn the_guide_lists_every_fault() {
    let guide = include_str!("../../src/guide/experiments.md");
    for form in FAULTS {
        let row = format!("| `{}` | {} |", form.text, form.effect);
        assert!(guide.contains(&row), "the guide does not contain {row}");
    }
}
