//! Computes the volume of each point's Voronoi cell, as far as the tetrahedra cover it.

use std::error::Error;

use glam::DVec3;
use septet::generate::{generate, parse_sample};
use septet::{Points, Spec};

fn main() -> Result<(), Box<dyn Error>> {
    let sample = generate(&parse_sample("uniform:2000")?, &mut |_, _, _| {})?;
    let Points::Space(points) = &sample.points else { return Err("a sample in space".into()) };
    let run = septet::triangulate(points, &Spec::default())?;

    // To the volume of each of its vertices, a tetrahedron adds its part of the Voronoi cell of this vertex.
    let mut volumes = vec![0.0; points.len()];
    for cell in run.cells().chunks_exact(4) {
        let corners = [0, 1, 2, 3].map(|i| points[cell[i] as usize]);
        let centre = circumcentre(&corners);
        for v in 0..4 {
            volumes[cell[v] as usize] += dual_volume(&corners, v, centre);
        }
    }
    // The parts add up to the tetrahedra, so all volumes add up to the volume of the hull.
    let hull: f64 =
        run.cells().chunks_exact(4).map(|cell| volume([0, 1, 2, 3].map(|i| points[cell[i] as usize]))).sum();
    let all: f64 = volumes.iter().sum();
    assert!((all - hull).abs() < 1e-9 * hull, "{all} {hull}");
    println!("{} dual volumes add up to {all:.6}, the volume of the hull", volumes.len());
    Ok(())
}

fn volume([a, b, c, d]: [DVec3; 4]) -> f64 {
    (b - a).dot((c - a).cross(d - a)) / 6.0
}

/// Returns the centre of the sphere through four points.
fn circumcentre(&[a, b, c, d]: &[DVec3; 4]) -> DVec3 {
    let [u, v, w] = [b - a, c - a, d - a];
    let up =
        v.cross(w) * u.length_squared() + w.cross(u) * v.length_squared() + u.cross(v) * w.length_squared();
    a + up / (2.0 * u.dot(v.cross(w)))
}

/// Returns the centre of the circle through three points.
fn triangle_centre(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let (u, v) = (b - a, c - a);
    let n = u.cross(v);
    a + (n.cross(u) * v.length_squared() + v.cross(n) * u.length_squared()) / (2.0 * n.length_squared())
}

/// Returns the signed volume of the part of a tetrahedron that belongs to the Voronoi cell of its corner `v`: a sum
/// over the flags (edge, triangle) at the corner.
fn dual_volume(corners: &[DVec3; 4], v: usize, centre: DVec3) -> f64 {
    let at = corners[v];
    let others: Vec<usize> = (0..4).filter(|&i| i != v).collect();
    let mut sum = 0.0;
    for &i in &others {
        for &j in others.iter().filter(|&&j| j != i) {
            let k = 6 - v - i - j;
            let (edge, triangle) = ((at + corners[i]) / 2.0, triangle_centre(at, corners[i], corners[j]));
            // Positive if the flag is oriented as the tetrahedron (v, i, j, k) is.
            let orientation = volume([at, corners[i], corners[j], corners[k]]).signum();
            sum += orientation * volume([at, edge, triangle, centre]);
        }
    }
    sum
}
