//! The counts of the ledger and their dependence on workers, transport, input and configuration.

use crate::common::sets::{plane, space};
use crate::common::transports::{TestTransport, each_transport};
use crate::common::{assert_same_counts, combinations, simulated, threaded, with_graph, with_workers};
use septet_core::generate::Kind;
use septet_core::spec::Workers;
use septet_core::{Outcome, Spec, simulate, triangulate};
use septet_geometry::point::Point;
use septet_lab::assert_counts;
use septet_protocol::ids::{COORDINATOR, Group, Phase};
use septet_protocol::ledger::{LinkKey, PhaseTotal};

const LEAF: u64 = 40;

fn counted<P: Point>(points: &[P], spec: &Spec) -> Outcome {
    simulate(points, spec).unwrap_or_else(|e| panic!("{spec:?}: {e}"))
}

fn over_machines<P: Point>(points: &[P], choice: usize) {
    let choice = combinations(false)[choice];
    let reference = counted(points, &with_graph(&threaded(Workers::Count(1), 1, LEAF), choice));
    for workers in [2, 3, 5, 64, 300].map(Workers::Count).into_iter().chain([Workers::Leaves]) {
        let spec = with_graph(&with_workers(workers, LEAF), choice);
        let sim = TestTransport::Sim(4).run(points, &spec, true).unwrap();
        assert_same_counts(&reference.ledger, &sim.ledger, &format!("{choice:?}, {workers:?}"));
        assert_counts!([&reference, &sim], same_counts());
        // Rounds, messages and bytes depend on the workers, but neither on transport nor on delivery.
        let same_rounds = |start: TestTransport| {
            let what = format!("{choice:?}, {workers:?}, {start:?}");
            let other = start.run(points, &spec, true).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert!(sim.ledger.part == other.ledger.part, "{what}: other rounds");
            assert_eq!(sim.ledger.phases, other.ledger.phases, "{what}");
        };
        match workers {
            // A process is started for each worker.
            Workers::Count(3 | 5) => each_transport(same_rounds),
            _ => [TestTransport::Channel(2), TestTransport::Sim(99)].into_iter().for_each(same_rounds),
        }
    }
}

#[test]
fn machines_count_the_same_in_space() {
    let points = space(Kind::Uniform, 1200, 6);
    for choice in [0, 4] {
        over_machines(&points, choice);
    }
}

#[test]
fn machines_count_the_same_in_the_plane() {
    let points = plane(Kind::GradedPoint, 1500, 6);
    for choice in [1, 2, 3] {
        over_machines(&points, choice);
    }
}

#[test]
fn other_inputs_have_other_counts() {
    let spec = threaded(Workers::Count(3), 2, LEAF);
    let count = |seed: u64, spec: &Spec| {
        let ledger = counted(&space(Kind::Uniform, 3000, seed), spec).ledger;
        (ledger.totals.paper, ledger.part.edge_hash, ledger.part.nodes)
    };
    let reference = count(1, &spec);
    assert_ne!(reference.0, count(2, &spec).0, "another set");
    let seeded = count(1, &spec.clone().with(|c| c.machine.seed = 2));
    assert_ne!(reference.0, seeded.0, "another seed");
    assert_ne!(reference.2, seeded.2, "another seed's tree");
    let leafy = count(1, &spec.with(|c| c.tree.leaf = Some(120)));
    assert_ne!(reference.0, leafy.0, "another leaf");
    assert_eq!(reference.1, leafy.1, "the graph depends on the set alone");
    assert_eq!(reference.1, seeded.1, "the graph depends on the set alone");
}

fn depth_adds_up<P: Point>(points: &[P]) {
    for choice in combinations(false) {
        let ledger = counted(points, &with_graph(&threaded(Workers::Count(2), 2, LEAF), choice)).ledger;
        let path: u64 = ledger.critical_path.iter().map(|step| step.depth).sum();
        assert_eq!(path, ledger.totals.paper.depth, "{choice:?}");
        let phases: u64 = ledger.phases.iter().map(|p| p.critical_depth).sum();
        assert_eq!(phases, ledger.totals.paper.depth, "{choice:?}: by phases");
        for phase in &ledger.phases {
            let on_path = ledger.critical_path.iter().filter(|step| step.phase == phase.phase);
            assert_eq!(phase.critical_depth, on_path.map(|step| step.depth).sum::<u64>(), "{phase:?}");
            assert!(
                phase.critical_depth == 0 || phase.phase.group() == Group::Paper,
                "{phase:?} on the paper's path"
            );
            assert!(phase.depth <= phase.depth_log_scan && phase.critical_depth <= phase.depth, "{phase:?}");
        }
        let paper = ledger.phases.iter().filter(|p| p.phase.group() == Group::Paper);
        assert_eq!(paper.map(|p| p.work).sum::<u64>(), ledger.totals.paper.work, "{choice:?}");
        assert!(
            ledger.totals.paper.brent >= ledger.totals.paper.depth,
            "{choice:?}: {:?}",
            ledger.totals.paper
        );
        assert!(
            ledger.totals.paper.brent <= ledger.totals.paper.work,
            "{choice:?}: {:?}",
            ledger.totals.paper
        );
    }
}

#[test]
fn depths_on_the_critical_path_add_up() {
    depth_adds_up(&space(Kind::Uniform, 2000, 7));
    depth_adds_up(&plane(Kind::Clusters, 3000, 7));
}

