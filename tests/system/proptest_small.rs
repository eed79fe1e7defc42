//! Small nasty inputs: septet's machine, its sequential kernel and its verifier agree.

use crate::common::{assert_verified, combinations, simulated, threaded, with_graph, within};
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use septet_core::spec::{Neighbours, Workers};
use septet_core::{simulate, triangulate};
use septet_geometry::complex::INFINITE;
use septet_geometry::incremental::{Incremental, IncrementalError};
use septet_geometry::point::Point;

/// Seconds after which a run of so few points has hung.
const PATIENCE: u64 = 5;

/// Points on few places: integers, lines, clusters far apart, one sphere.
fn points() -> impl Strategy<Value = Vec<DVec3>> {
    let lattice = |low: i32, high: i32| {
        let axis = low..=high;
        (axis.clone(), axis.clone(), axis).prop_map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into()))
    };
    let grid = prop::collection::vec(lattice(0, 2), 0..40);
    let wide = prop::collection::vec(lattice(-9, 9), 0..60);
    let lines = prop::collection::vec((0..3usize, -20..20i32), 0..40).prop_map(|places| {
        let on = |(axis, t): (usize, i32)| {
            let mut p = DVec3::new(0.0, 1.0, 3.0);
            p[axis] = t.into();
            p
        };
        places.into_iter().map(on).collect::<Vec<_>>()
    });
    let clusters = prop::collection::vec((lattice(0, 1), lattice(0, 3)), 0..60)
        .prop_map(|pairs| pairs.into_iter().map(|(far, near)| far * 1e6 + near * 0.25).collect::<Vec<_>>());
    // All integer points at distance 5 or 7 from the origin.
    let sphere =
        prop::collection::vec((any::<prop::sample::Index>(), any::<bool>()), 4..60).prop_map(|picks| {
            let shell = |r2: i32| {
                let side = -7..=7;
                let all =
                    side.clone().flat_map(|x| (-7..=7).flat_map(move |y| (-7..=7).map(move |z| [x, y, z])));
                all.filter(|p: &[i32; 3]| p.iter().map(|c| c * c).sum::<i32>() == r2)
                    .map(|p| DVec3::from_array(p.map(f64::from)))
                    .collect::<Vec<_>>()
            };
            let (inner, outer) = (shell(25), shell(49));
            picks
                .into_iter()
                .map(|(i, far)| if far { *i.get(&outer) } else { *i.get(&inner) })
                .collect::<Vec<_>>()
        });
    prop_oneof![grid, wide, lines, clusters, sphere]
}

/// The kernel's cells over the distinct points, as sorted sets of input indices.
fn by_insertion<P: Point>(points: &[P]) -> Option<Vec<Vec<u64>>> {
    let mut ids: Vec<u64> = Vec::new();
    for (i, p) in points.iter().enumerate() {
        if !points[..i].contains(p) {
            ids.push(i as u64);
        }
    }
    let distinct: Vec<P> = ids.iter().map(|&i| points[i as usize]).collect();
    match Incremental::new(distinct) {
        Ok(delaunay) => {
            let finite = delaunay.cells().filter(|cell| !cell.as_ref().contains(&INFINITE));
            let named = finite.map(|cell| cell.as_ref().iter().map(|&v| ids[v as usize]).collect());
            Some(sorted(named.collect()))
        }
        Err(IncrementalError::Flat { .. }) => None,
        Err(error) => panic!("{error}"),
    }
}

fn sorted(mut rows: Vec<Vec<u64>>) -> Vec<Vec<u64>> {
    for row in &mut rows {
        row.sort_unstable();
    }
    rows.sort_unstable();
    rows
}

fn agree<P: Point>(points: &[P], workers: u32, leaf: u64, graph: usize) {
    let expected = by_insertion(points);
    // A fixed k may be as large as the number of points, which is refused.
    let (kind, sets, alpha, _) = combinations(false)[graph];
    let choice = (kind, sets, alpha, Neighbours::Auto);
    let threads = with_graph(&threaded(Workers::Count(workers), 2, leaf), choice);
    let sim = with_graph(&simulated(Workers::Count(workers), 7, leaf), choice);
    for run in [triangulate(points, &threads), simulate(points, &sim)] {
        let run = run.unwrap_or_else(|e| panic!("{workers} workers, leaf {leaf}, {choice:?}: {e}"));
        assert_verified(points, &run);
        let cells = sorted(run.cells().chunks_exact(P::DIM + 1).map(<[u64]>::to_vec).collect());
        assert_eq!(cells, expected.clone().unwrap_or_default());
    }
}

/// Seventeen points in the corners of a large cube: far corner or not by axis, then quarters.
const CORNERS: [[u32; 6]; 17] = [
    [0, 0, 0, 0, 1, 3],
    [1, 1, 1, 0, 3, 3],
    [1, 0, 0, 3, 3, 0],
    [0, 0, 0, 0, 1, 2],
    [0, 1, 0, 2, 2, 1],
    [1, 0, 0, 2, 2, 2],
    [1, 0, 0, 1, 3, 1],
    [0, 0, 0, 1, 0, 3],
    [1, 1, 0, 2, 1, 3],
    [0, 1, 1, 0, 1, 1],
    [0, 0, 0, 3, 2, 2],
    [1, 1, 1, 0, 1, 3],
    [1, 1, 0, 3, 1, 2],
    [1, 1, 1, 1, 1, 1],
    [0, 0, 0, 3, 0, 2],
    [1, 1, 1, 3, 1, 2],
    [0, 1, 1, 1, 3, 0],
];

fn corners() -> Vec<DVec3> {
    let axis = |row: &[u32; 6], i: usize| f64::from(row[i]) * 1e6 + f64::from(row[i + 3]) * 0.25;
    CORNERS.iter().map(|row| DVec3::from_array(std::array::from_fn(|i| axis(row, i)))).collect()
}

/// Found at random: a run of these points did not end.
#[test]
fn seventeen_points_in_corners() {
    for (graph, choice) in combinations(false).into_iter().enumerate() {
        let choice = (choice.0, choice.1, choice.2, Neighbours::Auto);
        for workers in 1..5 {
            let what = format!("{choice:?} ({graph}), {workers} workers");
            let threads = with_graph(&threaded(Workers::Count(workers), 2, 2), choice);
            let sim = with_graph(&simulated(Workers::Count(workers), 7, 2), choice);
            let run =
                within(PATIENCE, &format!("triangulate, {what}"), move || triangulate(&corners(), &threads));
            assert_verified(&corners(), &run.unwrap());
            let run = within(PATIENCE, &format!("simulate, {what}"), move || simulate(&corners(), &sim));
            assert_verified(&corners(), &run.unwrap());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn small_sets_agree_with_insertion_in_space(points in points(), workers in 1..9u32, leaf in 1..12u64, graph in 0..7usize) {
        let what = format!("{points:?}");
        within(PATIENCE, &what, move || agree(&points, workers, leaf, graph));
    }

    #[test]
    fn small_sets_agree_with_insertion_in_the_plane(points in points(), workers in 1..9u32, leaf in 1..12u64, graph in 0..7usize) {
        let flat: Vec<DVec2> = points.iter().map(|p| p.truncate()).collect();
        let what = format!("{flat:?}");
        within(PATIENCE, &what, move || agree(&flat, workers, leaf, graph));
    }
}
