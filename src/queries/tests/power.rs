use septet_core::spec::{Periodic, Workers};
use septet_core::{Outcome, Spec, triangulate};
use septet_geometry::coordinates::Coordinates;
use septet_geometry::site::Weighted;
use septet_meshing::space::Space;

use super::{Draw, both, made, run};
use crate::power::{Region, power_cells, power_centroids, power_volumes};
use crate::{Dimension, QueryError, clip};

/// A dimension with all that a test needs.
trait Both: Dimension + Space + Coordinates {
    fn weighted(sites: &[Weighted<Self>], spec: &Spec) -> Outcome;
}

impl Both for glam::DVec2 {
    fn weighted(sites: &[Weighted<Self>], spec: &Spec) -> Outcome {
        triangulate(sites, spec).unwrap()
    }
}

impl Both for glam::DVec3 {
    fn weighted(sites: &[Weighted<Self>], spec: &Spec) -> Outcome {
        triangulate(sites, spec).unwrap()
    }
}

fn sites<P: Dimension>(draw: &mut Draw, n: usize, largest: f64) -> Vec<Weighted<P>> {
    (0..n).map(|_| Weighted::new(draw.point(Draw::unit), largest * draw.unit())).collect()
}

/// The part of the cell of a site between two corners, cut by the bisectors to all translated sites.
fn by_all_pairs<P: Dimension>(sites: &[Weighted<P>], own: usize, (low, high): (P, P), shifts: &[P]) -> f64 {
    let (place, weight) = (sites[own].position(), weight(&sites[own]));
    let mut planes = Vec::new();
    for (other, site) in sites.iter().enumerate() {
        for &shift in shifts {
            let along = site.position() + shift - place;
            let length = along.norm2().sqrt();
            if length > 0.0 {
                planes.push((along / length, length / 2.0 + (weight - self::weight(site)) / (2.0 * length)));
            } else if other != own && self::weight(site) >= weight {
                return 0.0;
            }
        }
    }
    clip::measure(low - place, high - place, &planes).volume.max(0.0)
}

fn weight<P: Dimension>(site: &Weighted<P>) -> f64 {
    septet_geometry::point::Point::weight(site)
}

both!(power_cells_in_the_plane, power_cells_in_space, weighted_cells);

fn weighted_cells<P: Both>() {
    let mut draw = Draw(61);
    for (n, largest, scale) in [(40, 0.0, 1.0), (60, 0.05, 1.0), (300, 0.05, 1e-130), (80, 0.5, 1e120)] {
        let sites: Vec<Weighted<P>> = sites::<P>(&mut draw, n, largest)
            .iter()
            .map(|site| Weighted::new(site.position() * scale, weight(site) * scale * scale))
            .collect();
        let mut spec = Spec::default();
        spec.machine.workers = Workers::Count(1 + n as u32 % 3);
        let run = P::weighted(&sites, &spec);
        let [low, high] = [-0.25 * scale, 1.5 * scale].map(P::splat);
        let found = power_volumes(&sites, &run, Region::of_box(low, high)).unwrap();
        let whole = (1.75 * scale).powi(P::DIM as i32);
        if whole.is_finite() && whole > 0.0 {
            let sum: f64 = found.iter().sum();
            assert!((sum - whole).abs() < 1e-12 * whole, "{sum} {whole}");
            for (own, volume) in found.iter().enumerate() {
                let expected = by_all_pairs(&sites, own, (low, high), &[P::default()]);
                assert!((volume - expected).abs() < 1e-12 * whole, "{n}: {volume} {expected}");
            }
        }
        let cells = power_cells(&sites, &run, Region::of_box(low, high)).unwrap();
        for (cell, volume) in cells.iter().zip(&found) {
            assert!(*volume == 0.0 || !cell.corners.is_empty());
            let is_polyhedron = P::DIM == 2 || cell.corners.is_empty() || {
                // Each edge of a face is an edge of another face, in the other direction (Euler's formula counts them).
                let edges: usize = cell.faces.iter().map(Vec::len).sum();
                cell.corners.len() + cell.faces.len() == edges / 2 + 2
            };
            assert!(is_polyhedron, "{cell:?}");
        }
        assert_eq!(run.points.hidden.unwrap_or(0) > 0, largest > 0.0);
    }
}

both!(periodic_cells_in_the_plane, periodic_cells_in_space, periodic_cells);

fn periodic_cells<P: Both>() {
    let mut draw = Draw(67);
    for (n, largest) in [(1, 0.0), (2, 0.1), (7, 0.0), (50, 0.02), (200, 0.0)] {
        let sites = sites::<P>(&mut draw, n, largest);
        let periodic = Periodic::of_lengths(&vec![1.0; P::DIM]);
        let mut spec = Spec::default();
        spec.input.periodic = Some(periodic.clone());
        let run = P::weighted(&sites, &spec);
        let found = power_volumes(&sites, &run, Region::of_periods(&periodic)).unwrap();
        let sum: f64 = found.iter().sum();
        assert!((sum - 1.0).abs() < 1e-13, "{n}: {sum}");
        let shifts: Vec<P> = (0..3usize.pow(P::DIM as u32))
            .map(|code| {
                let mut shift = P::default();
                (0..P::DIM).for_each(|i| shift.set_coord(i, (code / 3usize.pow(i as u32) % 3) as f64 - 1.0));
                shift
            })
            .collect();
        for (own, volume) in found.iter().enumerate() {
            let around = |half: f64| sites[own].position() + P::splat(half);
            let expected = by_all_pairs(&sites, own, (around(-0.5), around(0.5)), &shifts);
            assert!((volume - expected).abs() < 1e-12, "{n}: {volume} {expected}");
        }
    }
}

