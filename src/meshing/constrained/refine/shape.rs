//! The shapes of cells, and the balls of edges.

use glam::DVec3;
use septet_geometry::measure::{circumcentre, shortest_edge2};

/// The measures of a cell.
pub(super) struct Shape {
    /// The circumcentre. It is not finite for a flat cell.
    pub(super) centre: DVec3,
    pub(super) radius2: f64,
    pub(super) shortest2: f64,
}

impl Shape {
    pub(super) fn of(points: [DVec3; 4]) -> Self {
        let centre = circumcentre(&points);
        let radius2 = centre.distance_squared(points[0]);
        let radius2 = if radius2.is_finite() { radius2 } else { f64::INFINITY };
        Shape { centre, radius2, shortest2: shortest_edge2(&points) }
    }
}

/// Returns the cosine of the angle at which a point sees an edge, if the smallest ball of the edge contains the point.
pub(super) fn in_smallest_ball([a, b]: [DVec3; 2], p: DVec3) -> Option<f64> {
    let (u, v) = (a - p, b - p);
    let product = u.dot(v);
    (product < 0.0).then(|| product / (u.length_squared() * v.length_squared()).sqrt())
}
