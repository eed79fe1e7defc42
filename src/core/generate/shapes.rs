//! Kinds without a size function: random sets, lattices and curves.
//!
//! **Work.** O(n), plus the choice of ten cluster centres.

use septet_geometry::point::Point;

use super::draw::{Draw, Purpose};
use super::kind::Kind;
use super::request::Request;
use super::rows::Rows;

/// Generates the points of a kind that is not f-spaced. The request must be checked.
pub(super) fn points<P: Point>(request: &Request) -> Vec<P> {
    if let Some(rows) = Rows::of(request) {
        return rows.range(0..rows.count);
    }
    let mut draw = Draw::new(request.seed, Purpose::Points);
    let many = |make: &mut dyn FnMut() -> P| (0..request.n).map(|_| make()).collect();
    match request.kind {
        Kind::Ball => many(&mut || centred(draw.in_ball())),
        Kind::Sphere => many(&mut || centred(draw.direction())),
        Kind::Line => {
            let (from, to) = (P::from_coords(&[0.125, 0.25, 0.375]), P::from_coords(&[0.875, 0.6, 0.8]));
            many(&mut || from + (to - from) * draw.unit() + draw.in_ball::<P>() / 1000.0)
        }
        Kind::Body => super::bodies::points(request.n, &mut draw),
        // The kinds of `Rows` have returned, and the module `spaced` generates the f-spaced kinds.
        _ => super::shells::points(request, &mut draw),
    }
}

/// Maps the ball of radius 1 about the origin into the unit cube.
fn centred<P: Point>(p: P) -> P {
    p * 0.5 + P::splat(0.5)
}
