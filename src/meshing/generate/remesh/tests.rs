//! Remeshed surfaces by one processor.

use std::collections::BTreeMap;

use glam::DVec3;
use septet_geometry::hash::Draw;
use septet_geometry::measure::{circumcentre, circumradius2};

use super::{DEFAULT_PARTS, Kept, Options, remesh};
use crate::conformity::{Deviation, Follow, check_remeshed};
use crate::domain::Domain;
use crate::generate::{Alone, Failure, Labels, Rules};
use crate::improve::{Target, improve, least_sine};
use crate::input::Input;
use crate::mesh::{Carrier, Mesh};
use crate::size::{SizeFunction, SizeOptions};
use crate::tests::shapes::{cube, cube_surface, join};

/// The feature angle, in degrees.
const ANGLE: f64 = 60.0;

struct Remeshed {
    domain: Domain<DVec3>,
    mesh: Mesh<DVec3>,
    deviation: Deviation,
    /// The largest R over f at the centre, of all cells.
    worst: f64,
}

/// The mesh in a surface; a size of the box's diagonal over [`DEFAULT_PARTS`] if none is given.
fn remeshed(input: &Input<DVec3>, size: Option<f64>, options: Options) -> Remeshed {
    let domain = crate::check(input).unwrap();
    let mut wishes = SizeOptions::new(0.5);
    let bounds = crate::bvh::Bounds::of(input.points.iter().copied());
    wishes.wishes.most = size.or(Some(bounds.extent().length() / DEFAULT_PARTS));
    let kept = Kept::new(&domain, ANGLE);
    let f = SizeFunction::of_features(&domain, &kept.features(&domain), &wishes, &crate::cores::One).unwrap();
    let at = |x| f.at(x);
    let rules = Rules { size: &at, lipschitz: 0.5, seed: 1, most: 1 << 22 };
    let made = remesh(&domain, rules, ANGLE, options, &mut Alone { seed: 1 }).unwrap();
    let inside = made.delaunay.cells.iter().zip(&made.labels.of).filter(|(_, l)| **l != Labels::OUT);
    let ratio = |(c, _): (&[u32; 4], &u32)| {
        let corners = c.map(|v| made.vertices.points[v as usize]);
        circumradius2(&corners).sqrt() / at(circumcentre(&corners))
    };
    let worst = inside.map(ratio).fold(0.0, f64::max);
    let stages = made.stages.clone();
    let mesh = made.into_mesh(&domain);
    let found = check_remeshed(&domain, &mesh, &Follow { feature_angle: ANGLE, distance: options.distance });
    assert!(found.is_clean(), "{found:?}");
    let deviation = found.deviation.unwrap();
    for stage in stages {
        eprintln!("  {stage:?}");
    }
    eprintln!("{} points, {} cells, R/f {worst:.4}, {deviation:?}", mesh.points.len(), mesh.cells.len());
    Remeshed { domain, mesh, deviation, worst }
}

fn volume(mesh: &Mesh<DVec3>) -> f64 {
    let one = |c: &[u32; 4]| {
        let [a, b, c, d] = c.map(|v| mesh.points[v as usize]);
        (b - a).cross(c - a).dot(d - a).abs() / 6.0
    };
    mesh.cells.iter().map(one).sum()
}

