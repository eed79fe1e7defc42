//! One list of runs over the transports of one process: threads with channels, and the simulator. The tests of the
//! command line (`processes`) compare several processes with one.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use septet_core::generate::Kind;
use septet_core::spec::Workers;
use septet_core::{Error, Outcome, Spec};
use septet_geometry::point::Point;

use crate::common::sets::{plane, space};
use crate::common::transports::each_transport;
use crate::common::{assert_same_counts, combinations, with_graph, with_workers};

/// Everything in a result and its ledger that a transport could change.
fn assert_same(expected: &Outcome, found: &Outcome, what: &str) {
    assert!(expected.cells() == found.cells(), "{what}: other cells");
    assert!(expected.kept.graph == found.kept.graph, "{what}: another graph");
    assert_eq!(expected.owner(), found.owner(), "{what}");
    assert_eq!(expected.owning_leaf(), found.owning_leaf(), "{what}");
    assert_same_counts(&expected.ledger, &found.ledger, what);
    assert_eq!(expected.ledger.phases, found.ledger.phases, "{what}");
    assert!(expected.ledger.part == found.ledger.part, "{what}: other rounds");
}

fn over_transports<P: Point>(points: &[P], spec: &Spec) {
    for counted in [false, true] {
        let mut reference: Option<Outcome> = None;
        each_transport(|start| {
            let what = format!("{start:?}, counted {counted}, {spec:?}");
            let run = start.run(points, spec, counted).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_same(reference.get_or_insert_with(|| run.clone()), &run, &what);
        });
    }
}

#[test]
fn results_and_ledgers_of_uniform_sets_are_equal() {
    let points = space(Kind::Uniform, 3000, 5);
    for (workers, graph) in [(1, 0), (3, 1), (8, 2), (5, 4), (3, 6)] {
        let spec = with_graph(&with_workers(Workers::Count(workers), 60), combinations(true)[graph]);
        let spec = spec.with(|c| {
            c.keep.graph = true;
            c.keep.owner = true;
        });
        over_transports(&points, &spec);
    }
}

#[test]
fn results_and_ledgers_in_the_plane_are_equal() {
    over_transports(&plane(Kind::Clusters, 3000, 5), &with_workers(Workers::Count(4), 60));
    over_transports(&plane(Kind::Grid, 900, 5), &with_workers(Workers::Leaves, 60));
}

/// A rank that fails or panics ends a run with the same error over every transport.
#[test]
fn failures_of_ranks_are_equal() {
    let points = plane(Kind::Uniform, 200, 5);
    for fault in ["die:2:hulls", "panic:2:partition", "panic:1:collect"] {
        let spec = with_workers(Workers::Count(3), 20);
        let spec = spec.with(|c| c.planted.fault = Some(fault.parse().unwrap()));
        let mut reference: Option<String> = None;
        each_transport(|start| {
            let found = format!("{:?}", start.run(&points, &spec, true).map(drop).unwrap_err());
            assert_eq!(reference.get_or_insert_with(|| found.clone()), &found, "{fault}, {start:?}");
        });
    }
}

#[test]
fn an_interrupt_ends_a_run_over_every_transport() {
    let points = plane(Kind::Uniform, 200, 5);
    let spec = with_workers(Workers::Count(2), 60)
        .with(|c| c.control.cancel = Some(Arc::new(AtomicBool::new(true))));
    each_transport(|start| {
        let run = start.run(&points, &spec, true);
        assert!(matches!(run, Err(Error::Interrupted)), "{start:?}");
    });
}
