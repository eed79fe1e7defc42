//! Axis-aligned bounding boxes of points: corners, unions and distances.

use crate::point::Point;

/// The low and the high corner of an axis-aligned box.
pub type Bounds<P> = (P, P);

/// Computes the bounding box of points. The box of no points is empty: its corners are infinite and reversed.
#[inline]
pub fn bounds<P: Point>(points: impl Iterator<Item = P>) -> Bounds<P> {
    let empty = (P::splat(f64::INFINITY), P::splat(f64::NEG_INFINITY));
    points.fold(empty, |b, p| join_bounds(b, (p, p)))
}

/// Computes the bounding box of two boxes.
#[inline]
pub fn join_bounds<P: Point>(a: Bounds<P>, b: Bounds<P>) -> Bounds<P> {
    let (mut low, mut high) = a;
    for i in 0..P::DIM {
        low.set_coord(i, low.coord(i).min(b.0.coord(i)));
        high.set_coord(i, high.coord(i).max(b.1.coord(i)));
    }
    (low, high)
}

/// Computes the squared distance from `x` to an axis-aligned box, by the expression of
/// [`dist2`](crate::point::dist2). It is never larger than the computed squared distance to a point of the box,
/// because rounding is monotone.
pub fn box_dist2<P: Point>(x: P, low: P, high: P) -> f64 {
    let mut d = P::splat(0.0);
    for i in 0..P::DIM {
        let gap = (low.coord(i) - x.coord(i)).max(x.coord(i) - high.coord(i)).max(0.0);
        d.set_coord(i, gap);
    }
    d.norm2()
}