/// Euler's number of the boundary, after it has been found to be all faces of one cell, and a 2-manifold.
fn euler(mesh: &Mesh<DVec3>) -> i64 {
    let mut once: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    for &[a, b, c, d] in &mesh.cells {
        for mut face in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            face.sort_unstable();
            *once.entry(face).or_default() += 1;
        }
    }
    once.retain(|_, cells| *cells == 1);
    let mut stated: Vec<[u32; 3]> = mesh.faces.iter().map(|f| f.vertices).collect();
    for f in &mut stated {
        f.sort_unstable();
    }
    stated.sort_unstable();
    assert!(once.keys().eq(stated.iter()), "the faces stated are the boundary");
    let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut around: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for &[a, b, c] in once.keys() {
        for (edge, apex) in [([a, b], c), ([a, c], b), ([b, c], a)] {
            *edges.entry(edge).or_default() += 1;
            around.entry(apex).or_default().push(edge);
        }
    }
    assert!(edges.values().all(|&faces| faces == 2), "every edge has two faces");
    for link in around.values() {
        // Walk around the vertex: one cycle of all edges opposite.
        let (mut left, mut at) = (link.clone(), link[0][0]);
        while let Some(i) = left.iter().position(|e| e.contains(&at)) {
            let edge = left.swap_remove(i);
            at = if edge[0] == at { edge[1] } else { edge[0] };
        }
        assert!(left.is_empty() && at == link[0][0], "one fan around every vertex");
    }
    around.len() as i64 - edges.len() as i64 + once.len() as i64
}

/// A sphere of radius 1: an octahedron, its triangles quartered.
fn sphere(levels: u32) -> Input<DVec3> {
    let mut points = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..levels {
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry(crate::space::ascending([a, b])).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let quarters = |[a, b, c]: [u32; 3]| {
            let [x, y, z] = [middle(b, c), middle(c, a), middle(a, b)];
            [[a, z, y], [z, b, x], [y, x, c], [x, y, z]]
        };
        faces = faces.into_iter().flat_map(quarters).collect();
    }
    Input::surface(points, faces.into_iter().map(|f| f.to_vec()))
}

/// A torus with radii 1 and `thin`, in `m` times `n` quadrangles of two triangles.
fn torus(thin: f64, m: u32, n: u32) -> Input<DVec3> {
    let angle = |i: u32, m: u32| f64::from(i) / f64::from(m) * std::f64::consts::TAU;
    let point = |k: u32| {
        let (u, v) = (angle(k / n, m), angle(k % n, n));
        let radius = 1.0 + thin * v.cos();
        DVec3::new(radius * u.cos(), radius * u.sin(), thin * v.sin())
    };
    let at = |i: u32, j: u32| (i % m) * n + j % n;
    let faces = (0..m * n).flat_map(|k| {
        let (i, j) = (k / n, k % n);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [vec![a, b, c], vec![a, c, d]]
    });
    Input::surface((0..m * n).map(point).collect(), faces)
}

/// What holds of all: the boundary is a manifold with Euler's number as given, cells are as small as asked for, surface and
/// boundary as close as `limit`, and the volume no farther from the surface's than the layer between them.
fn is_sound(found: &Remeshed, number: i64, limit: f64, area: f64) {
    assert_eq!(euler(&found.mesh), number);
    assert!(found.worst <= 1.0, "{}", found.worst);
    let Deviation { of_boundary, of_surface, .. } = found.deviation;
    assert!(of_boundary <= limit && of_surface <= limit, "{:?}", found.deviation);
    let scale = 0.5f64.powi(3 * found.domain.simplices.exponent);
    let gap = (volume(&found.mesh) - found.domain.measure() * scale).abs();
    assert!(gap <= 1.1 * area * of_boundary.max(of_surface), "{gap}");
}

#[test]
fn a_sphere() {
    // What lies between the centres of faces may be farther off than they are: twice as far is allowed.
    let found = remeshed(&sphere(4), Some(0.25), Options::default());
    is_sound(&found, 2, 0.05, 12.6);
}

#[test]
fn a_torus() {
    let input = torus(0.4, 48, 24);
    is_sound(&remeshed(&input, Some(0.25), Options::default()), 0, 0.05, 15.8);
    let close = Options { distance: Some(0.01) };
    is_sound(&remeshed(&input, Some(0.25), close), 0, 0.01, 15.8);
}

