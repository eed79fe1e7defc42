//! Results of `triangulate` and `simulate` are the same bytes for any number of workers and threads, any transport, order
//! of input, supergraph and separator sets.

use crate::common::sets::{Draw, plane, space};
use crate::common::transports::{TestTransport, each_transport};
use crate::common::{
    assert_same_counts, assert_verified, base, check_counted, combinations, levels, simulated, threaded,
    with_graph, with_workers,
};
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, GraphKind, Neighbours, Workers};
use septet_core::{Outcome, Spec, simulate, triangulate};
use septet_geometry::point::Point;

/// Runs over every transport; a process is started for each worker.
const FEW_WORKERS: [u32; 3] = [1, 5, 8];

/// Runs in one process.
const OTHER_WORKERS: [Workers; 4] =
    [Workers::Count(2), Workers::Count(64), Workers::Count(300), Workers::Leaves];

const LEAF: u64 = 30;

/// The verified triangulation of a set that splits at least six times.
fn reference<P: Point>(points: &[P]) -> Outcome {
    let run = check_counted(points, &threaded(Workers::Count(2), 2, LEAF));
    assert!(levels(&run.ledger) >= 6, "{} levels", levels(&run.ledger));
    run
}

fn assert_equal<P: Point>(start: TestTransport, points: &[P], spec: &Spec, reference: &Outcome) {
    for counted in [false, true] {
        let what = format!("{start:?}, {spec:?}, counted {counted}");
        let run = start.run(points, spec, counted).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert!(run.cells() == reference.cells(), "{what}: other cells");
        assert_eq!(run.hull_facets, reference.hull_facets, "{what}");
        assert_eq!(run.points, reference.points, "{what}");
        assert_eq!(run.fallback, None, "{what}");
    }
}

fn over_machines<P: Point>(points: &[P]) {
    let reference = reference(points);
    for workers in FEW_WORKERS {
        let spec = with_workers(Workers::Count(workers), LEAF);
        each_transport(|start| assert_equal(start, points, &spec, &reference));
    }
    for workers in OTHER_WORKERS {
        for start in [TestTransport::Channel(2), TestTransport::Sim(0)] {
            assert_equal(start, points, &with_workers(workers, LEAF), &reference);
        }
    }
    for start in [TestTransport::Channel(1), TestTransport::Sim(1), TestTransport::Sim(77)] {
        assert_equal(start, points, &with_workers(Workers::Count(64), LEAF), &reference);
    }
}

fn over_graphs<P: Point>(points: &[P]) {
    let reference = reference(points);
    let mut choices = combinations(true);
    choices.extend(combinations(false));
    let (_, both, ..) = choices[1];
    choices.push((GraphKind::Density, both, Alpha::Value(4.0), Neighbours::Auto));
    choices.push((GraphKind::Density, both, Alpha::Value(1.0), Neighbours::Auto));
    choices.push((GraphKind::Overlap, both, Alpha::Value(2.0), Neighbours::Count(4)));
    choices.push((GraphKind::Knn, both, Alpha::Auto, Neighbours::Log(4.5)));
    choices.push((GraphKind::Knn, both, Alpha::Auto, Neighbours::Count(1)));
    for choice in choices {
        for (start, workers) in [(TestTransport::Sim(5), 3), (TestTransport::Channel(2), 64)] {
            let spec = with_graph(&with_workers(Workers::Count(workers), LEAF), choice);
            assert_equal(start, points, &spec, &reference);
        }
    }
}

/// Other seeds and leaves change the tree, not the triangulation.
fn over_trees<P: Point>(points: &[P]) {
    let reference = reference(points);
    for seed in [0, 2, u64::MAX] {
        for leaf in [Some(25), None] {
            let spec = base().with(|c| {
                c.machine.seed = seed;
                c.tree.leaf = leaf;
                c.machine.workers = Workers::Count(5);
            });
            assert_equal(TestTransport::Channel(2), points, &spec, &reference);
        }
    }
}

/// The cells by positions in `order`, as sorted sets.
fn renamed(run: &Outcome, order: &[usize]) -> Vec<Vec<u64>> {
    let width = run.space + 1;
    let rename = |row: &[u64]| {
        let mut row: Vec<u64> = row.iter().map(|&v| order[v as usize] as u64).collect();
        row.sort_unstable();
        row
    };
    let mut rows: Vec<Vec<u64>> = run.cells().chunks_exact(width).map(rename).collect();
    rows.sort_unstable();
    rows
}

fn over_orders<P: Point>(points: &[P]) {
    let reference = reference(points);
    let identity: Vec<usize> = (0..points.len()).collect();
    let expected = renamed(&reference, &identity);
    for seed in 0..3 {
        let mut order = identity.clone();
        match seed {
            0 => order.reverse(),
            _ => Draw::new(seed).shuffle(&mut order),
        }
        let shuffled: Vec<P> = order.iter().map(|&i| points[i]).collect();
        for workers in [5, 64] {
            let spec = simulated(Workers::Count(workers), 3, LEAF);
            let run = triangulate(&shuffled, &spec).unwrap();
            assert!(renamed(&run, &order) == expected, "shuffled by {seed}, {workers} workers");
            assert_verified(&shuffled, &run);
            let counted = simulate(&shuffled, &spec).unwrap();
            assert!(counted.cells() == run.cells(), "shuffled by {seed}, {workers} workers, counted");
            // Tree, work and depth do not depend on the order of the input. The hash of the graph depends on the indices.
            let mut ledger = counted.ledger;
            ledger.part.edge_hash = reference.ledger.part.edge_hash;
            assert_same_counts(&reference.ledger, &ledger, "shuffled");
        }
    }
}

#[test]
fn machines_agree_on_uniform_points_in_space() {
    over_machines(&space(Kind::Uniform, 1500, 3));
}

#[test]
fn machines_agree_on_uniform_points_in_the_plane() {
    over_machines(&plane(Kind::Uniform, 2000, 3));
}

#[test]
fn machines_agree_on_a_grid() {
    over_machines(&space(Kind::Grid, 1331, 0));
}

#[test]
fn machines_agree_on_clusters_in_the_plane() {
    over_machines(&plane(Kind::Clusters, 2000, 3));
}

#[test]
fn supergraphs_give_the_same_cells_in_space() {
    over_graphs(&space(Kind::Uniform, 1500, 4));
}

#[test]
fn supergraphs_give_the_same_cells_on_a_lattice() {
    over_graphs(&space(Kind::Fcc, 1372, 4));
}

#[test]
fn supergraphs_give_the_same_cells_in_the_plane() {
    over_graphs(&plane(Kind::GradedPoint, 2000, 4));
}

#[test]
fn other_trees_give_the_same_cells() {
    over_trees(&space(Kind::Clusters, 5000, 8));
    over_trees(&plane(Kind::Grid, 4900, 8));
}

#[test]
fn orders_of_the_input_give_the_same_cells() {
    over_orders(&space(Kind::WellSpaced, 2500, 2));
    over_orders(&space(Kind::Grid, 1728, 2));
    over_orders(&plane(Kind::Uniform, 2500, 2));
}
