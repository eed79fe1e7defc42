//! Empty balls that prove that a subsegment or subfacet is in the Delaunay triangulation.
//!
//! **Statement.** A simplex is in the Delaunay triangulation if its corners lie on a ball that contains no vertex. Such
//! a ball is its *witness*. The balls through the corners of a triangle have their centres on the axis through its
//! circumcentre m. Let r be its circumradius. A vertex v at height h above the plane is in the ball with offset z iff
//! `z > z_v` for h > 0, or `z < z_v` for h < 0, where `z_v = (|v - m|^2 - r^2) / 2 h`. The offsets of witnesses
//! therefore form an interval. If the smallest ball is a witness, it is used. Otherwise, the chosen offset lies inside
//! the interval, a little beyond the end nearest to 0, so that no vertex lies on the ball.
//!
//! *Two queries suffice.* Let only vertices above the plane lie in the smallest ball, so that the interval ends at some
//! z < 0. Above the plane, the ball with offset z lies inside the smallest ball. The other bound of the interval
//! therefore comes from vertices below the plane in the ball with offset z.
//!
//! **Work and depth.** Each query visits the vertices in the ball and in its bounding box.

use septet_geometry::point::{Point, dist2};

use super::balls::Ball;
use super::facets::circumcircle;
use crate::bvh::{Bounds, Bvh};

/// The distance beyond the end of the interval at which a ball is tried, relative to the offset.
const BEYOND: f64 = 0.25;

/// A ball through the corners of a triangle that contains no vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Witness<P> {
    pub(super) ball: Ball<P>,
    /// Whether it is the smallest ball through them.
    pub(super) smallest: bool,
}

/// Vertices, with a tree for queries.
pub(super) struct Near<'a, P> {
    points: &'a [P],
    tree: Bvh<P>,
}

impl<'a, P: Point> Near<'a, P> {
    pub(super) fn new(points: &'a [P]) -> Self {
        Near { points, tree: Bvh::new(points.iter().map(|&p| Bounds::of([p])).collect()) }
    }

    /// Calls `f` with the vertices that a ball contains, until `f` returns `false`.
    fn inside(&self, ball: &Ball<P>, mut f: impl FnMut(P) -> bool) {
        self.tree.visit(&ball.bounds(), |v| {
            let p = self.points[v as usize];
            !ball.holds(p) || f(p)
        });
    }

    /// Returns `true` if the smallest ball of a subsegment contains no vertex other than its ends, which are excluded
    /// regardless of rounding.
    pub(super) fn is_empty(&self, ends: [P; 2]) -> bool {
        let [p, q] = ends;
        let mut empty = true;
        self.inside(&Ball { centre: (p + q) * 0.5, radius2: 0.25 * dist2(p, q) }, |x| {
            empty = ends.contains(&x);
            empty
        });
        empty
    }

    /// Returns a ball through the corners of a triangle that contains no vertex, if there is one with a radius of at
    /// most `widest` times the smallest.
    pub(super) fn witness(&self, corners: [P; 3], widest: f64) -> Option<Witness<P>> {
        let [a, b, c] = corners;
        let small = circumcircle(a, b, c);
        let mut axis = Axis::new(small, P::hull_normal(&[b - a, c - a]));
        self.inside(&small, |p| axis.exclude(p));
        if !axis.is_open() {
            return None;
        }
        let Some(end) = axis.nearest() else {
            return Some(Witness { ball: small, smallest: true });
        };
        if 1.0 + end * end / small.radius2 > widest * widest {
            return None;
        }
        self.inside(&axis.ball(end * (1.0 + BEYOND)), |p| axis.exclude(p));
        let offset = axis.beyond(end)?;
        Some(Witness { ball: axis.ball(offset), smallest: false })
    }
}

/// The interval of offsets of balls through a circle that contain no vertex visited so far.
struct Axis<P> {
    small: Ball<P>,
    normal: P,
    range: [f64; 2],
}

impl<P: Point> Axis<P> {
    fn new(small: Ball<P>, normal: P) -> Self {
        let normal = normal / normal.norm2().sqrt();
        Axis { small, normal, range: [f64::NEG_INFINITY, f64::INFINITY] }
    }

    fn ball(&self, offset: f64) -> Ball<P> {
        let centre = self.small.centre + self.normal * offset;
        Ball { centre, radius2: self.small.radius2 + offset * offset }
    }

    /// Excludes the balls that contain the vertex `p`. Returns `true` if other balls remain.
    fn exclude(&mut self, p: P) -> bool {
        let from = p - self.small.centre;
        let height = self.normal.dot(from);
        let offset = (from.norm2() - self.small.radius2) / (2.0 * height);
        if height > 0.0 {
            self.range[1] = self.range[1].min(offset);
        } else if height < 0.0 {
            self.range[0] = self.range[0].max(offset);
        } else {
            self.range = [f64::INFINITY, f64::NEG_INFINITY];
        }
        self.is_open()
    }

    /// Returns `true` if the interval is nonempty.
    fn is_open(&self) -> bool {
        self.range[0] < self.range[1]
    }

    /// Returns the end of the interval that is nearest to 0, or `None` if the interval contains 0.
    fn nearest(&self) -> Option<f64> {
        let [low, high] = self.range;
        if low > 0.0 {
            Some(low)
        } else if high < 0.0 {
            Some(high)
        } else {
            None
        }
    }

    /// Returns an offset inside the interval near one of its ends, or `None` if the interval is too short for the
    /// rounding.
    fn beyond(&self, end: f64) -> Option<f64> {
        let other = if end > 0.0 { self.range[1] } else { self.range[0] };
        let far = end * (1.0 + BEYOND);
        let far = if other.is_finite() && (other - far) * end < 0.0 { 0.5 * (end + other) } else { far };
        ((far - end) * end > 1e-6 * end * end).then_some(far)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;
    use septet_geometry::point::dist2;

    fn vector() -> impl Strategy<Value = DVec3> {
        [-1.0..1.0f64, -1.0..1.0, -1.0..1.0].prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn witnesses_contain_no_vertex(points in prop::collection::vec(vector(), 4..24), widest in 1.0..4.0f64) {
            let near = Near::new(&points);
            let corners = [points[0], points[1], points[2]];
            let small = circumcircle(corners[0], corners[1], corners[2]);
            prop_assume!(small.radius2 < 100.0);
            let empty = |ball: &Ball<DVec3>| !points.iter().any(|&p| ball.holds(p));
            let found = near.witness(corners, widest);
            prop_assert_eq!(found.is_some_and(|w| w.smallest), empty(&small));
            // Balls of the axis at evenly spaced offsets.
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let ball = |z: f64| Ball { centre: small.centre + normal * z, radius2: small.radius2 + z * z };
            let furthest = (small.radius2 * (widest * widest - 1.0)).sqrt();
            let offsets = (-200..=200).map(|i| f64::from(i) / 200.0 * furthest);
            let by_all = offsets.into_iter().any(|z| empty(&ball(z)));
            prop_assert!(found.is_some() || !by_all);
            if let Some(Witness { ball, .. }) = found {
                prop_assert!(empty(&ball));
                for c in corners {
                    prop_assert!((dist2(c, ball.centre) / ball.radius2 - 1.0).abs() < 1e-9);
                }
                let most = widest * widest * (1.0 + BEYOND) * (1.0 + BEYOND);
                prop_assert!(ball.radius2 <= most * small.radius2 * (1.0 + 1e-9));
            }
        }
    }
}