#[test]
fn a_cube() {
    let found = remeshed(&cube_surface(), Some(0.7), Options::default());
    is_sound(&found, 2, 1e-12, 96.0);
    assert!((volume(&found.mesh) - 64.0).abs() < 1e-9);
    let corners = found.mesh.carriers.iter().filter(|c| matches!(c, Carrier::Corner(_))).count();
    let mut ridges: Vec<u32> = found.mesh.edges.iter().map(|e| e.segment).collect();
    ridges.dedup();
    assert_eq!((corners, ridges.len()), (8, 12));
    let along = found.mesh.edges.iter().map(|e| {
        let [p, q] = e.vertices.map(|v| found.mesh.points[v as usize]);
        (q - p).length()
    });
    assert!((along.sum::<f64>() - 48.0).abs() < 1e-9);
}

/// A shell in a cavity of another, and one beside: three components of different numbers.
#[test]
fn shells_in_shells() {
    let small = sphere(3);
    let nested = join(&sphere(4), &small, DVec3::ZERO, 0.6);
    let nested = join(&nested, &small, DVec3::ZERO, 0.3);
    let all = join(&nested, &small, DVec3::X * 1.7, 0.5);
    let found = remeshed(&all, Some(0.2), Options::default());
    is_sound(&found, 8, 0.04, 22.0);
}

/// Shells far smaller than the size asked for are there all the same.
#[test]
fn small_shells() {
    let small = sphere(2);
    let cavity = join(&sphere(3), &small, DVec3::X * 0.4, 0.03);
    let all = join(&cavity, &small, DVec3::X * 1.5, 0.04);
    is_sound(&remeshed(&all, Some(0.4), Options::default()), 6, 0.08, 12.6);
}

#[test]
fn only_surfaces_of_space() {
    let domain = crate::check(&cube()).unwrap();
    let rules = Rules { size: &|_| 1.0, lipschitz: 0.5, seed: 1, most: 1 << 22 };
    let failure = remesh(&domain, rules, ANGLE, Options::default(), &mut Alone { seed: 1 }).unwrap_err();
    assert!(matches!(failure, Failure::Unsupported(_)));
}

/// Wedges of 40 degrees, convex and reflex: their ridges and facets are kept as they are.
#[test]
fn narrow_wedges() {
    let (s, c) = 40f64.to_radians().sin_cos();
    let corners = [[0.0, 0.0], [3.0, 0.0], [3.0 * c, 3.0 * s]];
    let notched = [[0.0, 0.0], [3.0 * c, 3.0 * s], [-3.0, 3.0], [-3.0, -3.0], [3.0, -3.0], [3.0, 0.0]];
    for polygon in [&corners[..], &notched[..]] {
        let n = polygon.len() as u32;
        let at = |z: f64| polygon.iter().map(move |p| DVec3::new(p[0], p[1], z));
        let points: Vec<DVec3> = at(0.0).chain(at(2.0)).collect();
        let wall = |i: u32| {
            let j = (i + 1) % n;
            [vec![i, j, j + n], vec![i, j + n, i + n]]
        };
        // Every corner is seen from the first one.
        let fan = (1..n - 1).flat_map(|i| [vec![0, i + 1, i], vec![n, n + i, n + i + 1]]);
        let input = Input::surface(points, (0..n).flat_map(wall).chain(fan));
        for size in [1.0, 0.5] {
            is_sound(&remeshed(&input, Some(size), Options::default()), 2, 1e-12, 120.0);
        }
    }
}

/// A shell that is thinner than the size: the balls of each side are as small as it is thick.
#[test]
fn a_thin_shell() {
    let all = join(&sphere(4), &sphere(4), DVec3::ZERO, 0.88);
    let found = remeshed(&all, Some(0.4), Options::default());
    is_sound(&found, 4, 0.05, 22.5);
    assert!(found.deviation.finer > 0);
}

