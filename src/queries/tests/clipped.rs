//! Diagrams in a box: closed cells whose faces add up, and the sides of the box.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use septet_geometry::coordinates::Coordinates;

use super::{Draw, made};
use crate::clipped::side;
use crate::{Dimension, Tessellation};

fn check<P: Dimension + Coordinates>(points: &[P], low: P, high: P) {
    let tessellation: Tessellation<P> = made(points);
    let found = tessellation.voronoi_in(low, high).unwrap();
    let volumes = tessellation.voronoi_volumes_in(low, high).unwrap();
    assert!(found.points.is_sorted_by_key(|row| row.map(u32::cast_signed)));
    // A cell is the cone over its faces: the sum of area times height over the dimension.
    let mut sums = vec![0.0; points.len()];
    let mut sides = BTreeMap::new();
    for (row, &area) in found.points.iter().zip(&found.areas) {
        let at = points[row[1] as usize];
        if row[0] > side(6) {
            let k = (u32::MAX - row[0]) as usize;
            let wall = if k.is_multiple_of(2) { low } else { high };
            sums[row[1] as usize] += area * (wall.coord(k / 2) - at.coord(k / 2)).abs();
            *sides.entry(k).or_insert(0.0) += area;
        } else {
            let half = (points[row[0] as usize] - at).norm2().sqrt() / 2.0;
            for &v in row {
                sums[v as usize] += area * half;
            }
        }
    }
    for (sum, volume) in sums.iter().zip(&volumes) {
        assert!((sum / P::DIM as f64 - volume).abs() < 1e-12, "{sum} and {volume}");
    }
    let extent = high - low;
    for (k, area) in sides {
        let others = (0..P::DIM).filter(|&axis| axis != k / 2);
        let expected: f64 = others.map(|axis| extent.coord(axis)).product();
        assert!((area - expected).abs() < 1e-12, "side {k}: {area} and {expected}");
    }
    for row in 0..found.corners.len() {
        let [v, w] = found.points[row];
        for &corner in found.corners.row(row) {
            let x = found.vertices[corner as usize];
            let distance = |v: u32| (x - points[v as usize]).norm2();
            assert!(v > side(6) || (distance(v) - distance(w)).abs() < 1e-9);
        }
    }
}

#[test]
fn faces_of_cells_in_a_box_close() {
    let mut draw = Draw(5);
    for _ in 0..5 {
        let plane: Vec<DVec2> = (0..200).map(|_| draw.point(Draw::unit)).collect();
        check(&plane, DVec2::splat(-0.1), DVec2::new(1.0, 1.5));
        let space: Vec<DVec3> = (0..200).map(|_| draw.point(Draw::unit)).collect();
        check(&space, DVec3::splat(-0.1), DVec3::new(1.0, 1.5, 2.0));
        let grid: Vec<DVec3> = draw.grid(100, 4);
        check(&grid, DVec3::splat(-0.5), DVec3::splat(4.5));
    }
}

#[test]
fn corners_of_cells_are_shared() {
    let mut draw = Draw(8);
    let points: Vec<DVec3> = (0..300).map(|_| draw.point(Draw::unit)).collect();
    let found = made(&points).voronoi_in(DVec3::ZERO, DVec3::ONE).unwrap();
    // Euler: vertices - edges + faces - cells = 1, and in general position four edges meet at a vertex of the complex, of which
    // the corners of the box have three.
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for row in 0..found.corners.len() {
        let corners = found.corners.row(row);
        let next = corners.iter().cycle().skip(1);
        edges.extend(corners.iter().zip(next).map(|(&a, &b)| [a.min(b), a.max(b)]));
    }
    edges.sort_unstable();
    edges.dedup();
    let (vertices, faces) = (found.vertices.len() as i64, found.points.len() as i64);
    assert_eq!(vertices - edges.len() as i64 + faces - 300, 1);
}
