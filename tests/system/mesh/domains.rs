//! Domains, with facts that are known without the library.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use septet_io::read::{AnyInput, read_domain};
use septet_meshing::check;
use septet_meshing::domain::Domain;
use septet_meshing::input::{DomainKind, Input, InputFacet, InputSegment};

/// Of the plane or of space.
pub enum AnyDomain {
    /// Of the plane.
    Plane(Domain<DVec2>),
    /// Of space.
    Space(Domain<DVec3>),
}

/// The known facts of a domain.
#[derive(Clone, Debug)]
pub struct Known {
    /// Area or volume.
    pub measure: f64,
    /// Length or area of the boundary towards the outside, where it is known.
    pub boundary: Option<f64>,
    /// Components.
    pub regions: usize,
    /// Whether no features meet at less than 90 degrees.
    pub right_angles: bool,
}

/// A domain with a size that gives hundreds to a few thousand points.
pub struct Problem {
    /// For messages.
    pub name: &'static str,
    /// The domain.
    pub domain: AnyDomain,
    /// The known facts.
    pub known: Known,
    /// The largest size.
    pub size: f64,
}

fn tests() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

fn read(path: &Path) -> AnyDomain {
    let file = read_domain(path, &mut |_, _| {}).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    match file.input {
        AnyInput::Plane(input) => AnyDomain::Plane(check(&input).unwrap()),
        AnyInput::Space(input) => AnyDomain::Space(check(&input).unwrap()),
    }
}

fn known(measure: f64, boundary: f64) -> Known {
    Known { measure, boundary: Some(boundary), regions: 1, right_angles: true }
}

fn good(name: &'static str, known: Known, size: f64) -> Problem {
    let path = tests().join("domains/good").join(name).with_extension("poly");
    Problem { name, domain: read(&path), known, size }
}

/// Side 4.
pub fn cube() -> Problem {
    good("cube", known(64.0, 96.0), 0.5)
}

/// Three blocks of 2 by 2 by 2.
pub fn l_shape() -> Problem {
    good("l-shape", known(24.0, 24.0 + 32.0), 0.4)
}

/// Side 6 without the middle one of side 2.
pub fn cubic_hole() -> Problem {
    good("cubic-hole", known(208.0, 216.0 + 24.0), 1.0)
}

/// Side 4 with a square tunnel of side 2.
pub fn tunnel() -> Problem {
    good("tunnel", known(48.0, 96.0 - 8.0 + 32.0), 0.6)
}

/// Side 4, in two halves.
pub fn two_regions() -> Problem {
    good("two-regions", Known { regions: 2, ..known(64.0, 96.0) }, 0.6)
}

/// Pieces that leave corners of the cube at small angles.
pub fn dangling() -> Problem {
    good("dangling", Known { right_angles: false, ..known(64.0, 96.0) }, 0.8)
}

/// Sides 3, 6 and 9.
pub fn slanted_box() -> Problem {
    good("slanted-box", known(162.0, 198.0), 0.9)
}

/// Two unit squares at ten degrees, three more facets between them.
pub fn wedge() -> Problem {
    let angle = 10f64.to_radians();
    let known = known(angle.sin() / 2.0, 2.0 + angle.sin() + 2.0 * (angle / 2.0).sin());
    good("wedge", Known { right_angles: false, ..known }, 0.2)
}

/// An airfoil with two holes: as large as its polygons by the shoelace formula.
pub fn airfoil() -> Problem {
    let path = tests().join("domains/good/airfoil.poly");
    let AnyInput::Plane(input) = read_domain(&path, &mut |_, _| {}).unwrap().input else { unreachable!() };
    let ends = |s: &InputSegment| s.ends.map(|v| input.points[v as usize]);
    let length: f64 = input.segments.iter().map(ends).map(|[a, b]| a.distance(b)).sum();
    // Its polygons run all the same way or not: each is added up for itself, the largest is the outer one.
    let mut areas = vec![0.0];
    for pair in input.segments.windows(2) {
        let [a, b] = ends(&pair[0]);
        *areas.last_mut().unwrap() += a.perp_dot(b) / 2.0;
        if pair[0].ends[1] != pair[1].ends[0] {
            areas.push(0.0);
        }
    }
    let [a, b] = ends(input.segments.last().unwrap());
    *areas.last_mut().unwrap() += a.perp_dot(b) / 2.0;
    let largest = areas.iter().map(|a: &f64| a.abs()).fold(0.0, f64::max);
    let all: f64 = areas.iter().map(|a| a.abs()).sum();
    assert_eq!((areas.len(), input.holes.len()), (3, 2));
    good("airfoil", Known { right_angles: false, ..known(2.0 * largest - all, length) }, 0.03)
}

