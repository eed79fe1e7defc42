//! The numbers of small sets against counts of their cells.

use std::collections::{BTreeMap, BTreeSet};

use crate::result::stats::Stats;
use crate::spec::{Spec, Workers};
use crate::{simulate, triangulate};

fn spec(workers: u32) -> Spec {
    let mut spec = Spec::default();
    spec.machine.workers = Workers::Count(workers);
    spec
}

/// Numbers below 1 that look random.
fn noise(i: usize) -> f64 {
    let x = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (x ^ (x >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) as f64 / u64::MAX as f64
}

/// Counts the parts of cells, and compares them with the numbers.
fn check(stats: &Stats, cells: &[u64], points: usize) {
    let d = stats.space;
    let (mut edges, mut facets, mut degrees) = (BTreeSet::new(), BTreeMap::new(), BTreeMap::new());
    for cell in cells.chunks_exact(d + 1) {
        for (i, &v) in cell.iter().enumerate() {
            for &w in &cell[..i] {
                if edges.insert((v.min(w), v.max(w))) {
                    *degrees.entry(v).or_insert(0u64) += 1;
                    *degrees.entry(w).or_insert(0u64) += 1;
                }
            }
            let mut facet: Vec<u64> = cell.iter().copied().filter(|&w| w != v).collect();
            facet.sort_unstable();
            *facets.entry(facet).or_insert(0) += 1;
        }
    }
    let hull: Vec<&Vec<u64>> =
        facets.iter().filter(|(_, cells)| **cells == 1).map(|(facet, _)| facet).collect();
    let on_hull: BTreeSet<u64> = hull.iter().copied().flatten().copied().collect();
    let hull_edges: BTreeSet<(u64, u64)> = hull
        .iter()
        .flat_map(|&f| (0..f.len()).flat_map(move |i| (0..i).map(move |j| (f[j], f[i]))))
        .collect();
    assert_eq!((stats.points, stats.cells), (points as u64, (cells.len() / (d + 1)) as u64));
    assert_eq!((stats.edges, stats.facets), (edges.len() as u64, facets.len() as u64));
    assert_eq!((stats.hull_facets, stats.hull_vertices), (hull.len() as u64, on_hull.len() as u64));
    assert_eq!(stats.hull_edges, hull_edges.len() as u64);
    let (v, e, f, c) = (stats.points as i64, stats.edges as i64, stats.facets as i64, stats.cells as i64);
    assert_eq!(if d == 2 { v - e + c } else { v - e + f - c }, 1, "Euler's formula");
    let most = degrees.values().max().copied().unwrap_or(0);
    assert_eq!((stats.degrees.total(), stats.degrees.most), (points as u64, most as f64));
    for (degree, &count) in stats.degrees.counts.iter().enumerate() {
        assert_eq!(
            count,
            degrees.values().filter(|d| **d == degree as u64).count() as u64,
            "degree {degree}"
        );
    }
    assert_eq!((stats.components, stats.shapes.ratios.total()), (1, stats.cells));
}

#[test]
fn parts_are_those_of_the_cells_for_any_number_of_workers() {
    for n in [4, 5, 9, 40, 300] {
        let plane: Vec<[f64; 2]> = (0..n).map(|i| [noise(2 * i), noise(2 * i + 1)]).collect();
        let space: Vec<[f64; 3]> = (0..n + 1).map(|i| [0, 1, 2].map(|k| noise(3 * i + k))).collect();
        let lattice: Vec<[f64; 3]> =
            (0..64).map(|i| [f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16)]).collect();
        let mut first: [Option<Stats>; 3] = [None, None, None];
        for workers in [1, 3, 16] {
            let a = triangulate(&plane, &spec(workers)).unwrap();
            let b = triangulate(&space, &spec(workers)).unwrap();
            let c = triangulate(&lattice, &spec(workers)).unwrap();
            let found = [
                a.stats(plane.as_flattened()).unwrap(),
                b.stats(space.as_flattened()).unwrap(),
                c.stats(lattice.as_flattened()).unwrap(),
            ];
            for ((stats, run), first) in found.into_iter().zip([a, b, c]).zip(&mut first) {
                check(&stats, run.cells(), run.points.used as usize);
                assert_eq!(*first.get_or_insert_with(|| stats.clone()), stats, "{workers} workers");
            }
        }
    }
}

#[test]
fn a_lattice_has_known_measures() {
    let side = 6;
    let grid: Vec<[f64; 2]> = (0..side * side).map(|i| [f64::from(i % side), f64::from(i / side)]).collect();
    let stats = triangulate(&grid, &spec(3)).unwrap().stats(grid.as_flattened()).unwrap();
    assert_eq!((stats.cells, stats.edges), (50, 85));
    assert_eq!((stats.volume, stats.surface, stats.hull_vertices), (25.0, 20.0, 20));
    assert_eq!(stats.extent, [[0.0, 5.0], [0.0, 5.0]]);
    let shapes = &stats.shapes;
    assert_eq!([shapes.least_angles.percentile(1), shapes.least_angles.percentile(99)], [Some(45.0); 2]);
    assert_eq!(shapes.largest_angles.percentile(50), Some(90.0));
    assert!((shapes.ratios.mean().unwrap() - 0.5f64.sqrt()).abs() < 1e-15);
    assert_eq!(shapes.volumes, [0.5, 0.5]);
    let cube: Vec<[f64; 3]> = (0..125)
        .map(|i| [f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)].map(|x| x * 0.5))
        .collect();
    let stats = triangulate(&cube, &spec(4)).unwrap().stats(cube.as_flattened()).unwrap();
    assert_eq!((stats.volume, stats.surface), (8.0, 24.0));
}

#[test]
fn duplicates_flat_sets_and_runs_without_neighbours() {
    let twice = [[0.0, 0.0], [1.0, 0.0], [-0.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let stats = triangulate(&twice, &spec(2)).unwrap().stats(twice.as_flattened()).unwrap();
    assert_eq!((stats.points, stats.duplicates, stats.edges, stats.cells), (4, 1, 5, 2));
    let line = [[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]];
    let stats = triangulate(&line, &spec(2)).unwrap().stats(line.as_flattened()).unwrap();
    assert_eq!((stats.points, stats.cells, stats.components, stats.edges), (3, 0, 0, 0));
    assert_eq!((stats.extent, stats.degrees.total()), (vec![[0.0, 3.0]; 2], 0));
    let space: Vec<[f64; 3]> = (0..200).map(|i| [0, 1, 2].map(|k| noise(3 * i + k))).collect();
    let counted = simulate(&space, &spec(5)).unwrap();
    let direct = triangulate(&space, &spec(5)).unwrap();
    assert_eq!(counted.stats(space.as_flattened()), direct.stats(space.as_flattened()));
    assert_eq!(direct.stats(&space.as_flattened()[3..]), None);
}

#[test]
fn shapes_do_not_depend_on_the_scale() {
    let space: Vec<[f64; 3]> = (0..100).map(|i| [0, 1, 2].map(|k| noise(3 * i + k))).collect();
    let far: Vec<[f64; 3]> = space.iter().map(|p| p.map(|x| x * 2f64.powi(-300))).collect();
    let near = triangulate(&space, &spec(2)).unwrap().stats(space.as_flattened()).unwrap();
    let small = triangulate(&far, &spec(2)).unwrap().stats(far.as_flattened()).unwrap();
    assert_eq!(near.shapes.angles, small.shapes.angles);
    assert_eq!(near.shapes.ratios, small.shapes.ratios);
    assert_eq!(near.degrees, small.degrees);
}
