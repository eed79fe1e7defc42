//! A candidate for the star, with its inverse image.

use super::planes::Image;
use crate::complex::INFINITE;
use crate::point::Point;
use crate::site::largest_low;

/// A point that may belong to the star.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate<P> {
    pub(super) image: Image<P>,
    pub(super) at: P,
    /// Position of the point in the table.
    pub(super) id: u32,
}

impl<P: Point> Candidate<P> {
    /// Creates the candidate of a table position, with its image under inversion around `centre`.
    pub(super) fn of(table: &[P], id: u32, centre: P) -> Self {
        let at = table[id as usize];
        let rel = at - centre;
        let image = if P::IS_WEIGHTED {
            Image::of_site(rel, largest_low(&[at, centre]))
        } else {
            Image::of(rel, rel.norm2())
        };
        Candidate { image, at, id }
    }

    /// Creates the candidate for the vertex at infinity.
    pub(super) fn infinity() -> Self {
        Candidate { image: Image::of_infinity(), at: P::default(), id: INFINITE }
    }
}

/// Returns the candidate of a vertex of the link.
#[inline]
pub(super) fn candidate<P: Point>(points: &[Candidate<P>], vertex: u32) -> &Candidate<P> {
    &points[vertex.wrapping_add(1) as usize]
}
