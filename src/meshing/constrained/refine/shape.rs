//! The shapes of cells, and the order in which bad ones are refined.

use std::cmp::Ordering;

use glam::DVec3;
use septet_geometry::measure::{circumcentre, shortest_edge2};

/// A cell that is not good enough. Cells compare by badness, and then by their corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bad {
    /// The square of the ratio of circumradius and shortest edge, or a negative number for a cell that is only too large.
    pub(super) badness: f64,
    pub(super) corners: [u32; 4],
    pub(super) cell: u32,
}

impl Eq for Bad {}

impl PartialOrd for Bad {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Bad {
    fn cmp(&self, other: &Self) -> Ordering {
        self.badness.total_cmp(&other.badness).then_with(|| other.corners.cmp(&self.corners))
    }
}

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
