//! What a machine does when something in it goes wrong.

use std::collections::BTreeSet;

use crate::common::sets::{plane, space};
use crate::common::{combinations, simulated, threaded, with_graph};
use septet_core::config::{Alpha, Fault, Graph, GraphKind, Neighbours, SeparatorSets, Workers};
use septet_core::generate::Kind;
use septet_core::{Error, simulate, triangulate};
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::transport::TransportError;

const LEAF: u64 = 60;

fn refuse(first: u64, last: u64) -> Fault {
    Fault::RefuseSplit { first: NodeId(first), last: NodeId(last) }
}

/// Groups that cannot split their node pass on what they are sent for it: cells and graph stay the same.
fn relayed<P: Point>(points: &[P]) {
    // The root; both its children; one of them; one or all of the nodes below, where there is a group.
    let refused = [(2, 1, 1), (5, 1, 1), (5, 2, 3), (5, 3, 3), (8, 2, 2), (8, 2, 3), (8, 5, 5), (8, 4, 7)];
    for choice in combinations(false) {
        let whole = with_graph(&simulated(Workers::Count(1), 0, LEAF), choice).with(|c| c.keep.graph = true);
        let reference = simulate(points, &whole).unwrap();
        for (workers, first, last) in refused {
            let config = with_graph(&simulated(Workers::Count(workers), 3, LEAF), choice);
            let config = config.with(|c| {
                c.keep.graph = true;
                c.planted.fault = Some(refuse(first, last));
            });
            let what = format!("{choice:?}, {workers} workers, {first} to {last} refused");
            let counted = simulate(points, &config).unwrap_or_else(|e| panic!("{what}: {e}"));
            let facts = &counted.ledger.part.nodes[&NodeId(first)];
            assert!(facts.is_leaf() && facts.population > LEAF, "{what}: it was split");
            assert!(counted.cells() == reference.cells(), "{what}: other cells");
            assert!(counted.graph == reference.graph, "{what}: another graph");
            let run = triangulate(points, &config).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert!(run.cells() == reference.cells(), "{what}: other cells, triangulated");
        }
    }
}

#[test]
fn a_refused_split_is_relayed_in_space() {
    relayed(&space(Kind::Uniform, 1500, 5));
}

#[test]
fn a_refused_split_is_relayed_in_the_plane() {
    relayed(&plane(Kind::Clusters, 1500, 5));
}

#[test]
fn a_spoilt_star_has_no_certificate() {
    let points = space(Kind::Uniform, 800, 6);
    for (workers, rank) in [(1, 1), (3, 2)] {
        for counted in [false, true] {
            let config = threaded(Workers::Count(workers), 2, LEAF);
            let config = config.with(|c| c.planted.fault = Some(Fault::SpoilStar { rank }));
            let result = if counted { simulate(&points, &config) } else { triangulate(&points, &config) };
            let Err(Error::NotCertified { refutation, run }) = result else { panic!("{result:?}") };
            assert!(refutation.disagreements > 0 && refutation.points == 800, "{refutation}");
            assert_eq!(run.refutation, Some(refutation));
            assert!(run.cell_count() == 0);
            assert!(
                run.ledger.phases.iter().any(|p| p.phase == Phase::Hulls || p.phase == Phase::Certificate)
            );
        }
    }
}

#[test]
fn a_worker_that_ends_is_named() {
    let points = plane(Kind::Uniform, 800, 6);
    for rank in [1, 3] {
        for phase in [Phase::Partition, Phase::Neighbours, Phase::Graph, Phase::Repair, Phase::Collect] {
            for config in [simulated(Workers::Count(3), 1, LEAF), threaded(Workers::Count(3), 2, LEAF)] {
                // A density graph, for which there are balls to the nearest neighbours.
                let alpha = Alpha::Value(2.5);
                let config = config.with(|c| {
                    c.planted.fault = Some(Fault::DieAt { rank, phase });
                    c.graph = Graph::Density { alpha };
                });
                match simulate(&points, &config) {
                    Err(Error::Machine(TransportError::WorkerFailed { rank: named, .. })) => {
                        assert_eq!(named, rank);
                    }
                    other => panic!("{rank} {phase:?}: {:?}", other.map(|run| run.cell_count())),
                }
            }
        }
    }
}

/// Stars that may not say all they have to are gathered: the same cells, the same region, and the same work and depth for
/// any number of workers. Returns the numbers of points gathered.
fn capped<P: Point>(points: &[P], nearest: u32, caps: std::ops::Range<u32>) -> BTreeSet<u64> {
    let knn = (GraphKind::Knn, SeparatorSets::Ghost, Alpha::Auto, Neighbours::Count(nearest));
    let reference = simulate(points, &with_graph(&simulated(Workers::Count(1), 0, LEAF), knn)).unwrap();
    assert_eq!(reference.fallback, None);
    let mut sizes = BTreeSet::new();
    for cap in caps {
        let mut first = None;
        for workers in [1, 2, 5, 64] {
            let config = with_graph(&simulated(Workers::Count(workers), 3, LEAF), knn);
            let config = config.with(|c| c.planted.exchange_cap = Some(cap));
            let run = simulate(points, &config).unwrap_or_else(|e| panic!("cap {cap}, {workers}: {e}"));
            assert!(run.cells() == reference.cells(), "cap {cap}, {workers} workers: other cells");
            sizes.insert(run.fallback.as_ref().unwrap_or_else(|| panic!("cap {cap}: nothing gathered")).1);
            let found = (run.fallback, run.ledger.repair.work, run.ledger.repair.depth);
            assert_eq!(first.get_or_insert_with(|| found.clone()), &found, "cap {cap}, {workers} workers");
        }
    }
    sizes
}

#[test]
fn a_gathering_ends_in_the_same_cells_in_space() {
    capped(&space(Kind::Uniform, 900, 8), 3, 0..4);
    capped(&space(Kind::Clusters, 700, 8), 3, 0..4);
    let few = capped(&space(Kind::Uniform, 900, 8), 36, 1..3);
    assert!(few.iter().all(|&n| n < 900), "{few:?}");
}

#[test]
fn a_gathering_ends_in_the_same_cells_in_the_plane() {
    capped(&plane(Kind::Uniform, 900, 8), 3, 0..4);
    let few = capped(&plane(Kind::Uniform, 900, 8), 14, 2..3);
    assert!(few.iter().all(|&n| n < 900), "{few:?}");
}
