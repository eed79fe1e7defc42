use glam::{DVec2, DVec3};
use septet_geometry::coordinates::Coordinates;

use super::{Draw, both, made, whole_grid, whole_sets};
use crate::{Dimension, NONE, QueryError, clip};

both!(volumes_in_the_plane, volumes_in_space, volumes);

/// Volumes add up to the box, and each is that of the box cut by the bisectors to all points.
fn volumes<P: Dimension + Coordinates>() {
    let mut sets = whole_sets::<P>();
    sets.extend([Draw(23).uniform(2000), Draw(29).uniform(100)]);
    for points in sets {
        let t = made(&points);
        let (mut low, mut high) = (points[0], points[0]);
        for &p in &points {
            (low, high) = (crate::tessellation::least(low, p), crate::tessellation::most(high, p));
        }
        for margin in [0.0, 0.1, 30.0] {
            let (low, high) = (low - P::splat(margin), high + P::splat(margin));
            let whole: f64 = (0..P::DIM).map(|i| high.coord(i) - low.coord(i)).product();
            let volumes = t.voronoi_volumes_in(low, high).unwrap();
            let sum: f64 = volumes.iter().sum();
            assert!((sum - whole).abs() < 1e-12 * whole, "{sum} {whole}");
            let duplicates: Vec<u32> = t.duplicates().iter().map(|pair| pair[0]).collect();
            for (v, &site) in points.iter().enumerate().step_by(1 + points.len() / 50) {
                if duplicates.contains(&(v as u32)) {
                    assert_eq!(volumes[v], 0.0);
                    continue;
                }
                let mut planes: Vec<(P, f64)> = Vec::new();
                for &p in points.iter().filter(|&&p| p != site) {
                    let length = (p - site).norm2().sqrt();
                    planes.push(((p - site) / length, length / 2.0));
                }
                let all = clip::measure(low - site, high - site, &planes).volume;
                assert!((volumes[v] - all).abs() < 1e-12 * whole, "{} {all}", volumes[v]);
            }
        }
    }
}

both!(moved_grids_of_the_plane, moved_grids_of_space, moved_grids);

/// Inner cells of a grid have the volume 1, also if the grid is moved a little.
fn moved_grids<P: Dimension + Coordinates>() {
    let mut draw = Draw(31);
    let side = 7;
    for step in [0.0, 1e-16, 1e-15, 1e-14, 1e-12, 1e-9, 1e-6] {
        let grid: Vec<P> = whole_grid(side);
        let points: Vec<P> = grid.iter().map(|&p| p + draw.point::<P>(|draw| step * draw.unit())).collect();
        let t = made(&points);
        let [low, high] = [-0.5, side as f64 - 0.5].map(P::splat);
        let volumes = t.voronoi_volumes_in(low, high).unwrap();
        let whole = (side as f64).powi(P::DIM as i32);
        assert!((volumes.iter().sum::<f64>() - whole).abs() < 1e-12 * whole, "{step}");
        let free = t.voronoi_volumes().unwrap();
        for (v, &p) in grid.iter().enumerate() {
            assert!((volumes[v] - 1.0).abs() < 20.0 * step + 1e-12, "{step} {}", volumes[v]);
            let is_inner = (0..P::DIM).all(|i| p.coord(i) > 0.0 && p.coord(i) < (side - 1) as f64);
            // A point of the boundary may be moved into the hull.
            assert!(step > 0.0 || free[v].is_finite() == is_inner, "{p:?}");
            assert!(!is_inner || (free[v] - 1.0).abs() < 20.0 * step + 1e-12, "{step} {}", free[v]);
        }
    }
}

both!(ridges_of_the_plane, ridges_of_space, ridges);

/// Bounded cells are made of pyramids over their ridges. Rings lead from cell to cell around their edge.
fn ridges<P: Dimension + Coordinates>() {
    for points in [whole_grid::<P>(5), Draw(37).uniform(300), Draw(41).grid(80, 4)] {
        let t = made(&points);
        let ridges = t.ridges().unwrap();
        let around = t.vertex_neighbours();
        let edges =
            (0..points.len() as u32).flat_map(|v| around.row(v as usize).iter().map(move |&w| [v, w]));
        assert!(edges.filter(|[v, w]| v < w).eq(ridges.points.iter().copied()));
        let mut sums = vec![0.0; points.len()];
        for (i, &edge) in ridges.points.iter().enumerate() {
            let [a, b]: [P; 2] = edge.map(|v| points[v as usize]);
            let length = (a - b).norm2().sqrt();
            for v in edge {
                sums[v as usize] += ridges.areas[i] * length / (2 * P::DIM) as f64;
            }
            let ring: &[u32] = ridges.vertices.row(i);
            let with = |cell: &P::Cell| edge.iter().all(|v| cell.as_ref().contains(v));
            let is_open = ring[0] == NONE;
            assert_eq!(ring.len() - usize::from(is_open), t.cells().iter().filter(|cell| with(cell)).count());
            assert_eq!(ridges.areas[i].is_infinite(), is_open);
            let closed = ring[ring.len() - 1] == NONE || is_open || P::DIM == 2;
            let last = [ring[ring.len() - 1], ring[0]];
            let steps =
                ring.windows(2).map(|pair: &[u32]| [pair[0], pair[1]]).chain((!closed).then_some(last));
            for [a, b] in steps.filter(|[a, _]| *a != NONE) {
                assert!(with(&t.cells()[a as usize]) && t.neighbours()[a as usize].as_ref().contains(&b));
            }
        }
        for (sum, volume) in sums.into_iter().zip(t.voronoi_volumes().unwrap()) {
            assert!(sum == volume || (sum - volume).abs() < 1e-9 * volume, "{sum} {volume}");
        }
        // In a large box, bounded ridges have the same areas, and unbounded ones finite areas.
        let [low, high] = [-1e4, 1e4].map(P::splat);
        let clipped = t.ridges_in(low, high).unwrap();
        assert_eq!((&clipped.points, &clipped.vertices), (&ridges.points, &ridges.vertices));
        for (own, all) in clipped.areas.iter().zip(&ridges.areas) {
            assert!(own.is_finite() && (all.is_infinite() || own - all < 1e-7 * (1.0 + all)));
        }
    }
}

#[test]
fn centres_have_the_distance_of_all_corners() {
    let points: Vec<DVec3> = Draw(43).uniform(400);
    let t = made(&points);
    for (cell, centre) in t.cells().iter().zip(t.circumcentres()) {
        let [a, rest @ ..] = cell.map(|v| points[v as usize].distance(centre));
        assert!(rest.into_iter().all(|b| (a - b).abs() < 1e-10 * (1.0 + a)), "{a} {rest:?}");
    }
}

#[test]
fn boxes_are_checked() {
    let points: Vec<DVec2> = whole_grid(3);
    let t = made(&points);
    let volumes = |low: DVec2, high: DVec2| t.voronoi_volumes_in(low, high).err();
    assert_eq!(volumes(DVec2::ZERO, DVec2::splat(2.0)), None);
    assert_eq!(volumes(DVec2::ZERO, DVec2::new(2.0, 0.0)), Some(QueryError::EmptyBox { axis: 1 }));
    assert_eq!(volumes(DVec2::NAN, DVec2::ONE), Some(QueryError::EmptyBox { axis: 0 }));
    assert_eq!(volumes(DVec2::ZERO, DVec2::new(1.0, 3.0)), Some(QueryError::OutsideBox { index: 2 }));
}
