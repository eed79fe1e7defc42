//! The graph of the divide and conquer is the graph by definition, edge by edge; and what the paper says of it
//! holds where its hypothesis does.

use std::collections::BTreeSet;

use crate::common::sets::{plane, space};
use crate::common::{assert_same_counts, base, check_counted, combinations, threaded, with_graph};
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Graph, GraphKind, Neighbours, SeparatorSets, Until, Workers};
use septet_core::{Spec, count, simulate};
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
        Supergraph::Overlap { k, .. } | Supergraph::Knn { k } => k as usize,
        Supergraph::Density { .. } => 1,
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
                Supergraph::Overlap { alpha, .. } => d2.sqrt() <= alpha * small.sqrt() + large.sqrt(),
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

/// A configuration that builds an overlap graph of balls to the k-th neighbour and keeps its edges.
fn with_balls(alpha: f64, k: u32, sets: SeparatorSets) -> Spec {
    base().with(|c| {
        c.recursion.graph = Graph::Overlap { alpha: Alpha::Value(alpha), k: Neighbours::Count(k) };
        c.recursion.sets = sets;
        c.keep.graph = true;
    })
}

/// Compares overlap graphs of all k with their definition. Every fifth point occurs twice, and only distinct points are
/// neighbours.
fn compare_balls<P: Point>(points: &[P], what: &str) {
    let repeated = [points, &points[..points.len() / 5]].concat();
    for k in [1, 2, 4, 8, 16] {
        let expected = by_definition(points, Supergraph::Overlap { alpha: 1.5, k });
        for (sets, workers) in
            [(SeparatorSets::Ghost, 1), (SeparatorSets::Ghost, 7), (SeparatorSets::Both, 3)]
        {
            let spec = with_balls(1.5, k, sets).with(|c| {
                c.tree.leaf = Some(30);
                c.machine.workers = Workers::Count(workers);
            });
            let run = count(&repeated, Some(Until::Graph), &spec).unwrap();
            assert!(crate::common::levels(&run.ledger) >= 3, "{what}: no tree");
            assert!(run.kept.graph == Some(expected.clone()), "{what}, k = {k}, {sets:?}, {workers} workers");
        }
    }
}

#[test]
fn balls_to_any_neighbour_have_the_edges_of_their_definition() {
    let kinds = [Kind::Uniform, Kind::Clusters, Kind::GradedPoint, Kind::Grid, Kind::Fcc, Kind::Sphere];
    for kind in kinds {
        compare_balls(&space(kind, 600, 3), &format!("{kind} in space"));
        compare_balls(&plane(kind, 600, 3), &format!("{kind} in the plane"));
    }
}

/// With k = 1, the counts are those of the default.
#[test]
fn balls_to_the_first_neighbour_are_the_default() {
    let points = space(Kind::Clusters, 900, 4);
    for sets in [SeparatorSets::Ghost, SeparatorSets::Both] {
        let first = simulate(&points, &with_balls(2.0, 1, sets)).unwrap();
        let spec = base().with(|c| {
            c.recursion.graph = Graph::Overlap { alpha: Alpha::Value(2.0), k: Neighbours::Auto };
            c.recursion.sets = sets;
        });
        assert_same_counts(&first.ledger, &simulate(&points, &spec).unwrap().ledger, "k = 1");
    }
}

/// A ball needs a k-th neighbour. Repeated points are none.
#[test]
fn balls_beyond_the_last_neighbour_are_refused() {
    let points = plane(Kind::Uniform, 9, 1);
    let repeated = [&points[..], &points[..]].concat();
    for k in [9, 10, 0] {
        let error = simulate(&repeated, &with_balls(1.0, k, SeparatorSets::Ghost)).unwrap_err();
        assert!(error.to_string().starts_with(&format!("k is {k}, but the set has 9 points")), "{error}");
    }
    let run = count(&repeated, Some(Until::Graph), &with_balls(1.0, 8, SeparatorSets::Ghost)).unwrap();
    assert_eq!(run.kept.graph.map(|edges| edges.len()), Some(36));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    /// Few places, so that many distances tie.
    #[test]
    fn balls_on_lattices_have_the_edges_of_their_definition(
        places in prop::collection::btree_set((0..6i32, 0..6i32, 0..4i32), 20..60),
        k in 1..20u32,
        quarters in 4..16u32,
        workers in 1..6u32,
        both in any::<bool>(),
    ) {
        let alpha = f64::from(quarters) / 4.0;
        let sets = if both { SeparatorSets::Both } else { SeparatorSets::Ghost };
        let spec = with_balls(alpha, k, sets).with(|c| {
            c.tree.leaf = Some(6);
            c.machine.workers = Workers::Count(workers);
        });
        let at = |&(x, y, z): &(i32, i32, i32)| DVec3::new(x.into(), y.into(), z.into());
        let solid: Vec<DVec3> = places.iter().map(at).collect();
        let flat: BTreeSet<(i32, i32)> = places.iter().map(|&(x, y, z)| (7 * z + x, y)).collect();
        let flat: Vec<DVec2> = flat.iter().map(|&(x, y)| DVec2::new(x.into(), y.into())).collect();
        let rule = Supergraph::Overlap { alpha, k };
        let of_space = count(&solid, Some(Until::Graph), &spec).unwrap();
        let of_plane = count(&flat, Some(Until::Graph), &spec).unwrap();
        for (run, expected) in [(of_space, by_definition(&solid, rule)), (of_plane, by_definition(&flat, rule))] {
            // A set that does not span the space has no graph.
            if run.dimension == run.space as isize {
                prop_assert_eq!(run.kept.graph, Some(expected));
            }
        }
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
fn own_separators_keep_their_bounds_on_any_number_of_workers() {
    let points = space(Kind::WellSpaced, 6000, 2);
    let run = |sets, workers| {
        let spec = base().with(|c| {
            c.recursion.sets = sets;
            c.recursion.spacing = Some(0.0);
            c.machine.workers = Workers::Count(workers);
            c.tree.leaf = Some(600);
            c.keep.graph = true;
        });
        simulate(&points, &spec).unwrap()
    };
    let ghost = run(SeparatorSets::Ghost, 1);
    let one = run(SeparatorSets::Own, 1);
    assert_eq!(one.kept.graph, ghost.kept.graph);
    let divided = one.ledger.part.nodes.values().filter(|facts| facts.set_inside > 0);
    let ratios = divided.map(|f| f.set_inside.max(f.members - f.set_inside) as f64 / f.members as f64);
    let ratios: Vec<f64> = ratios.collect();
    assert!(ratios.len() > 3 && ratios.iter().all(|&ratio| ratio <= 0.85), "{ratios:?}");
    for workers in [3, 16] {
        let other = run(SeparatorSets::Own, workers);
        assert_eq!(other.kept.graph, ghost.kept.graph, "{workers}");
        assert_eq!(other.ledger.totals, one.ledger.totals, "{workers}");
        assert_eq!(other.ledger.part.nodes, one.ledger.part.nodes, "{workers}");
    }
}

#[test]
fn separator_sets_contain_every_edge() {
    let points = space(Kind::WellSpaced, 4000, 2);
    for rule in [SeparatorSets::Both, SeparatorSets::Own, SeparatorSets::Smaller] {
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
        let members: u64 =
            one.ledger.part.nodes.values().map(septet_protocol::ledger::NodeFacts::compared).sum();
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
