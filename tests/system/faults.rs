//! Planted faults: refused separators, spoilt stars, workers that end, limits on the exchange.

use std::collections::BTreeSet;

use crate::common::sets::{plane, space};
use crate::common::transports::{TestTransport, each_transport};
use crate::common::{combinations, simulated, with_graph, with_workers};
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Fault, Graph, GraphKind, Neighbours, SeparatorSets, Workers};
use septet_core::{Error, simulate};
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::transport::TransportError;

const LEAF: u64 = 60;

fn refuse(first: u64, last: u64) -> Fault {
    Fault::RefuseSplit { first: NodeId(first), last: NodeId(last) }
}

/// Groups that cannot split their node forward the messages for it. Cells and graph stay the same.
fn relayed<P: Point>(points: &[P]) {
    // The root; both its children; one of them; one or all of the nodes below, where there is a group.
    let refused = [(2, 1, 1), (5, 1, 1), (5, 2, 3), (5, 3, 3), (8, 2, 2), (8, 2, 3), (8, 5, 5), (8, 4, 7)];
    for choice in combinations(false) {
        let whole = with_graph(&simulated(Workers::Count(1), 0, LEAF), choice).with(|c| c.keep.graph = true);
        let reference = simulate(points, &whole).unwrap();
        for (workers, first, last) in refused {
            let spec = with_graph(&with_workers(Workers::Count(workers), LEAF), choice);
            let spec = spec.with(|c| {
                c.keep.graph = true;
                c.planted.fault = Some(refuse(first, last));
            });
            let same = |start: TestTransport| {
                let what = format!("{start:?}, {choice:?}, {workers} workers, {first} to {last} refused");
                let counted = start.run(points, &spec, true).unwrap_or_else(|e| panic!("{what}: {e}"));
                let facts = &counted.ledger.part.nodes[&NodeId(first)];
                assert!(facts.is_leaf() && facts.population > LEAF, "{what}: it was split");
                assert!(counted.cells() == reference.cells(), "{what}: other cells");
                assert!(counted.kept.graph == reference.kept.graph, "{what}: another graph");
                let run = start.run(points, &spec, false).unwrap_or_else(|e| panic!("{what}: {e}"));
                assert!(run.cells() == reference.cells(), "{what}: other cells, triangulated");
            };
            match (choice.0, first, last) {
                (GraphKind::Knn, 2, 3) => each_transport(same),
                _ => same(TestTransport::Sim(3)),
            }
        }
    }
}

#[test]
fn groups_relay_the_messages_of_an_unsplit_node_in_space() {
    relayed(&space(Kind::Uniform, 900, 5));
}

#[test]
fn groups_relay_the_messages_of_an_unsplit_node_in_the_plane() {
    relayed(&plane(Kind::Clusters, 900, 5));
}

#[test]
fn a_spoilt_star_has_no_certificate() {
    let points = space(Kind::Uniform, 800, 6);
    for (workers, rank) in [(1, 1), (3, 2)] {
        for counted in [false, true] {
            let spec = with_workers(Workers::Count(workers), LEAF);
            let spec = spec.with(|c| c.planted.fault = Some(Fault::SpoilStar { rank }));
            each_transport(|start| {
                let result = start.run(&points, &spec, counted);
                let Err(Error::NotCertified { refutation, run }) = result else {
                    panic!("{start:?}: {result:?}")
                };
                assert!(refutation.disagreements > 0 && refutation.points == 800, "{start:?}: {refutation}");
                assert_eq!(run.refutation, Some(refutation), "{start:?}");
                assert!(run.cell_count() == 0, "{start:?}");
                let mut phases = run.ledger.phases.iter();
                assert!(
                    phases.any(|p| p.phase == Phase::Hulls || p.phase == Phase::Certificate),
                    "{start:?}"
                );
            });
        }
    }
}

#[test]
fn a_worker_that_ends_is_named() {
    let points = plane(Kind::Uniform, 800, 6);
    for rank in [1, 3] {
        for phase in [Phase::Partition, Phase::Neighbours, Phase::Graph, Phase::Repair, Phase::Collect] {
            // Density graphs need the neighbour balls of the phase `neighbours`.
            let alpha = Alpha::Value(2.5);
            let spec = with_workers(Workers::Count(3), LEAF).with(|c| {
                c.planted.fault = Some(Fault::DieAt { rank, phase });
                c.recursion.graph = Graph::Density { alpha };
            });
            each_transport(|start| match start.run(&points, &spec, true) {
                Err(Error::Machine(TransportError::WorkerFailed { rank: named, .. })) => {
                    assert_eq!(named, rank, "{start:?}, {phase:?}");
                }
                other => panic!("{start:?}, {rank} {phase:?}: {:?}", other.map(|run| run.cell_count())),
            });
        }
    }
}

/// A limit on the messages of the exchange makes the coordinator gather the unresolved stars. Cells, gathered region, work
/// and depth are the same for any number of workers and any transport. Returns the numbers of points gathered.
fn capped<P: Point>(points: &[P], nearest: u32, caps: std::ops::Range<u32>) -> BTreeSet<u64> {
    let knn = (GraphKind::Knn, SeparatorSets::Ghost, Alpha::Auto, Neighbours::Count(nearest));
    let reference = simulate(points, &with_graph(&simulated(Workers::Count(1), 0, LEAF), knn)).unwrap();
    assert_eq!(reference.fallback, None);
    let mut sizes = BTreeSet::new();
    for cap in caps {
        let mut first = None;
        for workers in [1, 2, 5, 64] {
            let spec = with_graph(&with_workers(Workers::Count(workers), LEAF), knn);
            let spec = spec.with(|c| c.planted.exchange_cap = Some(cap));
            let mut same = |start: TestTransport| {
                let what = format!("cap {cap}, {workers} workers, {start:?}");
                let run = start.run(points, &spec, true).unwrap_or_else(|e| panic!("{what}: {e}"));
                assert!(run.cells() == reference.cells(), "{what}: other cells");
                sizes.insert(run.fallback.as_ref().unwrap_or_else(|| panic!("{what}: nothing gathered")).1);
                let found =
                    (run.facts.fallback, run.ledger.totals.repair.work, run.ledger.totals.repair.depth);
                assert_eq!(first.get_or_insert_with(|| found.clone()), &found, "{what}");
            };
            if workers == 5 { each_transport(same) } else { same(TestTransport::Sim(3)) }
        }
    }
    sizes
}

#[test]
fn gathered_stars_give_the_same_cells_in_space() {
    capped(&space(Kind::Uniform, 900, 8), 3, 0..4);
    capped(&space(Kind::Clusters, 700, 8), 3, 0..4);
    let few = capped(&space(Kind::Uniform, 900, 8), 36, 1..3);
    assert!(few.iter().all(|&n| n < 900), "{few:?}");
}

#[test]
fn gathered_stars_give_the_same_cells_in_the_plane() {
    capped(&plane(Kind::Uniform, 900, 8), 3, 0..4);
    let few = capped(&plane(Kind::Uniform, 900, 8), 14, 2..3);
    assert!(few.iter().all(|&n| n < 900), "{few:?}");
}
