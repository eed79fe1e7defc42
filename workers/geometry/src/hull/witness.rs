//! Points of a star tested against cells of its centre.
//!
//! **Statement.** A cell of the centre consists of the centre and a facet. A point lies in the circumsphere of the cell
//! iff its inverse image lies beyond the plane of the facet (see [`super::planes`]). The images of a link's points are
//! computed once and serve for all cells.
//!
//! **Work and depth.** Each cell takes one vector step over the points. If rounded arithmetic is inconclusive, the
//! exact predicates decide.

use super::candidate::Candidate;
use super::general;
use super::planes::{Planes, Side};
use crate::cost::Sweep;
use crate::point::{Point, lex_cmp};
use crate::predicates::{Sign, in_sphere, orientation};

/// Tests points against cells of a centre, in reused storage.
#[derive(Debug)]
pub struct Witnesses<P> {
    centre: P,
    points: Vec<Candidate<P>>,
    longest: f64,
    plane: Planes,
}

impl<P: Point> Default for Witnesses<P> {
    fn default() -> Self {
        Witnesses { centre: P::default(), points: Vec::new(), longest: 0.0, plane: Planes::default() }
    }
}

impl<P: Point> Witnesses<P> {
    /// Loads the points, none of which is `table[centre]`. Charged to `step`.
    pub fn load(&mut self, table: &[P], centre: u32, points: &[u32], step: &mut Sweep) {
        self.centre = table[centre as usize];
        self.points.clear();
        step.each(points, |&id| self.points.push(Candidate::of(table, id, self.centre)));
        self.longest = self.points.iter().fold(0.0, |most, p| most.max(p.image.length));
    }

    /// Appends to `found` the points that lie in the perturbed circumsphere of a cell of the centre, except its
    /// corners. A flat cell contains no points.
    pub fn append_inside(&mut self, table: &[P], cell: &P::Cell, found: &mut Vec<u32>, tests: &mut Sweep) {
        if P::DIM > 3 {
            let points = tests.visit_all(&self.points).iter().map(|point| point.id);
            return general::append_inside((table, self.centre), cell, points, found);
        }
        let mut corners = [self.centre; 4];
        let mut others = [self.points.first().copied().unwrap_or_else(|| Candidate::infinity()); 3];
        let mut n = 0;
        for &id in cell.as_ref() {
            if table[id as usize] != self.centre && n < P::DIM {
                others[n] = Candidate::of(table, id, self.centre);
                n += 1;
            }
        }
        // The number of exact tests does not depend on the numbering of the table.
        others[..n].sort_unstable_by(|a, b| lex_cmp(&a.at, &b.at));
        for (corner, other) in corners[1..].iter_mut().zip(&others[..n]) {
            *corner = other.at;
        }
        match orientation(&corners[..=P::DIM]) {
            Sign::Zero => return,
            Sign::Negative => {
                others.swap(0, 1);
                corners.swap(1, 2);
            }
            Sign::Positive => {}
        }
        let longest = others[..P::DIM].iter().fold(self.longest, |most, p| most.max(p.image.length));
        self.plane.clear(longest);
        self.plane.make_room(1);
        // In the plane, the third image repeats the first and is not used.
        let [a, b, c] = [0, 1, 2 % P::DIM].map(|i| &others[i].image);
        self.plane.set(0, [a, b, c], longest);
        tests.each(&self.points, |p| {
            let inside = match self.plane.side(0, &p.image.at) {
                Side::Clear => false,
                _ if cell.as_ref().contains(&p.id) => false,
                Side::Undecided => in_sphere(&corners[..=P::DIM], p.at),
                _ => true,
            };
            if inside {
                found.push(p.id);
            }
        });
    }
}
