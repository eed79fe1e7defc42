//! septet-common: code that the test programs share.

pub mod data;
pub mod observed;

pub mod samples;

pub mod sets;

pub mod transports;

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use septet_core::result::periodic::PeriodicCells;
use septet_core::spec::{
    Alpha, Graph, GraphKind, Neighbours, Periodic, SeparatorSets, Task, Transport, Workers,
};
use septet_core::{Outcome, Spec, simulate, triangulate};
use septet_geometry::point::Point;
use septet_protocol::ledger::Ledger;
use septet_verify::{PeriodicBox, Report, Sites, Triangulation, VerifyOptions, verify};
use transports::TestTransport;

/// Returns the configuration of `workers` in the simulator.
pub fn simulated(workers: Workers, delivery_seed: u64, leaf: u64) -> Spec {
    base().with(|c| {
        c.machine.workers = workers;
        c.tree.leaf = Some(leaf);
        c.machine.transport = Transport::Sim { delivery_seed };
    })
}

/// Returns the default configuration, independent of the number of cores.
pub fn base() -> Spec {
    Spec::default().with(|c| {
        c.machine.workers = Workers::Count(2);
        c.machine.threads = Some(2);
        c.machine.transport = Transport::Channel;
    })
}

/// Returns the supergraphs with the rules for separator sets that are valid for them. Their parameters are
/// `auto` or fixed.
pub fn combinations(auto: bool) -> Vec<(GraphKind, SeparatorSets, Alpha, Neighbours)> {
    use SeparatorSets::{Both, Ghost, Own, Smaller};
    let alpha = if auto { Alpha::Auto } else { Alpha::Value(2.5) };
    let k = if auto { Neighbours::Auto } else { Neighbours::Count(20) };
    let mut all = Vec::new();
    for sets in [Ghost, Both, Own, Smaller] {
        all.push((GraphKind::Density, sets, alpha, Neighbours::Auto));
    }
    for sets in [Ghost, Both, Own] {
        all.push((GraphKind::Overlap, sets, alpha, Neighbours::Auto));
        all.push((GraphKind::Knn, sets, Alpha::Auto, k));
    }
    all
}

/// Returns the configuration with another supergraph.
pub fn with_graph(spec: &Spec, choice: (GraphKind, SeparatorSets, Alpha, Neighbours)) -> Spec {
    let (graph, sets, alpha, k) = choice;
    spec.clone().with(|c| {
        c.recursion.graph = Graph::new(graph, alpha, k).expect("a valid combination");
        c.recursion.sets = sets;
    })
}

/// Panics unless all counts that must not depend on workers or transport are equal.
pub fn assert_same_counts(a: &Ledger, b: &Ledger, what: &str) {
    for (key, charge) in &a.part.charges {
        assert_eq!(Some(charge), b.part.charges.get(key), "{what}: charge {key:?}");
    }
    assert_eq!(a.part.charges.len(), b.part.charges.len(), "{what}: charges");
    for (key, facts) in &a.part.nodes {
        assert_eq!(Some(facts), b.part.nodes.get(key), "{what}: facts {key:?}");
    }
    assert_eq!(a.part.nodes.len(), b.part.nodes.len(), "{what}: nodes");
    assert_eq!(a.part.edge_hash, b.part.edge_hash, "{what}: graph");
    assert_eq!(a.totals, b.totals, "{what}: totals");
    assert_eq!(a.critical_path, b.critical_path, "{what}: critical path");
}

/// Returns the coordinates of points, one after the other.
pub fn coordinates<P: Point>(points: &[P]) -> Vec<f64> {
    points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i)).collect::<Vec<_>>()).collect()
}

/// Panics unless the independent verifier finds that the cells are septet's canonical triangulation, and the hidden points
/// those that are hidden.
pub fn assert_verified<P: Point>(points: &[P], run: &Outcome) {
    let report = verified(points, run, None);
    assert_eq!(report.hull_facets, run.hull_facets);
    assert_eq!(report.dimension_of_points, run.dimension as i32);
}

