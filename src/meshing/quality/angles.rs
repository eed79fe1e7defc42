//! Angles and measures of cells, rounded, for reports.

use septet_geometry::point::Point;

use crate::space::Space;

/// Returns the angles of a cell in degrees: three interior angles for a triangle, six dihedral angles for a
/// tetrahedron. A flat cell has angles of 0 and 180 degrees.
pub fn angles<P: Space>(cell: &[P]) -> Vec<f64> {
    if P::DIM == 2 {
        return (0..3)
            .map(|i| {
                let (a, b, c) = (cell[i], cell[(i + 1) % 3], cell[(i + 2) % 3]);
                let (u, v) = (b - a, c - a);
                between(P::hull_normal(&[u]).dot(v).abs(), u.dot(v))
            })
            .collect();
    }
    let mut found = Vec::with_capacity(6);
    for i in 0..4 {
        for j in 0..i {
            let (k, l) = others(i, j);
            // The dihedral angle equals the angle between the normals of the two triangles at the edge.
            let edge = cell[j] - cell[i];
            let (m, n) =
                (P::hull_normal(&[edge, cell[k] - cell[i]]), P::hull_normal(&[edge, cell[l] - cell[i]]));
            let sine = m.dot(cell[l] - cell[i]).abs() * edge.norm2().sqrt();
            found.push(between(sine, m.dot(n)));
        }
    }
    found
}

/// Returns an angle, given its sine and cosine times a common positive factor.
fn between(sine: f64, cosine: f64) -> f64 {
    sine.atan2(cosine).to_degrees()
}

/// Returns the two numbers among 0, 1, 2, 3 other than `i` and `j`.
fn others(i: usize, j: usize) -> (usize, usize) {
    let mut rest = (0..4).filter(|&k| k != i && k != j);
    (rest.next().unwrap_or(0), rest.next().unwrap_or(0))
}

/// Returns the area or volume of a cell. It is positive for positively oriented cells.
pub fn measure<P: Point>(cell: &[P]) -> f64 {
    let mut rel = [P::default(); 3];
    for i in 0..P::DIM {
        rel[i] = cell[i + 1] - cell[0];
    }
    let factorial = if P::DIM == 2 { 2.0 } else { 6.0 };
    P::hull_normal(&rel[..P::DIM - 1]).dot(rel[P::DIM - 1]) / factorial
}