/// Sites far from the box have the cells of their images in it.
#[test]
fn far_sites_in_a_row_fill_the_box() {
    let mut periodic = Periodic::of_lengths(&[1.0; 2]);
    periodic.wrap = true;
    let mut spec = Spec::default();
    spec.input.periodic = Some(periodic.clone());
    let row = [0.1, 1e6 + 0.4, 0.85].map(|x| Weighted::new(glam::DVec2::new(x, 0.5), 0.0));
    let run = triangulate(&row, &spec).unwrap();
    let region = Region::of_periods(&periodic);
    let volumes = power_volumes(&row, &run, region).unwrap();
    let middle = row[1].position().x - 1e6;
    let expected = [middle + 0.15, 0.75, 1.1 - middle].map(|width| width / 2.0);
    assert!(volumes.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{volumes:?} {expected:?}");
    assert!((volumes.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{volumes:?}");
    let centroids = power_centroids(&row, &run, region).unwrap();
    assert!((centroids[1].x - 1e6 - 0.4375).abs() < 1e-9, "{centroids:?}");
}

#[test]
fn partly_periodic_cells_fill_their_box() {
    let mut draw = Draw(71);
    let sites = sites::<glam::DVec3>(&mut draw, 100, 0.01);
    let periodic = Periodic::of(vec![Some(1.0), None, Some(1.0)]);
    let mut spec = Spec::default();
    spec.input.periodic = Some(periodic.clone());
    let run = triangulate(&sites, &spec).unwrap();
    let region = Region::of_periods(&periodic);
    assert_eq!(power_volumes(&sites, &run, region), Err(QueryError::EmptyBox { axis: 1 }));
    let region = region.between(glam::DVec3::ZERO, glam::DVec3::splat(3.0));
    let sum: f64 = power_volumes(&sites, &run, region).unwrap().iter().sum();
    assert!((sum - 3.0).abs() < 1e-12, "{sum}");
}

both!(voronoi_cells_of_the_plane, voronoi_cells_of_space, voronoi_cells);

/// Sites of equal weights have Voronoi cells.
fn voronoi_cells<P: Both>() {
    let points: Vec<P> = Draw(73).uniform(500);
    let expected = made(&points).voronoi_volumes_in(P::default(), P::splat(1.0)).unwrap();
    let sites: Vec<Weighted<P>> = points.iter().map(|&point| Weighted::new(point, 0.0)).collect();
    let region = Region::of_box(P::default(), P::splat(1.0));
    let found = power_volumes(&sites, &run(&points, 2), region).unwrap();
    for (a, b) in found.iter().zip(&expected) {
        assert!((a - b).abs() < 1e-13, "{a} {b}");
    }
    let other = Region::of_box(P::splat(0.5), P::splat(1.0));
    assert!(matches!(power_volumes(&sites, &run(&points, 1), other), Err(QueryError::OutsideBox { .. })));
    let given = power_volumes(&sites[1..], &run(&points, 1), region);
    assert_eq!(given, Err(QueryError::OtherPoints { given: 499, run: 500 }));
}

both!(centroids_in_the_plane, centroids_in_space, centroids);

/// The moments of the cells add up to that of the box.
fn centroids<P: Both>() {
    let mut draw = Draw(67);
    for (n, largest) in [(30, 0.0), (60, 0.1)] {
        let sites = sites::<P>(&mut draw, n, largest);
        let run = P::weighted(&sites, &Spec::default());
        let region = Region::of_box(P::splat(-0.5), P::splat(1.25));
        let volumes = power_volumes(&sites, &run, region).unwrap();
        let centroids = power_centroids(&sites, &run, region).unwrap();
        let whole = 1.75f64.powi(P::DIM as i32);
        for axis in 0..P::DIM {
            let moments = volumes.iter().zip(&centroids).filter(|(volume, _)| **volume > 0.0);
            let sum: f64 = moments.map(|(volume, centroid)| volume * centroid.coord(axis)).sum();
            assert!((sum / whole - 0.375).abs() < 1e-12, "{sum}");
        }
        let hidden = &run.left_out.hidden;
        assert!(hidden.iter().all(|&site| centroids[site as usize].coord(0).is_nan()));
        let t =
            crate::Tessellation::regular(&sites.iter().map(|site| site.position()).collect::<Vec<P>>(), &run);
        let t = t.unwrap();
        for cell in t.cells() {
            assert!(cell.as_ref().iter().all(|&v| !hidden.contains(&u64::from(v))));
        }
        let all: Vec<P> = t.points();
        assert!(t.locate(&all).iter().all(|&cell| cell != crate::NONE));
        assert!(largest == 0.0 || crate::Tessellation::new(&all, &run).is_err());
    }
}
