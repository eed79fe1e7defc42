//! The graph of the divide and conquer is the graph by definition, edge by edge; and what the paper says of it
//! holds where its hypothesis does.

use crate::common::sets::{plane, space};
use crate::common::{base, check_counted, combinations, threaded, with_graph};
use septet_core::generate::Kind;
use septet_core::simulate;
use septet_core::spec::{Alpha, GraphKind, Neighbours, SeparatorSets, Workers};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_lab::assert_counts;

fn squared<P: Point>(a: &P, b: &P) -> f64 {
    (0..P::DIM).map(|i| a.coord(i) - b.coord(i)).fold(0.0, |sum, d| sum + d * d)
}

/// All edges by definition, from all pairs.
fn by_definition<P: Point>(points: &[P], rule: Supergraph) -> Vec<(u64, u64)> {
    let n = points.len();
    let order = match rule {
        Supergraph::Knn { k } => k as usize,
        _ => 1,
    };
    let mut radii = Vec::with_capacity(n);
    let mut distances = vec![0.0; n];
    for p in points {
        for (d, q) in distances.iter_mut().zip(points) {
            *d = squared(p, q);
        }
        // Its own distance, 0, is the smallest.
        radii.push(*distances.select_nth_unstable_by(order, f64::total_cmp).1);
    }
    let mut edges = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            let d2 = squared(&points[i], &points[j]);
            let (small, large) = (radii[i].min(radii[j]), radii[i].max(radii[j]));
            let joined = match rule {
                Supergraph::Density { alpha } => d2 <= alpha * alpha * small,
                Supergraph::Overlap { alpha } => d2.sqrt() <= alpha * small.sqrt() + large.sqrt(),
                Supergraph::Knn { .. } => d2 <= large,
            };
            if joined {
                edges.push((i as u64, j as u64));
            }
        }
    }
    edges
}

fn compare<P: Point>(points: &[P], choices: &[(GraphKind, Alpha, Neighbours)], leaf: u64, what: &str) {
    for &(kind, alpha, k) in choices {
        let mut expected = None;
        for (graph, sets, ..) in combinations(false).into_iter().filter(|c| c.0 == kind) {
            for workers in [1, 7] {
                let spec = threaded(Workers::Count(workers), 2, leaf);
                let spec = with_graph(&spec, (graph, sets, alpha, k)).with(|c| c.keep.graph = true);
                let run = simulate(points, &spec).unwrap_or_else(|e| panic!("{what} {spec:?}: {e}"));
                assert!(crate::common::levels(&run.ledger) >= 3, "{what}: no tree");
                let rule = run.settled.supergraph.unwrap();
                let expected = expected.get_or_insert_with(|| by_definition(points, rule));
                let found = run.kept.graph.unwrap();
                assert_eq!(expected.len(), found.len(), "{what} {spec:?}: number of edges");
                assert!(*expected == found, "{what} {spec:?}: other edges");
                let counted: u64 = run.ledger.part.nodes.values().map(|facts| facts.edges).sum();
                assert_eq!(counted, found.len() as u64, "{what} {spec:?}: edges in the ledger");
            }
        }
    }
}

fn choices() -> [(GraphKind, Alpha, Neighbours); 4] {
    [
        (GraphKind::Density, Alpha::Value(2.5), Neighbours::Auto),
        (GraphKind::Density, Alpha::Value(4.0), Neighbours::Auto),
        (GraphKind::Overlap, Alpha::Value(2.0), Neighbours::Auto),
        (GraphKind::Knn, Alpha::Auto, Neighbours::Count(12)),
    ]
}

const KINDS: [Kind; 4] = [Kind::Uniform, Kind::Grid, Kind::GradedPoint, Kind::Clusters];

#[test]
fn supergraphs_have_the_edges_of_their_definition_in_space() {
    for kind in KINDS {
        compare(&space(kind, 1500, 3), &choices(), 60, kind.name());
    }
}

