//! Removal of the points that recovery added to edges of the input, where the cells allow it.
//!
//! **Statement.** A point v on a kept edge moves to the vertex a before or after it on that edge. The cells that
//! contain both vanish, and v becomes a in the others. The change is made if these cells are positive and not flat.
//! *The cells then tile the same region*: on each side of every patch, the cells at v fill a polyhedron that has a on
//! its boundary. If all faces of this polyhedron away from a see it, cells with the apex a tile the polyhedron.
//!
//! **Source.** Removal of Steiner points: George, Borouchaki and Saltel (2003).
//!
//! **Work and depth.** Sequential: O(k^2) for k cells at a point, for each attempt.

use std::collections::BTreeMap;

use super::cavity::is_thick;
use super::solid::{FREE, Side, Solid};
use crate::constrained::cells::NONE;
use crate::space::ascending;

/// The largest number of passes over all points.
const PASSES: u32 = 20;

impl Solid {
    /// Removes vertices that follow the first `given` ones, where possible. Returns their number.
    pub(in crate::constrained) fn collapse(&mut self, given: u32) -> u64 {
        let mut anchors = vec![NONE; self.at.len()];
        for (cell, row) in (0u32..).zip(&self.rows) {
            for &v in row.corners.iter().filter(|_| row.corners[0] != NONE) {
                anchors[v as usize] = cell;
            }
        }
        let mut beside: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &[a, b] in self.kept.keys() {
            for (v, other) in [(a, b), (b, a)] {
                if v >= given {
                    beside.entry(v).or_default().push(other);
                }
            }
        }
        let mut removed = 0;
        for _ in 0..PASSES {
            let before = removed;
            for v in (given..self.at.len() as u32).rev() {
                let Some(&[a, b]) = beside.get(&v).map(Vec::as_slice) else { continue };
                if self.fans.contains_key(&ascending([v, a])) {
                    continue;
                }
                let length = |w: u32| self.at[w as usize].distance_squared(self.at[v as usize]);
                let order = if length(b) < length(a) { [b, a] } else { [a, b] };
                let Some(to) = order.into_iter().find(|&to| self.merge(v, to, &mut anchors)) else {
                    continue;
                };
                let from = if to == a { b } else { a };
                self.rejoin(v, [to, from], &mut beside);
                removed += 1;
            }
            if removed == before {
                break;
            }
        }
        // The cells of fans may have vanished.
        self.find_fans();
        removed
    }

    /// Replaces the two kept edges at a removed vertex by one.
    fn rejoin(&mut self, v: u32, [a, b]: [u32; 2], beside: &mut BTreeMap<u32, Vec<u32>>) {
        let line = self.kept.remove(&ascending([v, a]));
        self.kept.remove(&ascending([v, b]));
        if let Some(line) = line {
            self.kept.insert(ascending([a, b]), line);
        }
        self.gone[v as usize] = true;
        beside.remove(&v);
        for (end, other) in [(a, b), (b, a)] {
            for w in beside.get_mut(&end).into_iter().flatten().filter(|w| **w == v) {
                *w = other;
            }
        }
    }

    /// Returns the cells at a vertex.
    fn star(&self, v: u32, first: u32) -> Vec<u32> {
        let mut found = vec![first];
        let mut next = 0;
        while next < found.len() {
            let row = &self.rows[found[next] as usize];
            for slot in 0..4 {
                let other = row.across[slot];
                if row.corners[slot] != v && other != NONE && !found.contains(&other) {
                    found.push(other);
                }
            }
            next += 1;
        }
        found
    }

    /// Moves a vertex to another one at an edge, if the cells allow it. Returns whether they do.
    fn merge(&mut self, v: u32, to: u32, anchors: &mut [u32]) -> bool {
        if anchors[v as usize] == NONE {
            return false;
        }
        let star = self.star(v, anchors[v as usize]);
        let (gone, stay): (Vec<u32>, Vec<u32>) = star.iter().partition(|&&c| self.corners(c).contains(&to));
        if gone.is_empty() || !stay.iter().all(|&c| self.is_good_with(c, v, to)) {
            return false;
        }
        let joints: Vec<Option<[Side; 2]>> = gone.iter().map(|&c| self.joint(c, [v, to])).collect();
        if joints.iter().any(Option::is_none) {
            return false;
        }
        for &cell in &stay {
            let row = &mut self.rows[cell as usize];
            row.corners = row.corners.map(|w| if w == v { to } else { w });
        }
        for &cell in &gone {
            self.close(cell, [v, to]);
        }
        for &cell in &gone {
            self.rows[cell as usize] = FREE;
            self.free.push(cell);
        }
        for &cell in &stay {
            for &w in &self.rows[cell as usize].corners {
                anchors[w as usize] = cell;
            }
        }
        true
    }

    /// Returns whether a cell is positive and not flat if a vertex moves to another one.
    fn is_good_with(&self, cell: u32, v: u32, to: u32) -> bool {
        is_thick(self.points(self.corners(cell).map(|w| if w == v { to } else { w })))
    }

    /// Returns the faces of the cells beyond the two faces that become one, if neither is a wall.
    fn joint(&self, cell: u32, ends: [u32; 2]) -> Option<[Side; 2]> {
        let row = &self.rows[cell as usize];
        let mut sides = [Side { cell: NONE, slot: 0 }; 2];
        for (side, v) in sides.iter_mut().zip(ends) {
            let slot = row.corners.iter().position(|&w| w == v)?;
            let other = row.across[slot];
            if row.walls[slot] != NONE || other == NONE {
                return None;
            }
            let back = self.rows[other as usize].across.iter().position(|&c| c == cell)?;
            *side = Side { cell: other, slot: back };
        }
        (sides[0].cell != sides[1].cell).then_some(sides)
    }

    /// Joins the cells beyond the two faces of a cell that become one.
    fn close(&mut self, cell: u32, ends: [u32; 2]) {
        if let Some([a, b]) = self.joint(cell, ends) {
            self.rows[a.cell as usize].across[a.slot] = b.cell;
            self.rows[b.cell as usize].across[b.slot] = a.cell;
        }
    }
}