/// Bounds on the bytes to the coordinator and from it. The counts of the sampled stars come from each worker; everything
/// else goes through trees. Messages to all ranks go to at most 32 ranks.
const BYTES_OF_A_RUN: u64 = 1 << 15;
const BYTES_PER_WORKER: u64 = 256;

/// Bytes to the coordinator and from it, over all phases.
fn coordinator_bytes(run: &Outcome) -> [u64; 2] {
    let sum = |is_its: fn(&LinkKey) -> bool| {
        let links = run.ledger.part.links.iter().filter(|(link, _)| is_its(link));
        links.map(|(_, traffic)| traffic.bytes).sum()
    };
    [sum(|link| link.to == COORDINATOR), sum(|link| link.from == COORDINATOR)]
}

/// Neither points nor results pass through the coordinator.
#[test]
fn the_bytes_of_the_coordinator_do_not_grow_with_the_points() {
    for workers in [1, 8, 64, 300] {
        let bytes = [1000, 8_000].map(|n| {
            let (points, spec) = (space(Kind::Uniform, n, 8), simulated(Workers::Count(workers), 4, LEAF));
            let runs = [simulate(&points, &spec), triangulate(&points, &spec)];
            runs.map(|run| coordinator_bytes(&run.unwrap()))
        });
        println!("{workers} workers: {bytes:?}");
        let bound = BYTES_OF_A_RUN + BYTES_PER_WORKER * u64::from(workers);
        for (few, many) in bytes[0].iter().flatten().zip(bytes[1].iter().flatten()) {
            assert!(*many <= bound && *many as f64 <= 1.05 * *few as f64 + 1000.0, "{few}, {many}");
        }
    }
}

/// The totals go up and down the tree of all ranks. Before them, `triangulate` pairs the facets between workers.
#[test]
fn totals_take_two_rounds_for_each_level_of_ranks() {
    let points = plane(Kind::Uniform, 600, 8);
    for (workers, height) in [(1, 1), (8, 1), (40, 2)] {
        let spec = simulated(Workers::Count(workers), 4, LEAF);
        let runs = [simulate(&points, &spec), triangulate(&points, &spec)].map(Result::unwrap);
        let rounds = runs.map(|run| {
            let collect = run.ledger.phases.iter().find(|phase| phase.phase == Phase::Collect);
            collect.map_or(0, |phase| phase.rounds)
        });
        let facets = if workers > 1 { 2 } else { 0 };
        assert_eq!(rounds, [2 * height, 2 * height + facets], "{workers} workers");
    }
}

fn splits_are_balanced<P: Point>(points: &[P], what: &str) {
    let run = counted(points, &threaded(Workers::Count(2), 2, LEAF));
    let d = P::DIM as f64;
    let limit = (d + 1.0) / (d + 2.0) + 0.05;
    let nodes = &run.ledger.part.nodes;
    let mut largest = 0.0f64;
    for facts in nodes.values().filter(|facts| !facts.is_leaf()) {
        let inside = facts.inside.max(facts.population - facts.inside);
        largest = largest.max(inside as f64 / facts.population as f64);
    }
    println!("{what} {}D: largest split ratio {largest:.3} of {limit:.3}, {} nodes", P::DIM, nodes.len());
    assert!(largest > 0.0 && largest <= limit, "{what}: split ratio {largest}");
}

#[test]
fn separators_are_balanced() {
    use Kind::{Ball, Clusters, GradedPoint, Grid, Line, Slab, Sphere, Uniform, WellSpaced};
    for kind in [Ball, Clusters, Grid, GradedPoint, Line, Slab, Sphere, Uniform, WellSpaced] {
        splits_are_balanced(&space(kind, 3000, 9), kind.name());
        splits_are_balanced(&plane(kind, 3000, 9), kind.name());
    }
}

/// The exact tests of lattices and of rounded spheres are as many for any number of workers and any order of the points.
/// Uniform points need almost none.
fn exact_tests_of<P: Point>(points: &[P], choice: usize) -> u64 {
    let reversed: Vec<P> = points.iter().rev().copied().collect();
    let of = |points: &[P], workers| {
        let spec = with_graph(&with_workers(Workers::Count(workers), LEAF), combinations(false)[choice]);
        let ledger = counted(points, &spec).ledger;
        // A phase without charges has a row only if its ranks sent messages.
        let counted = ledger.phases.iter().filter(|p| p.phase.group().counts_work() && p.exact_tests > 0);
        let row = |p: &PhaseTotal| (p.phase, p.exact_tests);
        (ledger.totals.sum().exact_tests, counted.map(row).collect::<Vec<_>>())
    };
    let (total, phases) = of(points, 1);
    assert_eq!(total, phases.iter().map(|(_, count)| count).sum::<u64>(), "{phases:?}");
    for workers in [3, 16] {
        assert_eq!(of(points, workers), (total, phases.clone()), "{workers} workers");
    }
    assert_eq!(of(&reversed, 3), (total, phases), "another order");
    total
}

#[test]
fn exact_tests_do_not_depend_on_the_machine() {
    for kind in [Kind::Grid, Kind::Sphere] {
        assert!(exact_tests_of(&space(kind, 1000, 3), 0) > 1000, "{kind:?}");
    }
    assert!(exact_tests_of(&plane(Kind::Grid, 1000, 3), 0) > 1000);
    for uniform in
        [exact_tests_of(&space(Kind::Uniform, 1000, 3), 0), exact_tests_of(&plane(Kind::Uniform, 1000, 3), 0)]
    {
        assert!(uniform < 10, "{uniform}");
    }
}
