//! A point that may be in a star, with its image.

use super::planes::Image;
use crate::complex::INFINITE;
use crate::point::Point;

/// A point that may be in the star.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate<P> {
    pub(super) image: Image<P>,
    pub(super) at: P,
    /// Its position in the table.
    pub(super) id: u32,
}

impl<P: Point> Candidate<P> {
    /// A point of the table, as seen from a centre.
    pub(super) fn of(table: &[P], id: u32, centre: P) -> Self {
        let at = table[id as usize];
        let rel = at - centre;
        Candidate { image: Image::of(rel, rel.norm2()), at, id }
    }

    /// The vertex at infinity.
    pub(super) fn infinity() -> Self {
        Candidate { image: Image::of_infinity(), at: P::default(), id: INFINITE }
    }
}

/// The candidate of a vertex of the link.
#[inline]
pub(super) fn candidate<P: Point>(points: &[Candidate<P>], vertex: u32) -> &Candidate<P> {
    &points[vertex.wrapping_add(1) as usize]
}
