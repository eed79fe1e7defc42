//! Cells of the triangulation, by the local indices of their vertices.

use septet_geometry::complex::INFINITE;
use septet_geometry::point::{Point, Simplex, lex_cmp};

/// The cell of a vertex and a facet of its link, or `None` if it is infinite.
pub(crate) fn finite_cell<P: Point>(centre: u32, facet: &P::Facet) -> Option<P::Cell> {
    let mut cell = P::Cell::splat(centre);
    for (slot, &v) in facet.as_ref().iter().enumerate() {
        if v == INFINITE {
            return None;
        }
        cell.as_mut()[slot + 1] = v;
    }
    Some(cell)
}

/// The cell with its vertices sorted by index, for comparison.
pub(crate) fn in_order<P: Point>(cell: &P::Cell) -> P::Cell {
    let mut ordered = *cell;
    ordered.as_mut().sort_unstable();
    ordered
}

/// The lexicographically smallest finite vertex, or [`INFINITE`] if there is none.
pub(crate) fn smallest_of<P: Point>(positions: &[P], vertices: impl IntoIterator<Item = u32>) -> u32 {
    let at = |v: u32| &positions[v as usize];
    let smaller = |best: u32, v: u32| best == INFINITE || (v != INFINITE && lex_cmp(at(v), at(best)).is_lt());
    vertices.into_iter().fold(INFINITE, |best, v| if smaller(best, v) { v } else { best })
}

/// A search for the lexicographically smallest of some vertices by their first coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smallest<C> {
    /// The vertex with the smallest first coordinate so far.
    vertex: u32,
    /// Its first coordinate.
    first: C,
    /// Whether two first coordinates were equal, so that they may not decide.
    is_tied: bool,
}

impl<C: PartialOrd + Copy> Smallest<C> {
    /// Starts with a vertex and its first coordinate.
    #[inline]
    pub(crate) fn of(vertex: u32, first: C) -> Self {
        Smallest { vertex, first, is_tied: false }
    }

    /// Adds a vertex.
    #[inline]
    pub(crate) fn look(&mut self, vertex: u32, first: C) {
        self.is_tied |= first == self.first;
        (self.vertex, self.first) =
            if first < self.first { (vertex, first) } else { (self.vertex, self.first) };
    }

    /// The smallest vertex. If first coordinates do not decide, `compare` finds it ([`smallest_of`]).
    #[inline]
    pub(crate) fn vertex(self, compare: impl FnOnce() -> u32) -> u32 {
        if self.is_tied { compare() } else { self.vertex }
    }
}
