//! The partition tree of `triangulate`: every separator bisects the points. The tree does not depend on the workers or on the
//! order of the points.

use std::collections::BTreeMap;

use crate::common::sets::{Draw, plane, space};
use crate::common::{simulated, threaded};
use septet_core::generate::Kind;
use septet_core::spec::{Partition, Spec, Workers};
use septet_core::{simulate, triangulate};
use septet_geometry::point::Point;
use septet_geometry::separator::bisection_samples;
use septet_protocol::ids::NodeId;

/// The facts of every split subproblem: its points, those inside, attempts, and the hash of the separator.
fn splits<P: Point>(points: &[P], spec: &Spec) -> BTreeMap<NodeId, [u64; 4]> {
    let nodes = triangulate(points, spec).unwrap().ledger.part.nodes;
    let inner = nodes.into_iter().filter(|(_, facts)| !facts.is_leaf());
    inner.map(|(node, f)| (node, [f.population, f.inside, f.attempts, f.separator])).collect()
}

fn trees_are_equal<P: Point>(points: &[P]) {
    let all = splits(points, &threaded(Workers::Count(64), 2, 40));
    assert!(all.len() >= 60, "{} of 63", all.len());
    let mut order: Vec<P> = points.to_vec();
    Draw::new(7).shuffle(&mut order);
    for workers in [2, 3, 8, 64] {
        for (points, spec) in [
            (points, threaded(Workers::Count(workers), 2, 40)),
            (&order, threaded(Workers::Count(workers), 1, 40)),
            (&order, simulated(Workers::Count(workers), 5, 40)),
        ] {
            let some = splits(points, &spec);
            assert!(some.len() + 1 >= workers.min(60) as usize, "{} of {workers}", some.len());
            for (node, facts) in some {
                assert_eq!(all.get(&node), Some(&facts), "{workers} workers, {node:?}");
            }
        }
    }
}

#[test]
fn the_tree_does_not_depend_on_workers_or_order() {
    trees_are_equal(&space(Kind::Uniform, 20_000, 4));
    trees_are_equal(&space(Kind::Clusters, 20_000, 4));
    trees_are_equal(&plane(Kind::Uniform, 20_000, 4));
}

/// Separators of `triangulate` bisect the points to within four standard deviations, both spheres and planes. Separators of
/// `simulate` do not.
fn check_bisection<P: Point>(points: &[P]) {
    let excess = |population: u64, inside: u64| {
        let larger = inside.max(population - inside) as f64 / population as f64;
        (larger - 0.5) * 2.0 * (bisection_samples(population) as f64).sqrt()
    };
    for partition in [Partition::Sphere, Partition::Kd, Partition::Hilbert] {
        let spec = threaded(Workers::Count(8), 2, 40).with(|c| c.tree.partition = partition);
        let split = splits(points, &spec);
        assert_eq!(split.len(), 7);
        for (node, [population, inside, ..]) in split {
            assert!(excess(population, inside) < 4.0, "{node:?}: {inside} of {population}");
        }
    }
    let counted = simulate(points, &threaded(Workers::Count(8), 2, 2000)).unwrap().ledger.part.nodes;
    let inner = counted.values().filter(|facts| !facts.is_leaf());
    assert!(inner.map(|f| excess(f.population, f.inside)).fold(0.0, f64::max) > 4.0);
}

#[test]
fn separators_bisect_even_sets() {
    check_bisection(&space(Kind::Uniform, 50_000, 4));
    check_bisection(&plane(Kind::Uniform, 50_000, 4));
}

/// With a worker for each leaf, every worker has one leaf, and no leaf has more points than the limit.
fn check_leaves<P: Point>(points: &[P]) {
    let leaf = 300;
    let run = triangulate(points, &threaded(Workers::Leaves, 2, leaf)).unwrap();
    let leaves: Vec<u64> =
        run.ledger.part.nodes.values().filter(|f| f.is_leaf()).map(|f| f.population).collect();
    assert_eq!(leaves.len(), run.settled.workers as usize);
    assert!(leaves.iter().all(|&population| population <= leaf && population > 0), "{leaves:?}");
    assert_eq!(leaves.iter().sum::<u64>(), points.len() as u64);
}

#[test]
fn every_worker_has_one_leaf() {
    check_leaves(&space(Kind::Uniform, 10_000, 4));
    check_leaves(&space(Kind::Clusters, 10_000, 4));
    check_leaves(&plane(Kind::Uniform, 10_000, 4));
}
