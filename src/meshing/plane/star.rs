//! The cells around a vertex.

use super::constrained::{Constrained, NONE};

/// Returns the corner after a corner of a triangle.
pub(super) fn next(corner: usize) -> usize {
    if corner == 2 { 0 } else { corner + 1 }
}

/// Returns the corner before a corner of a triangle.
pub(super) fn previous(corner: usize) -> usize {
    if corner == 0 { 2 } else { corner - 1 }
}

/// A walk around a vertex, counter-clockwise up to the hull, and then clockwise from the start.
pub(super) struct Star {
    vertex: u32,
    first: u32,
    at: u32,
    backwards: bool,
}

impl Star {
    /// Starts a walk around a vertex.
    pub(super) fn of(triangulation: &Constrained, vertex: u32) -> Walk<'_> {
        Walk { triangulation, star: Self::start(triangulation, vertex) }
    }

    /// Starts a walk that does not borrow the triangulation.
    pub(super) fn start(triangulation: &Constrained, vertex: u32) -> Self {
        let first = triangulation.at[vertex as usize];
        Star { vertex, first, at: first, backwards: false }
    }

    /// Returns the next cell and the corner of the vertex in it.
    pub(super) fn advance(&mut self, triangulation: &Constrained) -> Option<(u32, usize)> {
        if self.at == NONE {
            return None;
        }
        let cell = self.at;
        let corner = triangulation.cells[cell as usize].iter().position(|&v| v == self.vertex)?;
        let across = triangulation.across[cell as usize];
        self.at = if self.backwards { across[previous(corner)] } else { across[next(corner)] };
        if self.at == self.first {
            self.at = NONE;
        } else if self.at == NONE && !self.backwards {
            self.backwards = true;
            let first = triangulation.cells[self.first as usize];
            let corner = first.iter().position(|&v| v == self.vertex)?;
            self.at = triangulation.across[self.first as usize][previous(corner)];
        }
        Some((cell, corner))
    }
}

/// A walk that borrows the triangulation.
pub(super) struct Walk<'a> {
    triangulation: &'a Constrained,
    star: Star,
}

impl Iterator for Walk<'_> {
    type Item = (u32, usize);

    fn next(&mut self) -> Option<Self::Item> {
        self.star.advance(self.triangulation)
    }
}

impl Constrained {
    /// Returns the cells on the left and on the right of an edge. A cell is `None` if there is none, and both are if the
    /// vertices are not joined.
    pub fn beside(&self, a: u32, b: u32) -> [Option<u32>; 2] {
        for (cell, i) in Star::of(self, a) {
            let corners = self.cells[cell as usize];
            if corners[next(i)] == b {
                return [Some(cell), self.across(cell, previous(i))];
            }
            if corners[previous(i)] == b {
                return [self.across(cell, next(i)), Some(cell)];
            }
        }
        [None, None]
    }
}
