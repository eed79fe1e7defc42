//! Tests of constrained triangulations: each is compared with its domain.

use glam::DVec3;

use super::{Wish, constrain, constrain_and_refine};
use crate::check::check;
use crate::conformity;
use crate::domain::Domain;
use crate::generate::{Alone, GenerationError, Rules};
use crate::input::{DomainKind, Input, InputFacet};
use crate::mesh::Mesh;

const CUBE: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn corners(low: DVec3, high: DVec3) -> Vec<DVec3> {
    let side = |i: usize, axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
    (0..8).map(|i| DVec3::new(side(i, 0), side(i, 1), side(i, 2))).collect()
}

fn domain(input: &Input<DVec3>) -> Domain<DVec3> {
    check(input).unwrap()
}

fn made(domain: &Domain<DVec3>) -> Mesh<DVec3> {
    let size = |_: DVec3| 1.0;
    let rules = Rules { size: &size, lipschitz: 0.5, seed: 1, most: 1 << 20 };
    let mesh = constrain(domain, rules, &mut Alone { seed: 1 });
    let mesh = mesh.map_err(|e: GenerationError<_>| format!("{e:?}")).unwrap();
    let mesh = mesh.into_mesh(domain);
    let found = conformity::check(domain, &mesh);
    assert!(found.is_clean(), "{:?}", &found.defects[..found.defects.len().min(5)]);
    mesh
}

fn complex(points: Vec<DVec3>, facets: &[&[u32]]) -> Input<DVec3> {
    let facet = |f: &&[u32]| InputFacet { polygons: vec![f.to_vec()], holes: Vec::new(), marker: 0 };
    Input { facets: facets.iter().map(facet).collect(), ..Input::new(DomainKind::Complex, points) }
}

#[test]
fn a_cube_needs_no_points() {
    let faces: Vec<&[u32]> = CUBE.iter().map(<[u32; 4]>::as_slice).collect();
    let domain = domain(&complex(corners(DVec3::ZERO, DVec3::ONE), &faces));
    let mesh = made(&domain);
    assert_eq!(mesh.points.len(), 8);
    assert!((5..=6).contains(&mesh.cells.len()), "{}", mesh.cells.len());
}

/// Schoenhardt's polyhedron has no triangulation with its vertices alone.
#[test]
fn the_twisted_prism_receives_points() {
    let at = |turn: f64, z: f64| {
        (0..3).map(move |i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 3.0 + turn;
            DVec3::new(angle.cos(), angle.sin(), z)
        })
    };
    let points: Vec<DVec3> = at(0.0, 0.0).chain(at(std::f64::consts::FRAC_PI_6, 1.0)).collect();
    let mut faces = vec![vec![2, 1, 0], vec![3, 4, 5]];
    for i in 0..3u32 {
        let j = (i + 1) % 3;
        // The diagonals bend inwards.
        faces.push(vec![i, j, i + 3]);
        faces.push(vec![j, j + 3, i + 3]);
    }
    let volume = |faces: &[Vec<u32>]| -> f64 {
        let p = |v: u32| points[v as usize];
        faces.iter().map(|f| p(f[0]).cross(p(f[1])).dot(p(f[2]))).sum()
    };
    let mut other = faces[..2].to_vec();
    for i in 0..3u32 {
        let j = (i + 1) % 3;
        other.push(vec![i, j, j + 3]);
        other.push(vec![i, j + 3, i + 3]);
    }
    let bent = if volume(&faces) < volume(&other) { faces } else { other };
    let mesh = made(&domain(&Input::surface(points, bent)));
    assert!(mesh.points.len() > 6, "{}", mesh.points.len());
}

/// A thin plate crosses the balls of the long edges of a box.
#[test]
fn facets_without_room_are_recovered() {
    let mut points = corners(DVec3::ZERO, DVec3::new(4.0, 4.0, 1.0));
    points.extend(corners(DVec3::new(0.3, 0.7, 0.013), DVec3::new(3.7, 3.1, 0.017)));
    let inner: Vec<Vec<u32>> = CUBE.iter().map(|f| f.iter().map(|v| v + 8).collect()).collect();
    let mut faces: Vec<&[u32]> = CUBE.iter().map(<[u32; 4]>::as_slice).collect();
    faces.extend(inner.iter().map(Vec::as_slice));
    let mesh = made(&domain(&complex(points, &faces)));
    let regions: std::collections::BTreeSet<u32> = mesh.regions.iter().copied().collect();
    assert_eq!(regions.len(), 2);
}

