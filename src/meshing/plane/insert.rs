//! Insertion of a point: the cells that see it and whose circles contain it.
//!
//! **Statement.** A cell other than the one that contains the point is in conflict with it only if the point lies beyond
//! exactly one of its edges. So a search from the first cell that does not cross constraints reaches exactly the cells
//! in conflict that see the point. Each edge of the region that they form sees the point from inside.
//!
//! *Proof.* If the point lies beyond two edges of a cell, or beyond one and on the line of another, it lies opposite a
//! corner and therefore not inside the circle. So the search enters a cell through its only edge towards the point, and
//! every sight line from the point to the cell crosses this edge. By induction it crosses no constraint.

use glam::DVec2;
use septet_geometry::predicates::{Sign, in_sphere, orientation};

use super::constrained::{Constrained, NONE, TAKEN};
use super::star::{next, previous};

/// The cells in conflict with a point, and the edges around them: a cell and the corner opposite.
#[derive(Clone, Debug, Default)]
pub(super) struct Conflicts {
    pub(super) cells: Vec<u32>,
    pub(super) boundary: Vec<(u32, usize)>,
}

/// An edge around the cells in conflict.
struct Side {
    ends: [u32; 2],
    beyond: u32,
    corner: usize,
    is_constrained: bool,
    component: u32,
}

impl Constrained {
    /// Whether the point lies strictly inside the one or two cells beside an edge, or on the edge up to rounding.
    pub(super) fn is_inside_quad(&mut self, cell: u32, corner: usize, at: DVec2) -> bool {
        let beyond = self.across(cell, corner).map(|other| (other, self.corner_towards(other, cell)));
        [Some((cell, corner)), beyond].into_iter().flatten().all(|(cell, corner)| {
            let corners = self.cells[cell as usize];
            let [v, a, b] = [corner, next(corner), previous(corner)].map(|i| self.point(corners[i]));
            self.work += 2;
            [[v, a], [b, v]].iter().all(|&[p, q]| orientation(&[p, q, at]) == Sign::Positive)
        })
    }

    /// Returns the cells in conflict with a point, from the cells that contain it.
    pub(super) fn conflicts_of(&mut self, at: DVec2, seeds: &[Option<u32>]) -> Conflicts {
        let mut found = Conflicts { cells: seeds.iter().flatten().copied().collect(), boundary: Vec::new() };
        for &cell in &found.cells {
            self.marks[cell as usize] |= TAKEN;
        }
        let mut number = 0;
        while let Some(&cell) = found.cells.get(number) {
            number += 1;
            for corner in 0..3 {
                let other = self.across[cell as usize][corner];
                if other == NONE {
                    found.boundary.push((cell, corner));
                    continue;
                }
                if self.marks[other as usize] & TAKEN != 0 {
                    continue;
                }
                self.work += 1;
                let corners = self.cells[other as usize].map(|v| self.point(v));
                if !self.is_constrained(cell, corner) && in_sphere(&corners, at) {
                    self.marks[other as usize] |= TAKEN;
                    found.cells.push(other);
                } else {
                    found.boundary.push((cell, corner));
                }
            }
        }
        for &cell in &found.cells {
            self.marks[cell as usize] &= !TAKEN;
        }
        found
    }

    /// Replaces the cells in conflict by the triangles of the point with the edges around them. If the point divides a
    /// subsegment, its ends are given. Returns the new cells, or `None` if rounding of the point forbids it.
    pub(super) fn insert(
        &mut self,
        at: DVec2,
        conflicts: &Conflicts,
        divided: Option<[u32; 2]>,
        components: &mut Vec<u32>,
    ) -> Option<Vec<u32>> {
        let is_end = |v: u32| divided.is_some_and(|ends| ends.contains(&v));
        let mut sides = Vec::with_capacity(conflicts.boundary.len());
        for &(cell, corner) in &conflicts.boundary {
            let corners = self.cells[cell as usize];
            let ends = [corners[next(corner)], corners[previous(corner)]];
            if ends.into_iter().all(is_end) {
                continue;
            }
            if self.side_of(ends, at) != Sign::Positive {
                return None;
            }
            let beyond = self.across[cell as usize][corner];
            sides.push(Side {
                ends,
                beyond,
                corner: if beyond == NONE { 0 } else { self.corner_towards(beyond, cell) },
                is_constrained: self.is_constrained(cell, corner),
                component: components[cell as usize],
            });
        }
        let vertex = self.points.len() as u32;
        self.points.push(at);
        self.at.push(NONE);
        let new: Vec<u32> = (0..sides.len()).map(|i| self.slot(conflicts, i, components)).collect();
        let order = |end: usize| {
            let mut order: Vec<(u32, u32)> = sides.iter().zip(&new).map(|(s, &c)| (s.ends[end], c)).collect();
            order.sort_unstable();
            order
        };
        let (starts, stops) = (order(0), order(1));
        let with =
            |list: &[(u32, u32)], v: u32| list.binary_search_by_key(&v, |e| e.0).map_or(NONE, |i| list[i].1);
        for (side, &cell) in sides.iter().zip(&new) {
            let [u, v] = side.ends;
            self.cells[cell as usize] = [u, v, vertex];
            self.across[cell as usize] = [with(&starts, v), with(&stops, u), side.beyond];
            let bits = [is_end(v), is_end(u), side.is_constrained];
            self.marks[cell as usize] = (0..3).map(|i| u8::from(bits[i]) << i).sum();
            components[cell as usize] = side.component;
            if side.beyond != NONE {
                self.across[side.beyond as usize][side.corner] = cell;
            }
            for w in [u, v, vertex] {
                self.at[w as usize] = cell;
            }
        }
        Some(new)
    }

    fn side_of(&mut self, [a, b]: [u32; 2], at: DVec2) -> Sign {
        self.work += 1;
        orientation(&[self.point(a), self.point(b), at])
    }

    /// Returns a cell that is in conflict, or a new one.
    fn slot(&mut self, conflicts: &Conflicts, number: usize, components: &mut Vec<u32>) -> u32 {
        conflicts.cells.get(number).copied().unwrap_or_else(|| {
            self.cells.push([0; 3]);
            self.across.push([NONE; 3]);
            self.marks.push(0);
            components.push(0);
            self.cells.len() as u32 - 1
        })
    }
}
