//! The shape of cells.

use glam::{DVec2, DVec3};
use septet_meshing::quality::angles::angles;
use septet_meshing::quality::estimate;

/// Returns the circumradius of a cell divided by the length of its shortest edge. See [`estimate::radius_edge_ratio`].
pub fn radius_edge_ratio(dimension: usize, coordinates: &[f64], cell: &[u64]) -> f64 {
    let mut points = [[0.0; 3]; 4];
    for (point, &vertex) in points.iter_mut().zip(cell) {
        let start = vertex as usize * dimension;
        point[..dimension].copy_from_slice(&coordinates[start..start + dimension]);
    }
    estimate::radius_edge_ratio(points, cell.len())
}

/// Returns the smallest angle of a cell in degrees: the smallest dihedral angle in space, or the smallest interior
/// angle in the plane.
pub(super) fn least_angle(dimension: usize, coordinates: &[f64], cell: &[u64]) -> f64 {
    let at = |&v: &u64| &coordinates[v as usize * dimension..][..dimension];
    let found = if dimension == 2 {
        angles(&cell.iter().map(|v| DVec2::from_slice(at(v))).collect::<Vec<_>>())
    } else {
        angles(&cell.iter().map(|v| DVec3::from_slice(at(v))).collect::<Vec<_>>())
    };
    found.into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-12 * b, "{a} {b}");
    }

    #[test]
    fn regular_cells_have_the_known_ratio() {
        let regular = [1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0];
        let expected = (3.0f64 / 8.0).sqrt();
        for scale in [1.0, 1e-300, 5e-324, 1e300, 1e308] {
            let scaled = regular.map(|c: f64| c * scale);
            close(radius_edge_ratio(3, &scaled, &[0, 1, 2, 3]), expected);
        }
        let triangle = [0.0, 0.0, 1.0, 0.0, 0.5, 0.75f64.sqrt()];
        close(radius_edge_ratio(2, &triangle, &[0, 1, 2]), 1.0 / 3.0f64.sqrt());
        let corner = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        close(radius_edge_ratio(3, &corner, &[1, 3, 0, 2]), 0.75f64.sqrt());
    }

    #[test]
    fn a_short_edge_far_from_the_first_vertex_keeps_its_accuracy() {
        // The angle at the short edge is right, so the hypotenuse is the diameter.
        let points = [0.0, 0.0, 1.0, 0.0, 1.0, 1e-9];
        close(radius_edge_ratio(2, &points, &[0, 1, 2]), 0.5e9);
    }

    #[test]
    fn flat_cells_are_infinite() {
        let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
        assert_eq!(radius_edge_ratio(3, &square, &[0, 1, 2, 3]), f64::INFINITY);
        let line = [0.0, 0.0, 1.0, 1.0, 2.0, 2.0];
        assert_eq!(radius_edge_ratio(2, &line, &[0, 1, 2]), f64::INFINITY);
        assert_eq!(radius_edge_ratio(2, &[1.0; 6], &[0, 1, 2]), f64::INFINITY);
        let twice = [0.0, 0.0, 0.0, 0.0, 2.0, 2.0];
        assert_eq!(radius_edge_ratio(2, &twice, &[0, 1, 2]), f64::INFINITY);
    }
}
