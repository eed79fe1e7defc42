//! The triangulation: cells, adjacency and constrained edges.

use glam::DVec2;
use septet_geometry::predicates::{Sign, in_sphere, orientation};

use super::chain::Cavity;
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
    pub(super) cavity: Cavity,
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
