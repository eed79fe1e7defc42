//! Points of a star against cells of its centre.
//!
//! **Statement.** A cell of the centre is a facet beside it; the point of a link lies in the cell's circumsphere iff
//! its inverse image lies beyond the facet's plane (see [`super::planes`]). The images of a link's points serve all
//! cells.
//!
//! **Work and depth.** A vector step over the points for each cell. What rounded arithmetic does not decide goes to
//! the exact predicates.

use super::candidate::Candidate;
use super::planes::{Planes, Side};
use crate::cost::Sweep;
use crate::point::Point;
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
    /// Takes the points, none of which is `table[centre]`; charged in `step`.
    pub fn load(&mut self, table: &[P], centre: u32, points: &[u32], step: &mut Sweep) {
        self.centre = table[centre as usize];
        self.points.clear();
        step.each(points, |&id| self.points.push(Candidate::of(table, id, self.centre)));
        self.longest = self.points.iter().fold(0.0, |most, p| most.max(p.image.length));
    }

    /// Appends to `found` those of the points that lie in the (perturbed) circumsphere of a cell of the centre and are
    /// none of its corners. Of a flat cell none does.
    pub fn append_inside(&mut self, table: &[P], cell: &P::Cell, found: &mut Vec<u32>, tests: &mut Sweep) {
        let mut corners = [self.centre; 4];
        let mut others = [self.points.first().copied().unwrap_or_else(|| Candidate::infinity()); 3];
        let mut n = 0;
        for &id in cell.as_ref() {
            let at = table[id as usize];
            if at != self.centre && n < P::DIM {
                others[n] = Candidate::of(table, id, self.centre);
                n += 1;
                corners[n] = at;
            }
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
        // In the plane the third is the first again, and not looked at.
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
