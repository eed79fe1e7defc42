//! Walks to a point: through cells, and over the walls of a patch.
//!
//! **Statement.** A walk leaves a cell through the first of the faces that separate it from the point (exact signs), as
//! the line from the first cell meets them. It ends in the cell that contains the point, or at a wall. A walk over a
//! patch does the same with the edges of triangles, by doubles, and ends at a kept edge.
//!
//! **Work and depth.** O(1) for each cell on the way.

use glam::DVec3;
use septet_geometry::predicates::{Sign, orientation};

use super::solid::{Side, Solid};
use crate::constrained::cells::NONE;
use crate::space::ascending;

/// The largest number of cells on a walk over a patch.
const LONGEST: usize = 1000;

/// The end of a walk through cells.
#[derive(Clone, Copy, Debug)]
pub(super) enum Walk {
    /// The cell that contains the point.
    Cell(u32),
    /// A wall on the way.
    Wall(Side),
}

/// The end of a walk over a patch.
#[derive(Clone, Copy, Debug)]
pub(super) enum FlatWalk {
    /// The wall that contains the point.
    Wall(Side),
    /// A kept edge on the way, with a cell at it.
    Edge(u32, [u32; 2]),
}

impl Solid {
    /// Walks from a cell to a point.
    pub(super) fn walk(&mut self, from: u32, to: DVec3) -> Option<Walk> {
        let middle = self.points(*self.corners(from)).iter().sum::<DVec3>() * 0.25;
        let mut cell = from;
        for _ in 0..self.rows.len() {
            self.visits += 1;
            let mut exit: Option<(f64, usize)> = None;
            for slot in 0..4 {
                let [a, b, c] = self.points(self.face(Side { cell, slot }));
                if orientation(&[a, b, c, to]) != Sign::Negative {
                    continue;
                }
                let normal = (b - a).cross(c - a);
                let (before, after) = (normal.dot(middle - a), normal.dot(to - a));
                let along = before / (before - after);
                if exit.is_none_or(|(first, _)| along < first) {
                    exit = Some((along, slot));
                }
            }
            let Some((_, slot)) = exit else { return Some(Walk::Cell(cell)) };
            let row = &self.rows[cell as usize];
            if row.walls[slot] != NONE || row.across[slot] == NONE {
                return Some(Walk::Wall(Side { cell, slot }));
            }
            cell = row.across[slot];
        }
        None
    }

    /// Walks from a wall to a point in its plane.
    pub(super) fn walk_flat(&mut self, from: Side, to: DVec3) -> Option<FlatWalk> {
        let mut side = from;
        for _ in 0..LONGEST {
            self.visits += 1;
            let face = self.face(side);
            let [a, b, c] = self.points(face);
            let normal = (b - a).cross(c - a);
            let middle = (a + b + c) / 3.0;
            let mut exit: Option<(f64, [u32; 2])> = None;
            for (ends, [s, t]) in [([0, 1], [a, b]), ([1, 2], [b, c]), ([2, 0], [c, a])] {
                let inwards = normal.cross(t - s);
                let (before, after) = (inwards.dot(middle - s), inwards.dot(to - s));
                if after < 0.0 && exit.is_none_or(|(first, _)| before / (before - after) < first) {
                    exit = Some((before / (before - after), ends.map(|i| face[i])));
                }
            }
            let Some((_, edge)) = exit else { return Some(FlatWalk::Wall(side)) };
            if self.kept.contains_key(&ascending(edge)) {
                return Some(FlatWalk::Edge(side.cell, edge));
            }
            side = self.next_wall(side, edge)?;
        }
        None
    }
}
