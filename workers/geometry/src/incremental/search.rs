//! Point location: a walk to a cell in conflict with a point.
//!
//! **Statement.** The powers of a point with respect to the circumspheres of two neighbouring cells differ by a linear
//! function that is zero on their common facet. So the point lies on the side of the cell with the smaller power.
//!
//! 1. *Descent.* Moving to the neighbour with the smallest power is a visibility walk that reads no coordinates of
//!    vertices. With rounded spheres, each step decreases the computed power, so the descent terminates. It may end in
//!    a wrong cell, and it does not leave the hull.
//! 2. *Walk.* A walk by exact orientations follows. It leaves a cell through any facet that separates the cell from the
//!    point, and never returns to a cell. In every regular triangulation, the order of cells from front to back, seen
//!    from any viewpoint, is acyclic (Edelsbrunner 1990). This fact also holds under the perturbation of
//!    [`crate::predicates`].
//!
//! **Departures.** An insertion needs a cell in conflict with the point, not the cell that contains it, so the descent
//! ends at the first cell in conflict. A point that coincides with a vertex lies inside no sphere. For such a point,
//! the walk continues to the cell that contains it.
//!
//! **Work.** Proportional to the number of cells visited.

use super::read::corners;
use super::sphere::Query;
use super::triangulation::Incremental;
use crate::cost::Sweep;
use crate::point::{Point, Simplex};
use crate::predicates::{Sign, orientation};

impl<P: Point> Incremental<P> {
    /// Finds the finite cell whose closure contains `q`, or an infinite cell whose hull facet `q` lies beyond. The walk
    /// starts at the cell `hint` if it is live, and otherwise at the last cell created.
    pub fn locate(&self, q: P, hint: Option<u32>) -> u32 {
        let visited = &mut Sweep::default();
        let (near, _) = self.descend(&self.frame.query(q), self.start_of(hint), visited);
        self.walk(q, near, visited)
    }

    pub(super) fn start_of(&self, hint: Option<u32>) -> u32 {
        match hint {
            Some(cell) if cell < self.cells.slots() && self.cells.is_live(cell) => cell,
            _ => self.last,
        }
    }

    /// Descends by powers from `start`. Returns a cell, and whether its sphere certainly contains the point. If it
    /// does not, no neighbour of the cell has a smaller power. Counts the cells visited.
    #[inline(never)]
    pub(super) fn descend(&self, query: &Query<P>, start: u32, visited: &mut Sweep) -> (u32, bool) {
        let slots = &self.cells.slots[..];
        let mut cell = start;
        let mut best = query.power(&slots[start as usize]);
        if best.value.is_nan() {
            best.value = f32::INFINITY;
        }
        loop {
            visited.visit();
            if best.is_inside() {
                return (cell, true);
            }
            let here = cell;
            for &code in slots[here as usize].neighbours().as_ref() {
                let power = query.power(&slots[(code >> 2) as usize]);
                if power.value < best.value {
                    (cell, best) = (code >> 2, power);
                }
            }
            if cell == here {
                return (cell, false);
            }
        }
    }

    /// Walks by exact orientations to the cell that contains `q`. Counts the cells visited.
    #[inline(never)]
    pub(super) fn walk(&self, q: P, start: u32, visited: &mut Sweep) -> u32 {
        let n = P::Cell::LEN;
        let mut entered = n;
        let mut cell = match self.cells.infinite_slot(start) {
            Some(slot) => self.cells.neighbour(start, slot).0,
            None => start,
        };
        'walk: loop {
            visited.visit();
            let mut corners = corners(&self.points, self.cells.cell(cell));
            for slot in (0..n).filter(|&slot| slot != entered) {
                let corner = std::mem::replace(&mut corners[slot], q);
                if orientation(&corners[..n]) == Sign::Negative {
                    let (next, back) = self.cells.neighbour(cell, slot);
                    if self.cells.is_infinite(next) {
                        return next;
                    }
                    (cell, entered) = (next, back);
                    continue 'walk;
                }
                corners[slot] = corner;
            }
            return cell;
        }
    }
}
