//! The order of walls along a line that crosses them.
//!
//! **Statement.** Along any axis, the point at which a line crosses a wall lies between the smallest and the largest
//! coordinate of the corners. From one end of the line to the other, each coordinate is monotone. *If all coordinates
//! of one wall along an axis precede the coordinates of another wall, the line therefore crosses the first wall
//! first.* This test compares input coordinates without rounding. If the ranges overlap, the fractions of
//! [`crate::exact`] decide. Both criteria order the same points on the line, so they agree. Together they give a
//! total order. Walls that are crossed at the same point are ordered by index.
//!
//! **Work and depth.** O(1) per comparison. Big integers are needed for walls with overlapping ranges, once per wall.

use std::cell::OnceCell;
use std::cmp::Ordering;

use septet_geometry::point::Point;

use crate::exact::Fraction;

/// The segment that crosses the walls, and its dominant axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<P> {
    from: P,
    to: P,
    axis: usize,
}

impl<P: Point> Line<P> {
    pub(crate) fn through(from: P, to: P) -> Self {
        let along = |i: usize| (to.coord(i) - from.coord(i)).abs();
        Line { from, to, axis: (1..P::DIM).fold(0, |k, i| if along(i) > along(k) { i } else { k }) }
    }
}

/// A wall that a line crosses in its interior.
#[derive(Clone, Debug)]
pub(crate) struct CrossedWall<P> {
    pub(crate) wall: u32,
    line: Line<P>,
    corners: Vec<P>,
    /// The range of its corners along the axis of the line, with the sign flipped if the line runs in the negative
    /// direction.
    range: [f64; 2],
    place: OnceCell<Fraction>,
}

impl<P: Point> CrossedWall<P> {
    pub(crate) fn new(wall: u32, line: Line<P>, corners: Vec<P>) -> Self {
        let falls = line.to.coord(line.axis) < line.from.coord(line.axis);
        let range = corners.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], corner| {
            let at = corner.coord(line.axis);
            let at = if falls { -at } else { at };
            [low.min(at), high.max(at)]
        });
        CrossedWall { wall, line, corners, range, place: OnceCell::new() }
    }

    fn place(&self) -> &Fraction {
        self.place.get_or_init(|| Fraction::crossing(&self.corners, self.line.from, self.line.to))
    }

    /// Compares two walls on the same line by the order in which it crosses them.
    pub(crate) fn order(&self, other: &Self) -> Ordering {
        if self.range[1] < other.range[0] {
            Ordering::Less
        } else if other.range[1] < self.range[0] {
            Ordering::Greater
        } else {
            self.place().cmp(other.place()).then(self.wall.cmp(&other.wall))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};
    use septet_geometry::hash::Draw;

    #[test]
    fn walls_apart_come_in_the_order_of_fractions() {
        let (mut draw, mut apart) = (Draw::new(3), 0);
        for (from, to) in [(-2.0, 2.0), (2.0, -2.0)] {
            let line = Line::through(DVec3::new(0.01, 0.02, from), DVec3::new(-0.03, 0.05, to));
            let mut wall = |number| {
                let (z, tilt) = (2.0 * draw.unit() - 1.0, 0.3 * draw.unit());
                let corner = |x: f64, y: f64| DVec3::new(x, y, z + tilt * x);
                CrossedWall::new(number, line, vec![corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.0, 0.5)])
            };
            let walls: Vec<CrossedWall<DVec3>> = (0..60).map(&mut wall).collect();
            let mut sorted = walls.clone();
            sorted.sort_by(CrossedWall::order);
            assert!(sorted.windows(2).all(|w| w[0].place() <= w[1].place()));
            apart += walls.iter().filter(|a| a.range[1] < sorted[59].range[0]).count();
        }
        assert!(apart > 20, "{apart}");
    }

    #[test]
    fn one_wall_apart_needs_no_fraction() {
        let line = Line::through(DVec2::new(0.0, 0.0), DVec2::new(4.0, 1.0));
        let wall =
            |number, x: f64| CrossedWall::new(number, line, vec![DVec2::new(x, -1.0), DVec2::new(x, 2.0)]);
        let (near, far) = (wall(5, 1.0), wall(2, 1.0_f64.next_up()));
        assert!(near.order(&far).is_lt() && far.order(&near).is_gt());
        assert!(near.place.get().is_none() && far.place.get().is_none());
        assert!(wall(2, 1.0).order(&near).is_lt());
    }
}
