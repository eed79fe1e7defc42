//! Domains: ten closed surfaces and seven complexes.

use std::collections::BTreeMap;

use crate::calls::Shape;

/// A name, a domain, and a size that gives some hundreds of points.
pub type Problem = (&'static str, Shape, f64);

/// Closed surfaces, whose boundary can be kept or remeshed.
pub fn surfaces() -> Vec<Problem> {
    vec![
        ("cube", Shape::File("cube.off"), 0.8),
        ("cavity", Shape::File("cavity.off"), 0.9),
        ("tetrahedron", pyramid(3, 1.5), 0.25),
        ("pyramid", pyramid(5, 2.0), 0.3),
        ("prism", prism(&regular(6), 1.5), 0.3),
        ("l-prism", prism(&L, 1.0), 0.4),
        ("blade", prism(&[[0.0, 0.0], [2.0, 0.0], [1.8, 1.1]], 1.0), 0.25),
        ("octahedron", octahedron(0), 0.3),
        ("ball", octahedron(2), 0.35),
        ("torus", torus(12, 8), 0.8),
    ]
}

/// Complexes of the plane and of space, with regions, holes and dangling pieces.
pub fn complexes() -> Vec<Problem> {
    vec![
        ("airfoil", Shape::File("airfoil.poly"), 0.05),
        ("map", Shape::File("map.poly"), 0.5),
        ("l-shape", Shape::File("l-shape.poly"), 0.6),
        ("tunnel", Shape::File("tunnel.poly"), 0.8),
        ("two-regions", Shape::File("two-regions.poly"), 0.8),
        ("dangling", Shape::File("dangling.poly"), 1.0),
        ("wedge", Shape::File("wedge.poly"), 0.3),
    ]
}

/// An L of the plane.
const L: [[f64; 2]; 6] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

/// The corners of a regular polygon.
fn regular(corners: u32) -> Vec<[f64; 2]> {
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(corners);
    (0..corners).map(|i| [angle(i).cos(), angle(i).sin()]).collect()
}

/// Over a polygon; its sides are rectangles.
fn prism(base: &[[f64; 2]], height: f64) -> Shape {
    let n = base.len() as u32;
    let at = |z: f64| base.iter().map(move |&[x, y]| [x, y, z]);
    let mut faces = vec![(0..n).rev().collect(), (n..2 * n).collect::<Vec<u32>>()];
    faces.extend((0..n).map(|i| vec![i, (i + 1) % n, n + (i + 1) % n, n + i]));
    Shape::Surface { points: at(0.0).chain(at(height)).collect(), faces }
}

/// Over a regular polygon, its top above the middle.
fn pyramid(corners: u32, height: f64) -> Shape {
    let base = regular(corners);
    let mut points: Vec<[f64; 3]> = base.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    points.push([0.0, 0.0, height]);
    let mut faces = vec![(0..corners).rev().collect::<Vec<u32>>()];
    faces.extend((0..corners).map(|i| vec![i, (i + 1) % corners, corners]));
    Shape::Surface { points, faces }
}

/// An octahedron whose triangles are divided in four repeatedly; new points are moved to the sphere.
fn octahedron(times: u32) -> Shape {
    let mut points =
        vec![[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for (x, y, z) in (0..8u32).map(|i| (i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2))) {
        let turned = (x + y + z) % 2 == 1;
        faces.push(if turned { vec![y, x, z] } else { vec![x, y, z] });
    }
    for _ in 0..times {
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut middle = |points: &mut Vec<[f64; 3]>, a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let (p, q) = (points[a as usize], points[b as usize]);
                let sum = [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
                let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
                points.push(sum.map(|x| x / length));
                points.len() as u32 - 1
            })
        };
        let mut finer = Vec::new();
        for face in &faces {
            let [a, b, c] = [face[0], face[1], face[2]];
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| middle(&mut points, p, q));
            finer.extend([vec![a, ab, ca], vec![ab, b, bc], vec![ca, bc, c], vec![ab, bc, ca]]);
        }
        faces = finer;
    }
    Shape::Surface { points, faces }
}

/// Quadrilaterals around a ring, each in two triangles.
fn torus(around: u32, across: u32) -> Shape {
    let angle = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let at = |k: u32| {
        let ((s, c), (t, d)) = (angle(k / across, around).sin_cos(), angle(k % across, across).sin_cos());
        [(3.0 + d) * c, (3.0 + d) * s, t]
    };
    let vertex = |i: u32, j: u32| i % around * across + j % across;
    let mut faces = Vec::new();
    for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        faces.extend([vec![a, b, c], vec![a, c, d]]);
    }
    Shape::Surface { points: (0..around * across).map(at).collect(), faces }
}
