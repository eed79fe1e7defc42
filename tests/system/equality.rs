//! The same bytes for any number of workers and threads, any transport, order of input, supergraph and
//! separator sets, by `triangulate` and by `simulate`.

use crate::common::sets::{Draw, plane, space};
use crate::common::{
    assert_same_counts, assert_verified, base, check_counted, combinations, levels, simulated, threaded,
    with_graph,
};
use septet_core::config::{Alpha, GraphKind, Neighbours, Workers};
use septet_core::generate::Kind;
use septet_core::{Config, Run, simulate, triangulate};
use septet_geometry::point::Point;

const WORKERS: [Workers; 8] = [
    Workers::Count(1),
    Workers::Count(2),
    Workers::Count(3),
    Workers::Count(5),
    Workers::Count(8),
    Workers::Count(64),
    Workers::Count(1000),
    Workers::Leaves,
];

const LEAF: u64 = 60;

/// The verified triangulation of a set that splits at least six times.
fn reference<P: Point>(points: &[P]) -> Run {
    let run = check_counted(points, &threaded(Workers::Count(2), 2, LEAF));
    assert!(levels(&run.ledger) >= 6, "{} levels", levels(&run.ledger));
    run
}

fn assert_equal<P: Point>(points: &[P], config: &Config, reference: &Run) {
    for counted in [false, true] {
        let run = if counted { simulate(points, config) } else { triangulate(points, config) };
        let run = run.unwrap_or_else(|e| panic!("{config:?}, counted {counted}: {e}"));
        assert!(run.cells() == reference.cells(), "{config:?}, counted {counted}: other cells");
        assert_eq!(run.hull_facets, reference.hull_facets, "{config:?}, counted {counted}");
        assert_eq!(run.points, reference.points, "{config:?}, counted {counted}");
        assert_eq!(run.fallback, None, "{config:?}, counted {counted}");
    }
}

fn over_machines<P: Point>(points: &[P]) {
    let reference = reference(points);
    for workers in WORKERS {
        assert_equal(points, &threaded(workers, 2, LEAF), &reference);
        assert_equal(points, &simulated(workers, 0, LEAF), &reference);
    }
    for workers in [Workers::Count(1), Workers::Count(5), Workers::Count(64)] {
        assert_equal(points, &threaded(workers, 1, LEAF), &reference);
        for delivery_seed in [1, 77] {
            assert_equal(points, &simulated(workers, delivery_seed, LEAF), &reference);
        }
    }
}

fn over_graphs<P: Point>(points: &[P]) {
    let reference = reference(points);
    let mut choices = combinations(true);
    choices.extend(combinations(false));
    let (_, both, ..) = choices[1];
    choices.push((GraphKind::Density, both, Alpha::Value(4.0), Neighbours::Auto));
    choices.push((GraphKind::Density, both, Alpha::Value(1.0), Neighbours::Auto));
    choices.push((GraphKind::Knn, both, Alpha::Auto, Neighbours::Log(4.5)));
    choices.push((GraphKind::Knn, both, Alpha::Auto, Neighbours::Count(1)));
    for choice in choices {
        for config in [simulated(Workers::Count(3), 5, LEAF), threaded(Workers::Count(64), 2, LEAF)] {
            assert_equal(points, &with_graph(&config, choice), &reference);
        }
    }
}

/// Other seeds and leaves change the tree, not the triangulation.
fn over_trees<P: Point>(points: &[P]) {
    let reference = reference(points);
    for seed in [0, 2, u64::MAX] {
        for leaf in [Some(25), None] {
            let config = base().with(|c| {
                c.machine.seed = seed;
                c.machine.leaf = leaf;
                c.machine.workers = Workers::Count(5);
            });
            assert_equal(points, &config, &reference);
        }
    }
}

/// The cells by places in `order`, as sorted sets.
fn renamed(run: &Run, order: &[usize]) -> Vec<Vec<u64>> {
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
            let config = simulated(Workers::Count(workers), 3, LEAF);
            let run = triangulate(&shuffled, &config).unwrap();
            assert!(renamed(&run, &order) == expected, "shuffled by {seed}, {workers} workers");
            assert_verified(&shuffled, &run);
            let counted = simulate(&shuffled, &config).unwrap();
            assert!(counted.cells() == run.cells(), "shuffled by {seed}, {workers} workers, counted");
            // Tree, work and depth do not see the order of the input; the graph's hash sees the indices.
            let mut ledger = counted.ledger;
            ledger.part.edge_hash = reference.ledger.part.edge_hash;
            assert_same_counts(&reference.ledger, &ledger, "shuffled");
        }
    }
}

#[test]
fn machines_in_space() {
    over_machines(&space(Kind::Uniform, 3000, 3));
}

#[test]
fn machines_in_the_plane() {
    over_machines(&plane(Kind::Uniform, 4000, 3));
}

#[test]
fn machines_on_a_grid() {
    over_machines(&space(Kind::Grid, 2744, 0));
}

#[test]
fn machines_on_clusters_in_the_plane() {
    over_machines(&plane(Kind::Clusters, 4000, 3));
}

#[test]
fn graphs_in_space() {
    over_graphs(&space(Kind::Uniform, 3000, 4));
}

#[test]
fn graphs_on_a_lattice() {
    over_graphs(&space(Kind::Fcc, 2916, 4));
}

#[test]
fn graphs_in_the_plane() {
    over_graphs(&plane(Kind::GradedPoint, 4000, 4));
}

#[test]
fn trees() {
    over_trees(&space(Kind::Clusters, 5000, 8));
    over_trees(&plane(Kind::Grid, 4900, 8));
}

#[test]
fn orders_of_the_input() {
    over_orders(&space(Kind::WellSpaced, 5000, 2));
    over_orders(&space(Kind::Grid, 4096, 2));
    over_orders(&plane(Kind::Uniform, 6000, 2));
}
