//! Linear maps of cells, edges, circumradii and centroids against definitions.

use septet_core::Code;

use super::*;
use crate::{NONE, QueryError};

fn transforms_give_barycentric_coordinates<P: Dimension + Coordinates>() {
    let mut draw = Draw(3);
    for points in [draw.uniform::<P>(200), whole_grid(3)] {
        let t = made(&points);
        let queries = draw.uniform::<P>(300);
        let found = t.barycentric(&queries);
        let again = t.barycentric_in(&queries, &found.cells).unwrap();
        assert!(again.iter().zip(&found.coordinates).all(|(x, y)| x == y || x.is_nan() && y.is_nan()));
        let maps = t.transforms();
        // A cell that does not contain the query, too.
        let first = t.barycentric_in(&queries, &vec![0; queries.len()]).unwrap();
        for (i, &q) in queries.iter().enumerate() {
            for (cell, expected) in [(found.cells[i], &found.coordinates), (0, &first)] {
                if cell == NONE {
                    continue;
                }
                let map = &maps[cell as usize * (P::DIM + 1)..][..=P::DIM];
                let expected = &expected[i * (P::DIM + 1)..][..=P::DIM];
                let (mut rest, mut largest) = (1.0, 1.0f64);
                for axis in 0..P::DIM {
                    let own = map[axis].dot(q - map[P::DIM]);
                    rest -= own;
                    largest = largest.max(own.abs());
                    assert!((own - expected[axis]).abs() < 1e-9 * largest, "{own} {expected:?}");
                }
                assert!((rest - expected[P::DIM]).abs() < 1e-9 * largest, "{rest} {expected:?}");
            }
        }
    }
}
both!(
    transforms_of_triangles_give_barycentric_coordinates,
    transforms_of_tetrahedra_give_barycentric_coordinates,
    transforms_give_barycentric_coordinates
);

fn gradients_of_linear_functions_are_constant<P: Dimension + Coordinates>() {
    let points = Draw(4).uniform::<P>(150);
    let t = made(&points);
    let values: Vec<f64> = points.iter().flat_map(|&p| [linear(p), 5.0]).collect();
    let gradients = t.gradients(&values, 2).unwrap();
    assert_eq!(gradients.len(), t.cells().len() * P::DIM * 2);
    for cell in gradients.chunks_exact(P::DIM * 2) {
        for (axis, row) in cell.chunks_exact(2).enumerate() {
            assert!((row[0] - (axis as f64 + 0.7)).abs() < 1e-8 && row[1].abs() < 1e-8, "{cell:?}");
        }
    }
    let error = t.gradients(&values, 3).unwrap_err();
    assert_eq!(error, QueryError::Values { given: 300, columns: 3, points: 150 });
    let queries = [points[0], points[1]];
    assert_eq!(t.barycentric_in(&queries, &[0]).unwrap_err(), QueryError::Cells { given: 1, queries: 2 });
    let error = t.barycentric_in(&queries, &[0, 1 << 20]).unwrap_err();
    assert!(matches!(error, QueryError::NoCell { at: 1, .. }) && error.code() == Code::Usage, "{error}");
    let outside = t.barycentric_in(&queries, &[NONE, NONE]).unwrap();
    assert!(outside.iter().all(|x| x.is_nan()));
}
both!(
    gradients_of_linear_functions_are_constant_in_the_plane,
    gradients_of_linear_functions_are_constant_in_space,
    gradients_of_linear_functions_are_constant
);

/// A query far outside has the coordinates of the linear extension.
#[test]
fn coordinates_of_a_far_query_are_exact() {
    let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(glam::DVec2::from);
    let t = made(&points);
    let far = t.barycentric_in(&[glam::DVec2::new(2e9, -1e9)], &[0]).unwrap();
    assert_eq!(far, [1.0 - 1e9, 2e9, -1e9]);
}

