//! Measures of cells: circumradius, shortest edge, radius-edge ratio (paper, Section 1). Rounded; for
//! reports and for the choice of parameters, never for a decision about the triangulation.

use crate::point::{Point, dist2};

/// Squared circumradius of a cell of `DIM + 1` points; infinite for a flat one.
pub fn circumradius2<P: Point>(cell: &[P]) -> f64 {
    let mut rel = [P::default(); 3];
    for i in 0..P::DIM {
        rel[i] = cell[i + 1] - cell[0];
    }
    let (w, v) = P::sphere_plane(&rel[..P::DIM]);
    // The circumcentre relative to the first point is v / (2 w).
    let r = (v / (2.0 * w)).norm2();
    if r.is_nan() { f64::INFINITY } else { r }
}

/// Is the diameter of the circumsphere of a cell of `DIM + 1` points at most `length`, which is finite? With one division;
/// never for a flat one.
pub fn diameter_is_at_most<P: Point>(cell: &[P], length: f64) -> bool {
    let mut rel = [P::default(); 3];
    for i in 0..P::DIM {
        rel[i] = cell[i + 1] - cell[0];
    }
    let (w, v) = P::sphere_plane(&rel[..P::DIM]);
    // The circumcentre relative to the first point is v / (2 w); not a number, or infinite, where w is zero.
    let diameter = v * (1.0 / w);
    diameter.norm2() <= length * length
}

/// Circumcentre of a cell of `DIM + 1` points; not finite for a flat one.
pub fn circumcentre<P: Point>(cell: &[P]) -> P {
    let mut rel = [P::default(); 3];
    for i in 0..P::DIM {
        rel[i] = cell[i + 1] - cell[0];
    }
    let (w, v) = P::sphere_plane(&rel[..P::DIM]);
    cell[0] + v / (2.0 * w)
}

/// Centre and squared radius of the smallest ball through three points; not finite if they are on a line.
pub fn circumcircle<P: Point>([a, b, c]: [P; 3]) -> (P, f64) {
    let (u, v) = (b - a, c - a);
    let (uu, vv, uv) = (u.norm2(), v.norm2(), u.dot(v));
    let twice = 2.0 * (uu * vv - uv * uv);
    let offset = u * (vv * (uu - uv) / twice) + v * (uu * (vv - uv) / twice);
    (a + offset, offset.norm2())
}

/// Squared length of a cell's shortest edge.
pub fn shortest_edge2<P: Point>(cell: &[P]) -> f64 {
    let mut least = f64::INFINITY;
    for i in 0..=P::DIM {
        for j in 0..i {
            least = least.min(dist2(cell[i], cell[j]));
        }
    }
    least
}

/// Circumradius over shortest edge: `1 / sqrt 3` for an equilateral triangle, `sqrt(3/8)` for a regular
/// tetrahedron, infinite for a flat cell.
pub fn radius_edge_ratio<P: Point>(cell: &[P]) -> f64 {
    (circumradius2(cell) / shortest_edge2(cell)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    #[test]
    fn regular_cells() {
        let t = [
            DVec3::new(1., 1., 1.),
            DVec3::new(1., -1., -1.),
            DVec3::new(-1., 1., -1.),
            DVec3::new(-1., -1., 1.),
        ];
        assert!((radius_edge_ratio(&t) - (3.0f64 / 8.0).sqrt()).abs() < 1e-12);
        assert!(circumcentre(&t).length() < 1e-12);
        let e = [DVec2::ZERO, DVec2::X, DVec2::new(0.5, 0.75f64.sqrt())];
        assert!((radius_edge_ratio(&e) - 1.0 / 3.0f64.sqrt()).abs() < 1e-12);
        assert_eq!(radius_edge_ratio(&[DVec2::ZERO, DVec2::X, DVec2::X * 2.0]), f64::INFINITY);
        assert!(!diameter_is_at_most(&[DVec2::ZERO, DVec2::X, DVec2::X * 2.0], 1e9));
        for unit in [1.0, 1e45, 1e-45] {
            let (t, width) = (t.map(|x| x * unit), 12f64.sqrt() * unit);
            assert!(diameter_is_at_most(&t, width * 1.0001) && !diameter_is_at_most(&t, width * 0.9999));
        }
    }
}
