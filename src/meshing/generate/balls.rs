//! Balls that hold no vertex: the smallest ones of segments' pieces and of facets' triangles.

use septet_geometry::point::{Point, dist2};

use crate::bvh::{Bounds, Bvh};

/// The smallest ball through the corners of a piece or of a facet's triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball<P> {
    /// Its centre.
    pub centre: P,
    /// Its squared radius.
    pub radius2: f64,
}

impl<P: Point> Ball<P> {
    /// Does it hold the place strictly, beyond what rounding may have done to its own corners?
    pub fn holds(&self, x: P) -> bool {
        dist2(self.centre, x) < self.radius2 * (1.0 - 1e-10)
    }

    pub(super) fn bounds(&self) -> Bounds<P> {
        let half = P::splat(self.radius2.sqrt() * (1.0 + 1e-12));
        Bounds { low: self.centre - half, high: self.centre + half }
    }
}

/// Balls to be asked.
#[derive(Clone, Debug)]
pub struct Balls<P> {
    balls: Vec<Ball<P>>,
    tree: Bvh<P>,
}

impl<P: Point> Balls<P> {
    /// Makes them ready.
    pub fn new(balls: Vec<Ball<P>>) -> Self {
        let tree = Bvh::new(balls.iter().map(Ball::bounds).collect());
        Balls { balls, tree }
    }

    /// Does some ball hold the place?
    pub fn hold(&self, x: P) -> bool {
        let mut held = false;
        self.tree.visit(&Bounds::of([x]), |i| {
            held = self.balls[i as usize].holds(x);
            !held
        });
        held
    }

    /// The balls that hold the place, ascending.
    pub fn holding(&self, x: P) -> Vec<u32> {
        let mut near = self.tree.meeting(&Bounds::of([x]));
        near.retain(|&i| self.balls[i as usize].holds(x));
        near
    }

    /// All of them.
    pub fn all(&self) -> &[Ball<P>] {
        &self.balls
    }
}
