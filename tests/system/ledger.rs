//! The counts of the ledger and their dependence on workers, transport, input and configuration.

use crate::common::sets::{plane, space};
use crate::common::transports::{TestTransport, each_transport};
use crate::common::{assert_same_counts, combinations, simulated, threaded, with_graph, with_workers};
use septet_core::config::Workers;
use septet_core::generate::Kind;
use septet_core::{Config, Run, simulate};
use septet_geometry::point::Point;
use septet_lab::assert_counts;
use septet_protocol::ids::NodeId;

const LEAF: u64 = 60;

fn counted<P: Point>(points: &[P], config: &Config) -> Run {
    simulate(points, config).unwrap_or_else(|e| panic!("{config:?}: {e}"))
}

fn over_machines<P: Point>(points: &[P], choice: usize) {
    let choice = combinations(false)[choice];
    let reference = counted(points, &with_graph(&threaded(Workers::Count(1), 1, LEAF), choice));
    for workers in [2, 3, 5, 64, 1000].map(Workers::Count).into_iter().chain([Workers::Leaves]) {
        let config = with_graph(&with_workers(workers, LEAF), choice);
        let sim = TestTransport::Sim(4).run(points, &config, true).unwrap();
        assert_same_counts(&reference.ledger, &sim.ledger, &format!("{choice:?}, {workers:?}"));
        assert_counts!([&reference, &sim], same_counts());
        // Rounds, messages and bytes depend on the workers, but neither on transport nor on delivery.
        let same_rounds = |start: TestTransport| {
            let what = format!("{choice:?}, {workers:?}, {start:?}");
            let other = start.run(points, &config, true).unwrap_or_else(|e| panic!("{what}: {e}"));
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
    let points = space(Kind::Uniform, 2000, 6);
    for choice in [0, 4] {
        over_machines(&points, choice);
    }
}

#[test]
fn machines_count_the_same_in_the_plane() {
    let points = plane(Kind::GradedPoint, 2500, 6);
    for choice in [1, 2, 3] {
        over_machines(&points, choice);
    }
}

#[test]
fn other_inputs_have_other_counts() {
    let config = threaded(Workers::Count(3), 2, LEAF);
    let count = |seed: u64, config: &Config| {
        let ledger = counted(&space(Kind::Uniform, 3000, seed), config).ledger;
        (ledger.paper, ledger.part.edge_hash, ledger.part.nodes)
    };
    let reference = count(1, &config);
    assert_ne!(reference.0, count(2, &config).0, "another set");
    let seeded = count(1, &config.clone().with(|c| c.machine.seed = 2));
    assert_ne!(reference.0, seeded.0, "another seed");
    assert_ne!(reference.2, seeded.2, "another seed's tree");
    let leafy = count(1, &config.with(|c| c.machine.leaf = Some(120)));
    assert_ne!(reference.0, leafy.0, "another leaf");
    assert_eq!(reference.1, leafy.1, "the graph depends on the set alone");
    assert_eq!(reference.1, seeded.1, "the graph depends on the set alone");
}

fn depth_adds_up<P: Point>(points: &[P]) {
    for choice in combinations(false) {
        let ledger = counted(points, &with_graph(&threaded(Workers::Count(2), 2, LEAF), choice)).ledger;
        let path: u64 = ledger.critical_path.iter().map(|step| step.depth).sum();
        assert_eq!(path, ledger.paper.depth, "{choice:?}");
        let phases: u64 = ledger.phases.iter().map(|p| p.critical_depth).sum();
        assert_eq!(phases, ledger.paper.depth, "{choice:?}: by phases");
        for phase in &ledger.phases {
            let on_path = ledger.critical_path.iter().filter(|step| step.phase == phase.phase);
            assert_eq!(phase.critical_depth, on_path.map(|step| step.depth).sum::<u64>(), "{phase:?}");
            assert!(phase.critical_depth == 0 || phase.phase.is_paper(), "{phase:?} on the paper's path");
            assert!(phase.depth <= phase.depth_log_scan && phase.critical_depth <= phase.depth, "{phase:?}");
        }
        let paper = ledger.phases.iter().filter(|p| p.phase.is_paper());
        assert_eq!(paper.map(|p| p.work).sum::<u64>(), ledger.paper.work, "{choice:?}");
        assert!(ledger.paper.brent >= ledger.paper.depth, "{choice:?}: {:?}", ledger.paper);
        assert!(ledger.paper.brent <= ledger.paper.work, "{choice:?}: {:?}", ledger.paper);
    }
}

#[test]
fn depths_on_the_critical_path_add_up() {
    depth_adds_up(&space(Kind::Uniform, 2000, 7));
    depth_adds_up(&plane(Kind::Clusters, 3000, 7));
}

/// Bounds on the bytes to the coordinator outside loading and merging: the samples and counts of the root, and a summary
/// and a certificate from each worker. Measured: 28 bytes per sample and 320 per worker. A draw has at most 100 samples
/// by default.
const BYTES_PER_SAMPLE: u64 = 40;
const BYTES_PER_WORKER: u64 = 450;
const SAMPLES: u64 = 100;

#[test]
fn the_coordinator_receives_few_control_bytes() {
    for n in [2000, 8000] {
        let points = space(Kind::Uniform, n, 8);
        for workers in [1, 2, 8, 64, 500] {
            let run = counted(&points, &simulated(Workers::Count(workers), 4, LEAF));
            let control: u64 = run.ledger.part.rounds.values().map(|tally| tally.control).sum();
            let attempts = run.ledger.part.nodes[&NodeId::ROOT].attempts;
            println!("n {n} workers {workers}: control {control}, attempts {attempts}");
            let bound = BYTES_PER_SAMPLE * attempts * SAMPLES + BYTES_PER_WORKER * u64::from(workers);
            assert!(control <= bound, "{control} bytes above {bound}, {n} points, {workers} workers");
        }
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