/// Refines a domain to a size and checks it.
fn refined(domain: &Domain<DVec3>, size: f64, divides: bool) -> Mesh<DVec3> {
    let size = move |_: DVec3| size;
    let rules = Rules { size: &size, lipschitz: 0.5, seed: 1, most: 1 << 20 };
    let wish = Wish { ratio: 1.46, divides };
    let made = constrain_and_refine(domain, rules, wish, &mut Alone { seed: 1 });
    let mesh = made.map_err(|e| format!("{e:?}")).unwrap().0.into_mesh(domain);
    let found = conformity::check(domain, &mesh);
    assert!(found.is_clean(), "{:?}", &found.defects[..found.defects.len().min(5)]);
    mesh
}

#[test]
fn a_kept_cube_keeps_its_faces() {
    let faces: Vec<&[u32]> = CUBE.iter().map(<[u32; 4]>::as_slice).collect();
    let domain = domain(&complex(corners(DVec3::ZERO, DVec3::ONE), &faces));
    let mesh = refined(&domain, 0.2, false);
    let inner = mesh.carriers.iter().filter(|c| **c == crate::mesh::Carrier::Volume).count();
    assert!(inner > 0 && mesh.points.len() == inner + 8, "{inner} of {}", mesh.points.len());
    assert_eq!(mesh.faces.len(), 12);
}

/// Without small angles, every cell becomes small and round enough.
#[test]
fn a_refined_cube_has_small_cells() {
    let faces: Vec<&[u32]> = CUBE.iter().map(<[u32; 4]>::as_slice).collect();
    let domain = domain(&complex(corners(DVec3::ZERO, DVec3::ONE), &faces));
    let mesh = refined(&domain, 0.2, true);
    for &cell in &mesh.cells {
        let p = [0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize]);
        let radius2 = septet_geometry::measure::circumradius2(&p);
        assert!(radius2.sqrt() <= 0.2 * (1.0 + 1e-9), "{radius2}");
        assert!(septet_geometry::measure::radius_edge_ratio(&p) <= 1.46 * (1.0 + 1e-9), "{p:?}");
    }
    assert!((400..4000).contains(&mesh.cells.len()), "{}", mesh.cells.len());
    assert!(mesh.carriers.iter().any(|c| matches!(c, crate::mesh::Carrier::Segment(_))));
    assert!(mesh.carriers.iter().any(|c| matches!(c, crate::mesh::Carrier::Facet(_))));
}

/// Several fans of cells meet at the common edge, which is divided.
#[test]
fn cubes_that_share_an_edge_are_refined() {
    let (low, high) = (DVec3::ZERO, DVec3::ONE);
    let mut points = corners(low, high);
    points.extend(corners(DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 2.0, 1.0)));
    let second = |v: u32| match v {
        0 => 3,
        4 => 7,
        v => v + 8,
    };
    let mut faces: Vec<Vec<u32>> = CUBE.iter().map(|f| f.to_vec()).collect();
    faces.extend(CUBE.iter().map(|f| f.map(second).to_vec()));
    let used: Vec<u32> = (0..16).filter(|v| ![8, 12].contains(v)).collect();
    let number = |v: u32| used.iter().position(|&u| u == v).unwrap() as u32;
    let faces: Vec<Vec<u32>> = faces.iter().map(|f| f.iter().map(|&v| number(v)).collect()).collect();
    let points: Vec<DVec3> = used.iter().map(|&v| points[v as usize]).collect();
    let rows: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    let domain = domain(&complex(points, &rows));
    let mesh = refined(&domain, 0.3, true);
    let on_edge = mesh.points.iter().filter(|p| p.x == 1.0 && p.y == 1.0).count();
    assert!(on_edge > 2, "{on_edge}");
}