/// As [`assert_verified`], in a periodic box. Returns the report of the verifier.
pub fn verified<P: Point>(points: &[P], run: &Outcome, periodic: Option<&Periodic>) -> Report {
    let coordinates = coordinates(points);
    let weights: Vec<f64> = points.iter().map(Point::weight).collect();
    let options = VerifyOptions { perturbed: true, any_order: false, ..VerifyOptions::default() };
    let mesh = Triangulation { dimension: run.space, coordinates: &coordinates, cells: run.cells() };
    let offsets = run.kept.periodic.as_ref().map(PeriodicCells::offsets);
    let periodic = periodic.zip(offsets.as_deref());
    let periodic = periodic.map(|(periodic, offsets)| PeriodicBox { lengths: &periodic.lengths, offsets });
    let sites = Sites { mesh, weights: P::IS_WEIGHTED.then_some(&weights), periodic };
    let report = verify(sites, &options, &mut |_, _, _| {});
    assert!(report.passed(), "{report:#?}");
    assert_eq!(report.hidden, run.points.hidden);
    report
}

/// Returns the task of `simulate` (`counted`) or `triangulate`.
pub fn task(counted: bool) -> Task {
    if counted { Task::Simulate } else { Task::Triangulate }
}

/// Triangulates and verifies. The ghost layer and the interface exchange must complete all stars.
pub fn check<P: Point>(points: &[P], spec: &Spec) -> Outcome {
    let run = triangulate(points, spec).unwrap_or_else(|e| panic!("{spec:?}: {e}"));
    assert_verified(points, &run);
    assert_eq!(run.exchange_rounds, 0, "{spec:?}");
    run
}

/// Simulates and verifies.
pub fn check_counted<P: Point>(points: &[P], spec: &Spec) -> Outcome {
    let run = simulate(points, spec).unwrap_or_else(|e| panic!("{spec:?}: {e}"));
    assert_verified(points, &run);
    run
}

/// Returns the configuration of `workers` on `threads` threads.
pub fn threaded(workers: Workers, threads: usize, leaf: u64) -> Spec {
    base().with(|c| {
        c.machine.workers = workers;
        c.machine.threads = Some(threads);
        c.tree.leaf = Some(leaf);
        c.machine.transport = Transport::Channel;
    })
}

/// Runs `simulate` (`counted`) or `triangulate` over a transport and verifies the result, like [`check`] and
/// [`check_counted`].
pub fn check_over<P: Point>(start: TestTransport, points: &[P], spec: &Spec, counted: bool) -> Outcome {
    let run = start.run(points, spec, counted).unwrap_or_else(|e| panic!("{start:?}, {spec:?}: {e}"));
    assert_verified(points, &run);
    assert!(counted || run.exchange_rounds == 0, "{start:?}, {spec:?}: stars were incomplete");
    run
}

/// Returns the configuration with this number of workers and points per leaf.
pub fn with_workers(workers: Workers, leaf: u64) -> Spec {
    base().with(|c| {
        c.machine.workers = workers;
        c.tree.leaf = Some(leaf);
    })
}

/// Returns the number of levels below the root.
pub fn levels(ledger: &Ledger) -> u32 {
    ledger.part.nodes.keys().map(|node| node.level()).max().unwrap_or(0)
}

/// Runs `f`, and panics if it takes longer than this number of seconds.
pub fn within<T: Send + 'static>(seconds: u64, what: &str, f: impl FnOnce() -> T + Send + 'static) -> T {
    let (done, result) = channel();
    let thread = std::thread::spawn(move || {
        let _ = done.send(f());
    });
    match result.recv_timeout(Duration::from_secs(seconds)) {
        Ok(value) => value,
        Err(RecvTimeoutError::Timeout) => panic!("{what}: no end after {seconds} seconds"),
        Err(RecvTimeoutError::Disconnected) => match thread.join() {
            Ok(()) => unreachable!("it sends before it ends"),
            Err(panic) => {
                eprintln!("in {what}:");
                std::panic::resume_unwind(panic)
            }
        },
    }
}
