//! The parts of Voronoi cells that belong to one cell of a triangulation.
//!
//! **Statement.** Let `h` be the circumcentre of a positively oriented cell, `v` and `i` two of its corners, and
//! `a = x_i - x_v`. The cell has a share in the Voronoi facet between `v` and `i`. The *part* of the edge `vi` is the signed
//! volume of the pyramid from `x_v` over this share. The pyramid from `x_i` has the same volume. In the plane, the part is
//! `(a x (h - x_v)) / 4`. In space, it is a sum over the two triangles at the edge. Let `p = x_v - x_j`, `q = x_i - x_j` and
//! `n = p x q` for the triangle `v, i, j`. Let `s` be the height of `h` above its plane, positive on the side of the cell. The
//! term is `|a|^2 (p . q / |n|) s / 24`.
//!
//! *Proof.* The share of the facet in a triangle `v, i, j` is the right triangle between the middle of the edge, the centre `t` of the triangle and `h`.
//! Its legs are `|t - m| = |a| cot(j) / 2` and `s`, its height from `x_v` is `|a| / 2`, and `cot(j) = p . q / |n|`. The
//! volume of the pyramid is `|a|^2 cot(j) s / 24`. The signs make the sum over all cells right when centres lie outside of their
//! cells, because both sides are polynomials in the position of the centre. QED.
//!
//! If all cells at a vertex are bounded, its Voronoi cell has the volume of its parts, and the facet between `v` and `i`
//! has the measure `2 d` times their sum, divided by `|a|`.
//!
//! **Source.** Edelsbrunner, *Geometry and Topology for Mesh Generation* (2001); the cotangent formula: Pinkall and Polthier,
//! "Computing discrete minimal surfaces and their conjugates" (1993).
//!
//! **Rounding.** A circumcentre is a quotient of determinants. If the rounded numerator or denominator may have a relative error
//! above [`THIN`], both are computed by big integers and rounded once.
//!
//! **Work.** O(1) for each cell.

use septet_geometry::point::Point;

use crate::dimension::Dimension;
use crate::exact;

/// The relative error of a determinant from which on it is computed by big integers.
pub(crate) const THIN: f64 = 1e-10;

/// Whether the rounded determinant of a positively oriented cell may have a relative error above [`THIN`].
pub(crate) fn is_thin<P: Point>(cell: &[P]) -> bool {
    let rounded = P::rounded_orientation(&cell[..=P::DIM]);
    rounded.bound > rounded.det * THIN
}

/// Returns the circumcentre of a positively oriented cell relative to its first corner. It may be infinite.
pub(crate) fn circumcentre<P: Point>(cell: &[P]) -> P {
    let mut rel = [P::default(); 3];
    for (i, rel) in rel.iter_mut().enumerate().take(P::DIM) {
        *rel = cell[i + 1] - cell[0];
    }
    let (w, v) = P::sphere_plane(&rel[..P::DIM]);
    if w * THIN > P::rounded_orientation(&cell[..=P::DIM]).bound && !is_cancelled(v, &rel[..P::DIM]) {
        return v / (2.0 * w);
    }
    exact::circumcentre(cell)
}

/// Whether the terms of the numerator of a circumcentre cancel so far that its relative error may be above [`THIN`]. The terms are
/// products of squared lengths and the other lengths.
fn is_cancelled<P: Point>(numerator: P, sides: &[P]) -> bool {
    let squares: f64 = sides.iter().map(|side| side.norm2()).sum();
    let lengths: f64 = sides.iter().map(|side| side.norm2().sqrt()).product();
    let largest = squares.sqrt() * lengths;
    // The square of the numerator may be beyond the range of floats.
    let length = (0..P::DIM).map(|axis| numerator.coord(axis).abs()).fold(0.0, f64::max);
    // Each term has a relative error below 2^-49.
    length * THIN < largest * 2f64.powi(-49)
}

/// Returns the part of each edge of [`Dimension::EDGES`] in a positively oriented cell whose circumcentre is known relative to
/// its first corner.
pub(crate) fn parts<P: Dimension>(cell: &[P], centre: P) -> [f64; 6] {
    let mut parts = [0.0; 6];
    if P::DIM == 2 {
        for (part, &[v, i, ..]) in parts.iter_mut().zip(P::EDGES) {
            let centre = centre + (cell[0] - cell[v]);
            *part = P::hull_normal(&[cell[i] - cell[v]]).dot(centre) / 4.0;
        }
        return parts;
    }
    for (part, &edge) in parts.iter_mut().zip(P::EDGES) {
        *part = space_part(cell, centre, edge);
    }
    parts
}

/// Returns the part of one edge in space.
pub(crate) fn space_part<P: Point>(cell: &[P], centre: P, [v, i, j, k]: [usize; 4]) -> f64 {
    // The normals point into the cell: `(v, i, j, k)` is an even permutation of its corners.
    let [a, b] = [[v, i, j], [v, i, k]].map(|triangle| term(cell, centre, triangle).0);
    (cell[i] - cell[v]).norm2() * (a - b) / 24.0
}

/// Returns the term of a triangle `v, i, j` without the factor of its edge `vi`, and the vector from the triangle's centre to the
/// centre of the cell.
fn term<P: Point>(cell: &[P], centre: P, [v, i, apex]: [usize; 3]) -> (f64, P) {
    let (p, q) = (cell[v] - cell[apex], cell[i] - cell[apex]);
    let normal = P::hull_normal(&[p, q]);
    let length = normal.norm2().sqrt();
    let height = normal.dot(centre + (cell[0] - cell[apex])) / length;
    ((p.dot(q) / length) * height, normal * (height / length))
}

/// Returns the term of a triangle `v, i, j` for its edge `vi`, and the vector from the triangle's centre to the centre of the cell.
/// The triangle's normal must point into the cell; otherwise the term has the other sign.
pub(crate) fn part_in_triangle<P: Point>(cell: &[P], centre: P, triangle: [usize; 3]) -> (f64, P) {
    let (part, height) = term(cell, centre, triangle);
    let along = cell[triangle[1]] - cell[triangle[0]];
    (along.norm2() * part / 24.0, height)
}