/// Two planes that meet at a small angle end refinement.
#[test]
fn a_wedge_ends() {
    let points = vec![
        DVec3::ZERO,
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(1.0, 0.02, 0.0),
        DVec3::new(0.0, 0.0, 1.0),
        DVec3::new(1.0, 0.0, 1.0),
        DVec3::new(1.0, 0.02, 1.0),
    ];
    let faces: [&[u32]; 5] = [&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[0, 2, 5, 3]];
    let mesh = refined(&domain(&complex(points, &faces)), 10.0, true);
    assert!(mesh.cells.len() < 20_000, "{}", mesh.cells.len());
}

#[test]
fn the_plane_is_not_supported() {
    let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| glam::DVec2::new(x, y));
    let mut input = Input::new(DomainKind::Complex, points.to_vec());
    input.segments =
        [[0, 1], [1, 2], [2, 0]].map(|ends| crate::input::InputSegment { ends, marker: 0 }).to_vec();
    let domain = check(&input).unwrap();
    let size = |_: glam::DVec2| 1.0;
    let rules = Rules { size: &size, lipschitz: 0.5, seed: 1, most: 1 << 20 };
    let failure = constrain(&domain, rules, &mut Alone { seed: 1 }).unwrap_err();
    assert!(matches!(failure, GenerationError::Unsupported(_)));
}

/// Returns the constrained triangulation of a box with a triangle, whose corners are the first of some points, and the
/// other points. Also returns the number of triangles that cells crossed.
fn with_triangle(inner: impl IntoIterator<Item = DVec3>) -> (Mesh<DVec3>, u64) {
    let mut points = corners(DVec3::splat(-4.0), DVec3::splat(4.0));
    points.extend(inner);
    let mut faces: Vec<&[u32]> = CUBE.iter().map(<[u32; 4]>::as_slice).collect();
    faces.push(&[8, 9, 10]);
    let domain = domain(&complex(points, &faces));
    let rules = Rules { size: &|_| 1.0, lipschitz: 0.5, seed: 1, most: 1 << 20 };
    let made = constrain(&domain, rules, &mut Alone { seed: 1 }).map_err(|e| format!("{e:?}")).unwrap();
    let missing = made.stages.iter().find(|s| s.name == "recovery").map_or(0, |s| s.candidates);
    let mesh = made.into_mesh(&domain);
    let found = conformity::check(&domain, &mesh);
    assert!(found.is_clean(), "{:?}", &found.defects[..found.defects.len().min(5)]);
    (mesh, missing)
}

/// Returns a triangle in the plane z = 0.
fn triangle(radius: f64) -> impl Iterator<Item = DVec3> {
    let at = move |i: u32| (glam::DVec2::from_angle(f64::from(i) * 2.1) * radius).extend(0.0);
    (0..3).map(at)
}

/// The edge between two points near the middle of a triangle passes through it.
#[test]
fn a_triangle_that_an_edge_crosses_is_recovered() {
    let tips = [DVec3::new(0.0, 0.0, 0.2), DVec3::new(0.1, 0.0, -0.2)];
    let (mesh, missing) = with_triangle(triangle(1.0).chain(tips));
    assert_eq!((mesh.points.len(), missing), (13, 1));
}

/// Many edges between scattered points pass through a triangle, so gift wrapping fills large cavities.
#[test]
fn large_cavities_are_filled() {
    let mut crossed = 0;
    for seed in 1..12u32 {
        let fraction = |i: u32, a: f64| (f64::from(i + 41 * seed) * a).fract() * 2.0 - 1.0;
        let at = |i: u32| {
            DVec3::new(
                fraction(i, 0.819_172_513_4),
                fraction(i, 0.671_043_606_7),
                fraction(i, 0.549_700_477_9),
            )
        };
        let scattered = (0..40).map(|i| at(i) * DVec3::new(3.0, 3.0, 0.7));
        let (_, missing) = with_triangle(triangle(3.5).chain(scattered));
        crossed += missing;
    }
    assert!(crossed > 50, "{crossed}");
}
