//! The sides of points of a separator, with the numbers and the boxes of the points on both sides.

use septet_geometry::cost::Cost;
use septet_geometry::point::Point;
use septet_geometry::separator::{Separator, Side};

use crate::state::tree::{Bounds, bounds};

/// The side of each point, the number of points inside the separator, and the boxes of both sides.
pub(crate) struct Sides<P> {
    pub(crate) of: Vec<u8>,
    pub(crate) inside: u64,
    pub(crate) boxes: [Bounds<P>; 2],
}

/// Performs the steps of a member in an attempt. Copies the separator to every point (a copy-scan), computes the side
/// of every point (a vector step), and combines counts and boxes (a scan).
pub(crate) fn sides_of<P: Point>(separator: &Separator<P>, points: &[P], cost: &mut Cost) -> Sides<P> {
    let sides = cost.map_with(separator, points, |s, &x| u8::from(s.side(x) == Side::Exterior));
    let mut inside = 0;
    let empty = bounds(std::iter::empty::<P>());
    let mut side_of = sides.iter();
    let boxes = cost.reduce(points, [empty, empty], |mut boxes, &x| {
        let interior = side_of.next() == Some(&0);
        inside += u64::from(interior);
        for i in 0..P::DIM {
            // Both boxes are updated, one of them with a neutral value, because branches on the side would mispredict.
            let at = x.coord(i);
            let [(low, high), (far_low, far_high)] = &mut boxes;
            low.set_coord(i, less(low.coord(i), if interior { at } else { f64::INFINITY }));
            high.set_coord(i, more(high.coord(i), if interior { at } else { f64::NEG_INFINITY }));
            far_low.set_coord(i, less(far_low.coord(i), if interior { f64::INFINITY } else { at }));
            far_high.set_coord(i, more(far_high.coord(i), if interior { f64::NEG_INFINITY } else { at }));
        }
        boxes
    });
    Sides { of: sides, inside, boxes }
}

/// Returns the smaller of two numbers, in one instruction.
#[inline]
fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the larger of two numbers, in one instruction.
#[inline]
fn more(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
