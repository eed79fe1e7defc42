use glam::{DVec2, DVec3};
use septet_geometry::coordinates::Coordinates;

use super::{Draw, both, made, whole_grid, whole_sets};
use crate::{Dimension, QueryError};

/// The squared radius of the smallest ball through the points and its centre, by a linear system in the span of the points.
fn ball<P: Dimension>(face: &[P]) -> (P, f64) {
    let base = face[0];
    let rel: Vec<P> = face[1..].iter().map(|&p| p - base).collect();
    let n = rel.len();
    let mut rows: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| rel[i].dot(rel[j])).chain([rel[i].norm2() / 2.0]).collect()).collect();
    for i in 0..n {
        let pivot = (i..n).max_by(|&a, &b| rows[a][i].abs().total_cmp(&rows[b][i].abs())).unwrap();
        rows.swap(i, pivot);
        for j in (0..n).filter(|&j| j != i) {
            let factor = rows[j][i] / rows[i][i];
            (0..=n).for_each(|k| rows[j][k] -= factor * rows[i][k]);
        }
    }
    let centre = (0..n).fold(base, |sum, i| sum + rel[i] * (rows[i][n] / rows[i][i]));
    (centre, (centre - base).norm2())
}

both!(values_in_the_plane, values_in_space, values);

/// Every value against its definition, with all points instead of the neighbours.
fn values<P: Dimension + Coordinates>() {
    let mut sets = whole_sets::<P>();
    sets.extend([Draw(47).uniform(60), Draw(53).uniform(10)]);
    for points in sets {
        let t = made(&points);
        let filtration = t.alpha_filtration();
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-7 * b;
        for (cell, &value) in t.cells().iter().zip(&filtration.cells) {
            let face: Vec<P> = cell.as_ref().iter().map(|&v| points[v as usize]).collect();
            assert!(close(value, ball(&face).1));
        }
        let cells: Vec<(Vec<u32>, f64)> = t
            .cells()
            .iter()
            .map(|cell| cell.as_ref().to_vec())
            .zip(filtration.cells.iter().copied())
            .collect();
        let facets: Vec<(Vec<u32>, f64)> = filtration
            .facets
            .iter()
            .map(|row| row.as_ref().to_vec())
            .zip(filtration.facet_values.iter().copied())
            .collect();
        let edges: Vec<(Vec<u32>, f64)> = filtration
            .edges
            .iter()
            .map(|row| row.to_vec())
            .zip(filtration.edge_values.iter().copied())
            .collect();
        assert!(
            facets.is_sorted_by_key(|(row, _)| row.clone()) && edges.is_sorted_by_key(|(row, _)| row.clone())
        );
        let mut levels = vec![(&facets, &cells)];
        if P::DIM == 3 {
            levels.push((&edges, &facets));
        } else {
            assert_eq!(edges, facets);
        }
        for (faces, above) in levels {
            for (face, value) in faces {
                let (centre, radius2) = ball(&face.iter().map(|&v| points[v as usize]).collect::<Vec<P>>());
                let is_empty = points.iter().all(|&p| (p - centre).norm2() >= radius2 * (1.0 - 1e-10));
                let at = above.iter().filter(|(row, _)| face.iter().all(|v| row.contains(v)));
                let least = at.map(|(_, value)| *value).fold(f64::INFINITY, f64::min);
                assert!(*value <= least);
                assert!(
                    close(*value, if is_empty { radius2 } else { least }),
                    "{face:?} {value} {radius2} {least}"
                );
            }
        }
    }
}

both!(shapes_in_the_plane, shapes_in_space, shapes);

/// The boundary is closed, its cells have its volume by the divergence theorem, and radii grow monotonically.
fn shapes<P: Dimension + Coordinates>() {
    let points: Vec<P> = Draw(59).uniform(300);
    let t = made(&points);
    let mut before = 0.0;
    for radius in [0.0, 0.03, 0.1, 0.15, 0.2, 0.5, 1e9, f64::INFINITY] {
        let shape = t.alpha_shape(radius).unwrap();
        assert!(shape.volume >= before);
        before = shape.volume;
        let mut sides: Vec<[u32; 2]> = Vec::new();
        let mut volume = 0.0;
        for facet in &shape.boundary {
            let ids = facet.as_ref();
            let at: Vec<P> = ids.iter().map(|&v| points[v as usize]).collect();
            volume += if P::DIM == 2 {
                P::hull_normal(&[at[0]]).dot(at[1]) / 2.0
            } else {
                P::hull_normal(&[at[0], at[1]]).dot(at[2]) / 6.0
            };
            match *ids {
                [a, b] => sides.extend([[a, a], [b, u32::MAX - b]]),
                [a, b, c] => sides.extend([[a, b], [b, c], [c, a]]),
                _ => unreachable!(),
            }
        }
        assert!((volume - shape.volume).abs() < 1e-12, "{volume} {}", shape.volume);
        // In space, every edge of the boundary has as many triangles on both sides. In the plane, every vertex has as many edges
        // that start and end at it.
        if P::DIM == 3 {
            let mut back: Vec<[u32; 2]> = sides.iter().map(|&[a, b]| [b, a]).collect();
            sides.sort_unstable();
            back.sort_unstable();
            assert_eq!(sides, back);
        } else {
            for v in 0..points.len() as u32 {
                let count = |side: [u32; 2]| sides.iter().filter(|other| **other == side).count();
                assert_eq!(count([v, v]), count([v, u32::MAX - v]));
            }
        }
    }
    let whole = t.alpha_shape(1e9).unwrap();
    assert!(whole.cells.iter().all(|is_in| *is_in) && whole.singular.is_empty());
    assert_eq!(whole.boundary, t.hull());
    assert_eq!(t.alpha_shape(-1.0).err(), Some(QueryError::Radius));
    assert_eq!(t.alpha_shape(f64::NAN).err(), Some(QueryError::Radius));
}

/// Values by hand: a right triangle, whose longest edge has all vertices on its ball; and a flat one, whose longest edge is not
/// Gabriel.
#[test]
fn triangles_have_known_values() {
    let values = |apex: DVec2| made(&[DVec2::ZERO, DVec2::new(4.0, 0.0), apex]).alpha_filtration();
    let right = values(DVec2::new(0.0, 3.0));
    assert_eq!((right.cells, right.facet_values), (vec![6.25], vec![4.0, 2.25, 6.25]));
    let flat = values(DVec2::new(2.0, 1.0));
    assert_eq!(flat.edges, [[0, 1], [0, 2], [1, 2]]);
    assert_eq!((flat.cells, flat.facet_values), (vec![6.25], vec![6.25, 1.25, 1.25]));
    let cube = made(&whole_grid::<DVec3>(2)).alpha_filtration();
    assert!(cube.cells.iter().all(|value| *value == 0.75));
    assert!(cube.edge_values.iter().all(|value| [0.25, 0.5, 0.75].contains(value)));
}
