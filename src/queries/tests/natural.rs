use glam::DVec3;
use septet_geometry::coordinates::Coordinates;

use super::{Draw, both, linear, made, whole_grid, whole_sets};
use crate::{Dimension, Method, NONE, QueryError, Tessellation, Weights};

fn row(weights: &Weights, at: usize) -> Vec<(u32, f64)> {
    let range = weights.offsets[at] as usize..weights.offsets[at + 1] as usize;
    weights.indices[range.clone()].iter().copied().zip(weights.values[range].iter().copied()).collect()
}

/// Rows add up to 1, have no negative weight, and reproduce linear functions.
fn check<P: Dimension>(t: &Tessellation<P>, queries: &[P], tolerance: f64) {
    let values: Vec<f64> = (0..t.len()).map(|v| linear(t.point(v as u32))).collect();
    let found = t.locate(queries);
    for method in Method::ALL {
        let weights = t.weights(queries, method);
        assert!(weights.values.iter().all(|x| *x > 0.0));
        let made = weights.interpolate(&values).unwrap();
        for (i, &q) in queries.iter().enumerate() {
            let row = row(&weights, i);
            assert!(row.is_sorted_by_key(|entry| entry.0));
            if found[i] == NONE {
                assert!(row.is_empty() && made[i].is_nan());
                continue;
            }
            let sum: f64 = row.iter().map(|entry| entry.1).sum();
            assert!((sum - 1.0).abs() < 1e-14);
            assert!(
                (made[i] - linear(q)).abs() < tolerance,
                "{} {q:?} {} {}",
                method.name(),
                made[i],
                linear(q)
            );
        }
    }
}

both!(linear_functions_in_the_plane, linear_functions_in_space, linear_functions);

fn linear_functions<P: Dimension + Coordinates>() {
    let mut draw = Draw(11);
    let points: Vec<P> = draw.uniform(1000);
    let queries: Vec<P> = draw.uniform(1000);
    check(&made(&points), &queries, 1e-9);
    check(&made(&points), &points, 1e-15);
    for points in whole_sets::<P>() {
        let t = made(&points);
        let mut queries = points.clone();
        for _ in 0..300 {
            let [a, b] = [0, 1].map(|_| points[draw.below(points.len() as u64) as usize]);
            queries.extend([(a + b) * 0.5, a + (b - a) * draw.unit()]);
            queries.push(draw.point(|draw| 16.0 * draw.unit() - 4.0));
        }
        check(&t, &queries, 1e-9);
    }
}

both!(slivers_in_the_plane, slivers_in_space, slivers);

/// Grids moved a little, with queries at and near to their points, edges and facets.
fn slivers<P: Dimension + Coordinates>() {
    let mut draw = Draw(13);
    for step in [1e-15, 1e-12, 1e-9, 1e-6, 1e-3] {
        let grid: Vec<P> = whole_grid(6);
        let points: Vec<P> = grid.iter().map(|&p| p + draw.point::<P>(|draw| step * draw.unit())).collect();
        let mut queries: Vec<P> = (0..500).map(|_| draw.point(|draw| 5.0 * draw.unit())).collect();
        queries.extend(grid.iter().map(|&p| p + P::splat(0.5)));
        queries.extend(grid.iter().map(|&p| p + draw.point::<P>(|draw| 1e-9 * draw.unit())));
        check(&made(&points), &queries, 1e-9);
    }
}

both!(sibson_in_the_plane, sibson_in_space, sibson);

/// Sibson's weights are the volumes that an inserted point takes, and Laplace's the areas of its ridges over their lengths.
fn sibson<P: Dimension + Coordinates>() {
    let mut draw = Draw(17);
    for grid in [false, true] {
        let mut points: Vec<P> = if grid { whole_grid(5) } else { draw.uniform(150) };
        let size = if grid { 4.0 } else { 1.0 };
        let [low, high] = [-40.0, 40.0].map(P::splat);
        let t = made(&points);
        let before = t.voronoi_volumes_in(low, high).unwrap();
        for _ in 0..20 {
            let q: P = draw.point(|draw| size * (0.3 + 0.4 * draw.unit()));
            points.push(q);
            let with = made(&points);
            points.pop();
            let after = with.voronoi_volumes_in(low, high).unwrap();
            let of_q = after[points.len()];
            let weights = t.weights(&[q], Method::Sibson);
            for v in 0..points.len() {
                let weight =
                    row(&weights, 0).iter().find(|entry| entry.0 as usize == v).map_or(0.0, |entry| entry.1);
                assert!((weight - (before[v] - after[v]) / of_q).abs() < 1e-6);
            }
            let ridges = with.ridges_in(low, high).unwrap();
            let mut laplace: Vec<(u32, f64)> = Vec::new();
            for (ends, area) in ridges.points.iter().zip(&ridges.areas) {
                if ends[1] as usize == points.len() {
                    laplace.push((ends[0], area / (points[ends[0] as usize] - q).norm2().sqrt()));
                }
            }
            let sum: f64 = laplace.iter().map(|entry| entry.1).sum();
            let found = row(&t.weights(&[q], Method::Laplace), 0);
            for (v, weight) in laplace {
                let own = found.iter().find(|entry| entry.0 == v).map_or(0.0, |entry| entry.1);
                assert!((own - weight / sum).abs() < 1e-10);
            }
        }
    }
}

/// The weights on faces, edges and corners of a cube are the limits from inside.
#[test]
fn weights_on_the_hull_are_limits() {
    let mut points: Vec<DVec3> = whole_grid(4);
    let mut draw = Draw(19);
    // More points on the faces, in general position there.
    for _ in 0..40 {
        points.push(DVec3::new(3.0 * draw.unit(), 3.0 * draw.unit(), 0.0));
    }
    let t = made(&points);
    for method in [Method::Sibson, Method::Laplace] {
        for _ in 0..50 {
            let on = DVec3::new(3.0 * draw.unit(), 3.0 * draw.unit(), 0.0);
            let inside = on + DVec3::new(0.0, 0.0, 1e-7);
            let [a, b] = [on, inside].map(|q| row(&t.weights(&[q], method), 0));
            assert!(a.iter().all(|entry| points[entry.0 as usize].z == 0.0));
            for &(v, weight) in &b {
                let other = a.iter().find(|entry| entry.0 == v).map_or(0.0, |entry| entry.1);
                assert!((weight - other).abs() < 1e-5, "{} {weight} {other}", method.name());
            }
        }
        let edge = row(&t.weights(&[DVec3::new(1.25, 0.0, 3.0)], method), 0);
        assert_eq!(edge, [(49, 0.75), (50, 0.25)]);
    }
}

#[test]
fn values_fit_the_points() {
    let t = made(&whole_grid::<DVec3>(2));
    let weights = t.weights(&[DVec3::splat(0.5)], Method::Linear);
    assert_eq!(weights.interpolate(&[1.0; 7]), Err(QueryError::Values { given: 7, columns: 1, points: 8 }));
}