fn edges_and_radii_fit_cells<P: Dimension + Coordinates>() {
    let points = Draw(5).uniform::<P>(120);
    let t = made(&points);
    let mut expected: Vec<[u32; 2]> = Vec::new();
    for row in t.cells() {
        let row = row.as_ref();
        let pairs = row.iter().flat_map(|&v| row.iter().map(move |&w| [v, w]));
        expected.extend(pairs.filter(|[v, w]| v < w));
    }
    expected.sort_unstable();
    expected.dedup();
    assert_eq!(t.edges(), expected);
    let (centres, radii, values) = (t.circumcentres(), t.circumradii(), t.alpha_values());
    for (cell, row) in t.cells().iter().enumerate() {
        let radius = (t.point(row.as_ref()[1]) - centres[cell]).norm2().sqrt();
        assert!((radius - radii[cell]).abs() <= 1e-9 * radius.max(1.0) * radius, "{radius} {}", radii[cell]);
        assert!((radii[cell] * radii[cell] - values[cell]).abs() <= 1e-14 * values[cell]);
    }
    let (regions, on_hull) = (t.voronoi_regions().unwrap(), t.hull());
    for v in 0..points.len() as u32 {
        let around =
            (0u32..).zip(t.cells()).filter(|(_, row)| row.as_ref().contains(&v)).map(|(cell, _)| cell);
        let is_open = on_hull.iter().any(|facet| facet.as_ref().contains(&v));
        let expected: Vec<u32> = is_open.then_some(NONE).into_iter().chain(around).collect();
        assert_eq!(regions.row(v as usize), expected);
    }
}
both!(edges_and_radii_fit_triangles, edges_and_radii_fit_tetrahedra, edges_and_radii_fit_cells);

/// The mean of the centroids of the parts of a box, weighted by their volumes, is the middle of the box. In a grid,
/// each inner point is the centroid of its cell.
fn centroids_balance<P: Dimension + Coordinates>() {
    let (low, high) = (P::splat(-0.5), P::splat(1.25));
    for points in [Draw(6).uniform::<P>(100), Draw(6).grid(60, 2)] {
        let t = made(&points);
        let (volumes, centroids) =
            (t.voronoi_volumes_in(low, high).unwrap(), t.voronoi_centroids_in(low, high).unwrap());
        let mut sum = P::default();
        for (v, (&volume, &centroid)) in volumes.iter().zip(&centroids).enumerate() {
            if t.vertex_cell[v] == NONE {
                assert!(volume == 0.0 && centroid.coord(0).is_nan());
            } else {
                sum = sum + centroid * volume;
            }
        }
        let whole = 1.75f64.powi(P::DIM as i32);
        (0..P::DIM).for_each(|axis| assert!((sum.coord(axis) - 0.375 * whole).abs() < 1e-12, "{sum:?}"));
        let (unbounded, all) = (t.voronoi_centroids().unwrap(), t.voronoi_volumes().unwrap());
        for v in 0..points.len() {
            if all[v] > 0.0 && (all[v] - volumes[v]).abs() < 1e-12 {
                assert!((unbounded[v] - centroids[v]).norm2() < 1e-16, "{v}");
            }
        }
    }
    let grid = whole_grid::<P>(4);
    let t = made(&grid);
    for (&p, centroid) in grid.iter().zip(t.voronoi_centroids().unwrap()) {
        let is_inner = (0..P::DIM).all(|axis| [1.0, 2.0].contains(&p.coord(axis)));
        assert_eq!(is_inner, !centroid.coord(0).is_nan());
        assert!(!is_inner || (p - centroid).norm2() < 1e-28);
    }
}
both!(centroids_balance_in_the_plane, centroids_balance_in_space, centroids_balance);

/// Cells of a grid that is moved a little, whose numerators and triangles cancel.
#[test]
fn flat_cells_have_exact_values() {
    let cell = [
        [8.4e-13, 1.000_000_000_000_01, 2.3e-13],
        [1.1e-13, 2.000_000_000_000_72, 3.1e-13],
        [1.000_000_000_000_57, 1.000_000_000_000_05, 2.9e-13],
        [1.000_000_000_000_95, 2.000_000_000_000_91, 3.5e-13],
    ];
    let t = made(&cell.map(glam::DVec3::from));
    let (radius, value) = (t.circumradii()[0], t.alpha_filtration().cells[0]);
    assert!(
        (value - 9.506_521_721_634_071).abs() < 1e-12 && (radius * radius - value).abs() < 1e-13,
        "{value}"
    );
    // The squared radius of the facet, from exact fractions.
    let cell = [
        [6.4e-13, 2.7e-13, 4e-14],
        [1.000_000_000_000_02, 8.1e-13, 9.1e-13],
        [3.000_000_000_000_61, 7.3e-13, 5.4e-13],
        [9.4e-13, 1.000_000_000_000_82, 0.0],
        [8.6e-13, 3e-14, 1.000_000_000_000_73],
    ];
    let found = made(&cell.map(glam::DVec3::from)).alpha_filtration();
    let at = found.facets.iter().position(|facet| *facet == [0, 1, 2]).unwrap();
    assert!(
        (found.facet_values[at] / 1.552_339_720_922_287e24 - 1.0).abs() < 1e-14,
        "{}",
        found.facet_values[at]
    );
}