#[test]
fn supergraphs_have_the_edges_of_their_definition_in_the_plane() {
    for kind in KINDS {
        compare(&plane(kind, 2000, 3), &choices(), 40, kind.name());
    }
}

#[test]
fn density_graphs_of_ten_thousand_points_have_the_edges_of_their_definition() {
    compare(&space(Kind::Uniform, 10_000, 3), &choices()[..1], 1000, "uniform");
    compare(&plane(Kind::Uniform, 10_000, 3), &choices()[..1], 500, "uniform");
}

/// Every edge of the triangulation is an edge of the graph, no star needs an exchange, degrees are bounded.
fn hypothesis<P: Point>(points: &[P], lipschitz: f64, what: &str) -> (f64, u64) {
    let spec = base().with(|c| {
        c.recursion.spacing = Some(lipschitz);
        c.tree.leaf = Some(200);
        c.keep.graph = true;
    });
    let run = check_counted(points, &spec);
    assert_counts!(run, no_repair());
    let graph = run.kept.graph.clone().unwrap();
    for cell in run.cells().chunks_exact(P::DIM + 1) {
        for (i, &a) in cell.iter().enumerate() {
            for &b in &cell[..i] {
                let edge = (a.min(b), a.max(b));
                assert!(graph.binary_search(&edge).is_ok(), "{what}: edge {edge:?} is not in the graph");
            }
        }
    }
    let mean = 2.0 * graph.len() as f64 / points.len() as f64;
    let largest = run.ledger.part.nodes.values().map(|facts| facts.max_degree).max().unwrap();
    println!("{what} {}D: mean degree {mean:.1}, largest {largest}", P::DIM);
    (mean, largest)
}

#[test]
fn well_spaced_sets_need_no_exchange() {
    for seed in 0..3 {
        let (mean, largest) = hypothesis(&space(Kind::WellSpaced, 6000, seed), 0.0, "well-spaced");
        assert!(mean <= 60.0 && largest <= 125, "degrees {mean} {largest}");
        hypothesis(&plane(Kind::WellSpaced, 6000, seed), 0.0, "well-spaced");
    }
    // alpha is 1.25 * 2 (1 + L) / (1 - L) with the generator's constant, 1/4.
    hypothesis(&space(Kind::GradedPoint, 4000, 1), 0.25, "graded");
    hypothesis(&plane(Kind::GradedPoint, 4000, 1), 0.25, "graded");
}

/// The sets of the recursion are the same for every number of workers, contain every edge, and contain every point.
#[test]
fn separator_sets_contain_every_edge() {
    let points = space(Kind::WellSpaced, 4000, 2);
    for rule in [SeparatorSets::Both, SeparatorSets::Smaller] {
        let run = |workers| {
            let spec = base().with(|c| {
                c.recursion.sets = rule;
                c.recursion.spacing = Some(0.0);
                c.machine.workers = Workers::Count(workers);
                c.tree.leaf = Some(400);
                (c.keep.graph, c.keep.sets) = (true, true);
            });
            simulate(&points, &spec).unwrap()
        };
        let one = run(1);
        let sets = one.kept.sets.clone().unwrap();
        assert_eq!(Some(&sets), run(5).kept.sets.as_ref(), "{rule:?}");
        let members: u64 = one.ledger.part.nodes.values().map(|facts| facts.members).sum();
        assert!(sets.len() as u64 == members && sets.len() > points.len(), "{rule:?}");
        let mut nodes = vec![Vec::new(); points.len()];
        for member in &sets {
            nodes[member.point as usize].push(member.node);
        }
        assert!(nodes.iter().all(|nodes| !nodes.is_empty()));
        for (i, j) in one.kept.graph.unwrap() {
            assert!(
                nodes[i as usize].iter().any(|node| nodes[j as usize].contains(node)),
                "{rule:?}: {i} {j}"
            );
        }
    }
}
