//! Finding a cell for a point.
//!
//! **Statement.** The powers of a point with respect to the circumspheres of two neighbours differ by a
//! linear function that vanishes on their facet: the point lies on the side of the cell with the smaller
//! power. So going to the neighbour with the smallest power is a visibility walk that reads no
//! coordinates of vertices. With rounded spheres each step lowers a number, so the descent ends; it need
//! not end in the right cell, and does not past the hull, so a walk by exact orientations follows. That
//! leaves a cell through any facet that separates it from the point and never comes back (Edelsbrunner
//! 1990: cells are acyclic in front of any viewpoint, in every regular triangulation, so also under the
//! perturbation of [`crate::predicates`]).
//!
//! **Departures.** An insertion needs a cell in conflict, not the one that holds the point: the
//! descent ends at the first. A point that is a vertex already is inside no sphere, so for it the walk
//! goes on to the cell that holds it.

use super::read::corners;
use super::sphere::Query;
use super::triangulation::Incremental;
use crate::point::{Point, Simplex};
use crate::predicates::{Sign, orientation};

impl<P: Point> Incremental<P> {
    /// The finite cell whose closure holds `q`, or an infinite cell whose hull facet `q` lies beyond.
    /// The walk starts at the cell `hint` if that is live, else at the last cell made.
    pub fn locate(&self, q: P, hint: Option<u32>) -> u32 {
        let (near, _) = self.descend(&self.frame.query(q), self.start_of(hint));
        self.walk(q, near)
    }

    pub(super) fn start_of(&self, hint: Option<u32>) -> u32 {
        match hint {
            Some(cell) if cell < self.cells.slots() && self.cells.is_live(cell) => cell,
            _ => self.last,
        }
    }

    /// Goes down the powers from `start`: a cell whose sphere certainly holds the point (true), or
    /// one without a neighbour of smaller power (false).
    #[inline(never)]
    pub(super) fn descend(&self, query: &Query<P>, start: u32) -> (u32, bool) {
        let slots = &self.cells.slots[..];
        let mut cell = start;
        let mut best = query.power(&slots[start as usize]);
        if best.value.is_nan() {
            best.value = f32::INFINITY;
        }
        loop {
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

    /// The visibility walk by exact orientations.
    #[inline(never)]
    pub(super) fn walk(&self, q: P, start: u32) -> u32 {
        let n = P::Cell::LEN;
        let mut entered = n;
        let mut cell = match self.cells.infinite_slot(start) {
            Some(slot) => self.cells.neighbour(start, slot).0,
            None => start,
        };
        'walk: loop {
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