/// Improving leaves the boundary as it is, and does not make the worst cell worse.
#[test]
fn improved_within_its_boundary() {
    let found = remeshed(&torus(0.4, 48, 24), Some(0.15), Options::default());
    let mut mesh = found.mesh.clone();
    let target = Target { fixed: true, ..Target::default() };
    let done = improve(&found.domain, &mut mesh, &target);
    let follow = Follow { feature_angle: ANGLE, distance: None };
    let conformity = check_remeshed(&found.domain, &mesh, &follow);
    assert!(conformity.is_clean(), "{conformity:?}");
    assert_eq!(conformity.deviation, Some(found.deviation));
    assert_eq!(mesh.faces, found.mesh.faces);
    let least = |mesh: &Mesh<DVec3>| {
        let of = |c: &[u32; 4]| least_sine(&c.map(|v| mesh.points[v as usize]));
        mesh.cells.iter().map(of).fold(1.0, f64::min)
    };
    assert!(done.moved > 0 && done.bad[1] < done.bad[0] && least(&mesh) >= least(&found.mesh), "{done:?}");
}

/// A prism over a polygon that is nearly round: its rims are ridges, cut into pieces that bend by 60 degrees at most.
#[test]
fn round_ridges() {
    let n = 48;
    let angle = |i: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let at = |i: u32, z: f64| DVec3::new(angle(i).cos(), angle(i).sin(), z);
    let points = (0..2 * n).map(|i| at(i % n, f64::from(i / n))).collect();
    let wall = |i: u32| {
        let j = (i + 1) % n;
        [vec![i, j, j + n], vec![i, j + n, i + n]]
    };
    let fan = (1..n - 1).flat_map(|i| [vec![0, i + 1, i], vec![n, n + i, n + i + 1]]);
    let input = Input::surface(points, (0..n).flat_map(wall).chain(fan));
    let domain = crate::check(&input).unwrap();
    let kept = Kept::new(&domain, ANGLE);
    assert!(kept.ridges.len() >= 12 && kept.ridges.len() <= 14, "{}", kept.ridges.len());
    let length: f64 = kept.ridges.iter().map(super::kept::Ridge::length).sum();
    let scale = 0.5f64.powi(domain.simplices.exponent);
    assert!((length * scale - 4.0 * f64::from(n) * (angle(1) / 2.0).sin()).abs() < 1e-9);
    is_sound(&remeshed(&input, Some(0.3), Options::default()), 2, 0.06, 12.6);
}

/// Corners of few large facets: chords at a corner are brought to one length before they are divided further.
#[test]
fn corners_of_few_facets() {
    let corner = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let flat = [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(0.5, 1.5, 0.0), DVec3::new(1.0, 0.5, 0.4)];
    let tall = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.2, 0.3, 4.0)];
    for points in [corner, flat, tall] {
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|f| f.to_vec());
        let input = Input::surface(points.to_vec(), faces);
        let found = remeshed(&input, None, Options::default());
        is_sound(&found, 2, 0.02, 8.0);
    }
}

/// A pyramid on each side of a cube: ridges that fold in and corners of eight facets.
#[test]
fn a_star() {
    let low = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| f64::from(bit) - 0.5));
    let mut points: Vec<DVec3> = low.map(DVec3::from_array).collect();
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut faces = Vec::new();
    for side in sides {
        let middle: DVec3 = side.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 4.0;
        points.push(middle * 3.0);
        let apex = points.len() as u32 - 1;
        faces.extend((0..4).map(|i| vec![side[i], side[(i + 1) % 4], apex]));
    }
    let found = remeshed(&Input::surface(points, faces), None, Options::default());
    is_sound(&found, 2, 0.03, 13.5);
}

/// Tetrahedra with corners anywhere in a cube, those of them without an angle below 20 degrees.
#[test]
fn tetrahedra() {
    let mut draw = Draw::new(1);
    let mut made = 0;
    while made < 10 {
        let [a, b, c, d] = [(); 4].map(|()| draw.point::<DVec3>());
        let points = if (b - a).cross(c - a).dot(d - a) < 0.0 { [b, a, c, d] } else { [a, b, c, d] };
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|f| f.to_vec());
        let input = Input::surface(points.to_vec(), faces);
        let Ok(domain) = crate::check(&input) else { continue };
        if domain.small_angles(20.0).is_empty() {
            is_sound(&remeshed(&input, None, Options::default()), 2, 0.02, 4.0);
            made += 1;
        }
    }
}
