//! Insertion of a segment into the triangulation.

use std::cmp::Ordering;

use septet_geometry::point::lex_cmp;
use septet_geometry::predicates::Sign;

use super::constrained::{Constrained, Crossed};
use super::star::{Star, next, previous};

impl Constrained {
    /// Marks the edge opposite a corner as a constraint, on both sides.
    fn fix(&mut self, cell: u32, corner: usize) {
        self.marks[cell as usize] |= 1 << corner;
        if let Some(other) = self.across(cell, corner) {
            let back = self.corner_towards(other, cell);
            self.marks[other as usize] |= 1 << back;
        }
    }

    /// Turns the segment between two vertices into constraints, divided at the vertices on it.
    ///
    /// # Errors
    /// Returns the constraint that it crosses. The part up to the last vertex before the crossing is then constrained.
    pub fn constrain(&mut self, from: u32, to: u32) -> Result<(), Crossed> {
        let mut at = from;
        while at != to {
            at = self.constrain_step(at, to)?;
        }
        Ok(())
    }

    /// Adds the constraint up to the first vertex on the segment, and returns that vertex.
    fn constrain_step(&mut self, from: u32, to: u32) -> Result<u32, Crossed> {
        let direct = Star::of(self, from).find_map(|(cell, i)| {
            let corners = self.cells[cell as usize];
            let along = |j: usize, edge: usize| (corners[j] == to).then_some((cell, edge));
            along(next(i), previous(i)).or_else(|| along(previous(i), next(i)))
        });
        if let Some((cell, edge)) = direct {
            self.work += 1;
            self.fix(cell, edge);
            return Ok(to);
        }
        let (cell, i) = match self.opening(from, to) {
            Opening::Vertex { cell, edge, vertex } => {
                self.fix(cell, edge);
                return Ok(vertex);
            }
            Opening::Cell { cell, corner } => (cell, corner),
            Opening::None => return Err(Crossed([from, to])),
        };
        let mut cavity = std::mem::take(&mut self.cavity);
        let end = cavity.march(self, [from, to], (cell, i));
        if end.is_ok() {
            cavity.fill(self);
        }
        self.cavity = cavity;
        end
    }

    /// Finds the cell at `from` through which the segment leaves, or a vertex ahead on it.
    fn opening(&mut self, from: u32, to: u32) -> Opening {
        let ahead = lex_cmp(&self.point(from), &self.point(to));
        let mut walk = Star::start(self, from);
        while let Some((cell, i)) = walk.advance(self) {
            let corners = self.cells[cell as usize];
            let (u, v) = (corners[next(i)], corners[previous(i)]);
            let is_ahead = |this: &Self, w: u32| lex_cmp(&this.point(from), &this.point(w)) == ahead;
            match (self.side([from, to], u), self.side([from, to], v)) {
                (Sign::Zero, _) if is_ahead(self, u) => {
                    return Opening::Vertex { cell, edge: previous(i), vertex: u };
                }
                (_, Sign::Zero) if is_ahead(self, v) => {
                    return Opening::Vertex { cell, edge: next(i), vertex: v };
                }
                (Sign::Negative, Sign::Positive) => return Opening::Cell { cell, corner: i },
                _ => {}
            }
        }
        debug_assert_ne!(ahead, Ordering::Equal, "points are distinct");
        Opening::None
    }
}

/// The way of a segment out of its first vertex.
enum Opening {
    /// Along an edge to a vertex on the segment.
    Vertex { cell: u32, edge: usize, vertex: u32 },
    /// Through the edge opposite the corner of a cell.
    Cell { cell: u32, corner: usize },
    /// No cell lies there.
    None,
}
