//! The triangulation: cells, adjacency and constrained edges.

use std::cmp::Ordering;

use glam::DVec2;
use septet_geometry::point::lex_cmp;
use septet_geometry::predicates::{Sign, in_sphere, orientation};

use super::cavity::Cavity;
use super::star::{Star, next, previous};
use crate::generate::Delaunay;

/// No cell.
pub(super) const NONE: u32 = u32::MAX;

/// The mark of a cell that a segment crosses.
pub(super) const TAKEN: u8 = 8;

/// A constrained Delaunay triangulation of points in the plane.
#[derive(Clone, Debug)]
pub struct Constrained {
    pub(super) points: Vec<DVec2>,
    /// Counter-clockwise corners.
    pub(super) cells: Vec<[u32; 3]>,
    /// The cell across the edge opposite each corner, or [`NONE`].
    pub(super) across: Vec<[u32; 3]>,
    /// Bit `i` is set if the edge opposite corner `i` is constrained. The highest one is [`TAKEN`].
    pub(super) marks: Vec<u8>,
    /// A cell of each vertex, or [`NONE`].
    pub(super) at: Vec<u32>,
    /// The number of predicates evaluated and cells visited.
    pub(super) work: u64,
    /// Memory for the polygons beside a segment.
    cavity: Cavity,
}

/// The error for a segment that crosses an earlier one, whose ends are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossed(pub [u32; 2]);

impl Constrained {
    /// Starts from the Delaunay triangulation of distinct points.
    pub fn new(points: Vec<DVec2>, delaunay: Delaunay<[u32; 3]>) -> Self {
        let Delaunay { cells, neighbours: across } = delaunay;
        let mut at = vec![NONE; points.len()];
        for (number, cell) in (0u32..).zip(&cells) {
            for &v in cell {
                at[v as usize] = number;
            }
        }
        let marks = vec![0; cells.len()];
        Constrained { points, cells, across, marks, at, work: 0, cavity: Cavity::default() }
    }

    /// Returns the points.
    pub fn points(&self) -> &[DVec2] {
        &self.points
    }

    /// Returns the counter-clockwise corners of the cells.
    pub fn cells(&self) -> &[[u32; 3]] {
        &self.cells
    }

    /// Returns the number of predicates that were evaluated and of cells that were visited so far.
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Returns the cell across the edge opposite a corner, or `None` on the hull.
    pub fn across(&self, cell: u32, corner: usize) -> Option<u32> {
        Some(self.across[cell as usize][corner]).filter(|&c| c != NONE)
    }

    /// Whether the edge opposite a corner is constrained.
    pub fn is_constrained(&self, cell: u32, corner: usize) -> bool {
        self.marks[cell as usize] & (1 << corner) != 0
    }

    /// Returns the cells and their adjacency.
    pub fn into_delaunay(self) -> Delaunay<[u32; 3]> {
        Delaunay { cells: self.cells, neighbours: self.across }
    }

    pub(super) fn point(&self, v: u32) -> DVec2 {
        self.points[v as usize]
    }

    /// Returns the side of a vertex seen along a segment.
    pub(super) fn side(&mut self, [a, b]: [u32; 2], v: u32) -> Sign {
        self.work += 1;
        orientation(&[self.point(a), self.point(b), self.point(v)])
    }

    /// Whether `v` lies in the perturbed circle of the counter-clockwise triangle.
    pub(super) fn conflicts(&mut self, [a, b, c]: [u32; 3], v: u32) -> bool {
        self.work += 1;
        in_sphere(&[self.point(a), self.point(b), self.point(c)], self.point(v))
    }

    /// Returns the corner of a cell that lies opposite another cell.
    pub(super) fn corner_towards(&self, cell: u32, other: u32) -> usize {
        self.across[cell as usize].iter().position(|&c| c == other).unwrap_or(0)
    }

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

    /// Marks all cells that the seeds reach without crossing a constraint with the labels of the seeds. Other cells
    /// receive `rest`.
    pub fn flood(&self, seeds: impl IntoIterator<Item = (u32, u32)>, rest: u32) -> Vec<u32> {
        let mut labels = vec![rest; self.cells.len()];
        let mut seen = vec![false; self.cells.len()];
        let mut stack = Vec::new();
        for (seed, label) in seeds {
            if std::mem::replace(&mut seen[seed as usize], true) {
                continue;
            }
            stack.push(seed);
            while let Some(cell) = stack.pop() {
                labels[cell as usize] = label;
                for corner in 0..3 {
                    let other = self.across(cell, corner).filter(|_| !self.is_constrained(cell, corner));
                    if let Some(other) = other
                        && !std::mem::replace(&mut seen[other as usize], true)
                    {
                        stack.push(other);
                    }
                }
            }
        }
        labels
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
