//! Balls that show that a piece or a triangle is in the Delaunay triangulation.
//!
//! **Statement.** A simplex whose corners lie on a ball that holds no vertex is in the Delaunay triangulation. Such a ball
//! is its *witness*. The balls through the corners of a triangle have their centres on the axis through the centre of
//! its circle; a vertex at height h above the plane is in the ball of offset z iff `z > z_v` for h > 0, iff `z < z_v`
//! for h < 0, `z_v = (|v - m|^2 - r^2) / 2 h`. So the witnesses are an interval of offsets. The smallest ball is
//! taken where it is one; if not, one a little beyond the nearer end of the interval, so that no vertex lies on it
//! either.
//!
//! *Two queries find it.* Let vertices above the plane alone be in the smallest ball: the interval ends at some z < 0. The
//! part above the plane of the ball with offset z lies in the smallest ball, so what else bounds the interval lies below,
//! and in that ball.
//!
//! **Work and depth.** What lies in the balls and their boxes.

use septet_geometry::point::{Point, dist2};

use super::balls::Ball;
use super::facets::circumcircle;
use crate::bvh::{Bounds, Bvh};

/// How far beyond the end of the interval a ball is looked for, as a part of the offset.
const BEYOND: f64 = 0.25;

/// A ball through the corners of a triangle that holds no vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Witness<P> {
    pub(super) ball: Ball<P>,
    /// Is it the smallest ball through them?
    pub(super) smallest: bool,
}

/// Vertices that can be asked for.
pub(super) struct Near<'a, P> {
    points: &'a [P],
    tree: Bvh<P>,
}

impl<'a, P: Point> Near<'a, P> {
    pub(super) fn new(points: &'a [P]) -> Self {
        Near { points, tree: Bvh::new(points.iter().map(|&p| Bounds::of([p])).collect()) }
    }

    /// Calls `f` with the vertices that a ball holds, until it answers `false`.
    fn inside(&self, ball: &Ball<P>, mut f: impl FnMut(P) -> bool) {
        self.tree.visit(&ball.bounds(), |v| {
            let p = self.points[v as usize];
            !ball.holds(p) || f(p)
        });
    }

    /// Does the smallest ball of a piece hold no vertex? Its own ends are not in it, however rounding has it.
    pub(super) fn is_empty(&self, ends: [P; 2]) -> bool {
        let [p, q] = ends;
        let mut empty = true;
        self.inside(&Ball { centre: (p + q) * 0.5, radius2: 0.25 * dist2(p, q) }, |x| {
            empty = ends.contains(&x);
            empty
        });
        empty
    }

    /// A ball through the corners of a triangle that holds no vertex and has at most `widest` times the radius of the
    /// smallest one, if there is one.
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

/// The offsets of balls through a circle that hold no vertex met so far.
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

    /// Leaves out the balls that hold a vertex; are there others?
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

    /// Is there an offset left?
    fn is_open(&self) -> bool {
        self.range[0] < self.range[1]
    }

    /// The end of the interval that is nearest to 0; none if it holds 0.
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

    /// An offset inside of the interval, not far from an end of it; nothing if there is none beyond rounding.
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
        fn witnesses_are_balls_without_vertices(points in prop::collection::vec(vector(), 4..24), widest in 1.0..4.0f64) {
            let near = Near::new(&points);
            let corners = [points[0], points[1], points[2]];
            let small = circumcircle(corners[0], corners[1], corners[2]);
            prop_assume!(small.radius2 < 100.0);
            let empty = |ball: &Ball<DVec3>| !points.iter().any(|&p| ball.holds(p));
            let found = near.witness(corners, widest);
            prop_assert_eq!(found.is_some_and(|w| w.smallest), empty(&small));
            // All balls of an axis, one after the other.
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
