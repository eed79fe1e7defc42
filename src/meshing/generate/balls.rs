//! The smallest balls of subsegments and subfacets, which contain no vertex.

use septet_geometry::cost::Sweep;
use septet_geometry::point::{Point, dist2};

use crate::bvh::{Bounds, Bvh};

/// The smallest ball through the corners of a subsegment or subfacet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball<P> {
    /// The centre.
    pub centre: P,
    /// The squared radius.
    pub radius2: f64,
}

impl<P: Point> Ball<P> {
    /// Returns `true` if the point lies strictly inside the ball. The margin exceeds the rounding at the corners of
    /// the simplex.
    pub fn holds(&self, x: P) -> bool {
        dist2(self.centre, x) < self.radius2 * (1.0 - 1e-10)
    }

    pub(super) fn bounds(&self) -> Bounds<P> {
        let half = P::splat(self.radius2.sqrt() * (1.0 + 1e-12));
        Bounds { low: self.centre - half, high: self.centre + half }
    }
}

/// Balls, with a tree for queries.
#[derive(Clone, Debug)]
pub struct Balls<P> {
    balls: Vec<Ball<P>>,
    tree: Bvh<P>,
}

impl<P: Point> Balls<P> {
    /// Builds the tree.
    pub fn new(balls: Vec<Ball<P>>) -> Self {
        let tree = Bvh::new(balls.iter().map(Ball::bounds).collect());
        Balls { balls, tree }
    }

    /// Returns `true` if at least one ball contains the point.
    pub fn hold(&self, x: P) -> bool {
        self.hold_counted(x, &mut Sweep::default())
    }

    /// Returns [`Balls::hold`], and counts the visits of the tree.
    pub(super) fn hold_counted(&self, x: P, visits: &mut Sweep) -> bool {
        let mut held = false;
        self.tree.visit_counted(&Bounds::of([x]), visits, |i| {
            held = self.balls[i as usize].holds(x);
            !held
        });
        held
    }

    /// Returns the indices of the balls that contain the point, in ascending order.
    pub fn holding(&self, x: P) -> Vec<u32> {
        self.holding_counted(x, &mut Sweep::default())
    }

    /// Returns [`Balls::holding`], and counts the visits of the tree.
    pub(super) fn holding_counted(&self, x: P, visits: &mut Sweep) -> Vec<u32> {
        let mut near = self.tree.meeting_counted(&Bounds::of([x]), visits);
        near.retain(|&i| self.balls[i as usize].holds(x));
        near
    }

    /// Returns all balls.
    pub fn all(&self) -> &[Ball<P>] {
        &self.balls
    }
}