/// Four regions, 10 by 8.
pub fn map() -> Problem {
    good("map", Known { regions: 4, right_angles: false, ..known(80.0, 36.0) }, 0.4)
}

/// `TetGen`'s example.
pub fn example() -> Problem {
    let path = tests().join("data/example.poly");
    assert!(path.is_file(), "{} is missing: run tests/run --setup", path.display());
    let known = Known { measure: 17.9375, boundary: None, regions: 2, right_angles: false };
    Problem { name: "example", domain: read(&path), known, size: 0.5 }
}

/// A rectangle of the plane with two square holes and a dangling segment.
pub fn plate() -> Problem {
    let mut input = Input::new(DomainKind::Complex, Vec::new());
    for (low, side) in [([0.0, 0.0], [8.0, 4.0]), ([1.0, 1.0], [1.0, 1.0]), ([5.0, 2.0], [1.0, 1.0])] {
        let (low, side) = (DVec2::from(low), DVec2::from(side));
        let base = input.points.len() as u32;
        input.points.extend([(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|c| low + side * DVec2::from(c)));
        let ring = (0..4).map(|i| InputSegment { ends: [base + i, base + (i + 1) % 4], marker: 1 });
        input.segments.extend(ring);
    }
    input.holes.extend([DVec2::splat(1.5), DVec2::new(5.5, 2.5)]);
    input.points.extend([DVec2::new(3.0, 1.0), DVec2::new(3.0, 3.0)]);
    input.segments.push(InputSegment { ends: [12, 13], marker: 2 });
    let domain = AnyDomain::Plane(check(&input).unwrap());
    Problem { name: "plate", domain, known: known(30.0, 24.0 + 8.0), size: 0.25 }
}

/// A cube with a square and a segment that touch nothing, and a point.
pub fn dangling_squarely() -> Problem {
    let path = tests().join("domains/good/cube.poly");
    let AnyInput::Space(mut input) = read_domain(&path, &mut |_, _| {}).unwrap().input else {
        unreachable!()
    };
    let base = input.points.len() as u32;
    input.points.extend([[1., 1., 3.], [2., 1., 3.], [2., 2., 3.], [1., 2., 3.]].map(DVec3::from));
    input.points.extend([[3., 3., 2.], [3., 3., 1.], [3.5, 3.5, 3.5]].map(DVec3::from));
    for polygon in [&[0, 1, 2, 3][..], &[4, 5]] {
        let polygons = vec![polygon.iter().map(|v| v + base).collect()];
        input.facets.push(InputFacet { polygons, holes: Vec::new(), marker: 7 });
    }
    input.markers.clear();
    let domain = AnyDomain::Space(check(&input).unwrap());
    Problem { name: "cube with dangling pieces", domain, known: known(64.0, 96.0), size: 0.8 }
}

/// A torus of triangles, none coplanar with another: 12 times 8 quadrilaterals, each in two.
pub fn torus() -> Problem {
    let (around, across) = (12u32, 8u32);
    let angle = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let at = |k: u32| {
        let ((s, c), (t, d)) = (angle(k / across, around).sin_cos(), angle(k % across, across).sin_cos());
        DVec3::new((3.0 + d) * c, (3.0 + d) * s, t)
    };
    let points: Vec<DVec3> = (0..around * across).map(at).collect();
    let vertex = |i: u32, j: u32| i % around * across + j % across;
    let mut triangles = Vec::new();
    for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        triangles.extend([vec![a, b, c], vec![a, c, d]]);
    }
    let corners = |t: &Vec<u32>| [0, 1, 2].map(|k| points[t[k] as usize]);
    let volume: f64 = triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
    let area: f64 = triangles.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum();
    let known = Known { right_angles: false, ..known(volume.abs(), area) };
    let domain = AnyDomain::Space(check(&Input::surface(points, triangles)).unwrap());
    Problem { name: "torus", domain, known, size: 0.5 }
}
