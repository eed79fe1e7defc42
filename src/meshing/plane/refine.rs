//! Delaunay refinement: the triangulation of a domain with quality.
//!
//! **Statement.** Refinement starts from the constrained triangulation of the domain and inserts points, one at a time:
//! 1. A subsegment is *encroached* if the opposite corner of a cell beside it sees it at more than `180 - 2 t` degrees,
//!    where t is the least angle requested. Encroached subsegments are divided first, at the middle, or at a power
//!    of two from a corner at which another segment begins in a cell beside it.
//! 2. Then the cell with the least angle below t, or with a circumradius above the size there, receives its
//!    circumcentre. The point on the bisector of its shortest edge that sees this edge at little more than t
//!    (off-centre) replaces it if it is nearer. A point that encroaches a subsegment, or that lies behind one, is not
//!    inserted. The subsegment is divided instead.
//!
//! A cell is left as it is if its least angle lies between two segments at a corner. This also applies if its shortest
//! edge joins two segments with a common corner at equal distances from this corner. Then no point improves it. If
//! refinement ends, all other cells have angles of at least t and circumradii of at most the size.
//!
//! *Proof.* A triangulation is constrained Delaunay after each insertion (see [`super`]; a point replaces exactly the
//! cells that see it and whose circles contain it). The queues hold every encroached subsegment and every bad cell:
//! both change only with the cells around the new point, which are tested again. For angles of at least 60 degrees
//! between segments and t at most 20.7 degrees, refinement ends (Ruppert 1995; Chew 1993; Shewchuk 2002 for lenses).
//! For smaller angles, the divisions at powers of two and the cells left alone end it (Ruppert; Miller, Pav and
//! Walkington 2003). A limit on the number of points ends every other case.
//!
//! **Source.** Ruppert (1995); Chew (1993); Ungor (2004), *Off-centers*; Shewchuk, *Triangle* (2002). **Departure.**
//! Points that encroach a divided subsegment are not removed.
//!
//! **Work and depth.** Sequential. `O(n log n)` plus the cells that each point replaces.

use std::collections::{BTreeMap, BinaryHeap, VecDeque};

use glam::DVec2;
use septet_geometry::predicates::{Sign, orientation};

use super::constrained::{Constrained, NONE};
use super::insert::Conflicts;
use super::star::{next, previous};
use super::start::Start;
use crate::domain::Domain;
use crate::generate::{GenerationError, Rules};
use crate::mesh::Carrier;
use crate::space::ascending;
use crate::worst::Bad;

/// The state of refinement.
pub(super) struct Refiner<'a> {
    pub(super) domain: &'a Domain<DVec2>,
    pub(super) rules: Rules<'a, DVec2>,
    pub(super) made: Constrained,
    /// The component of each cell.
    pub(super) components: Vec<u32>,
    /// The carrier of each vertex.
    pub(super) carriers: Vec<Carrier>,
    /// The segment of each pair of corners.
    lines: BTreeMap<[u32; 2], u32>,
    /// The square of the cosine of the least angle requested.
    good: f64,
    /// The distance of an off-centre from the shortest edge, in lengths of this edge.
    off_centre: f64,
    /// The shortest distance between two points that refinement makes.
    least: f64,
    bad: BinaryHeap<Bad<3>>,
    /// Subsegments to divide, and whether a point that was not inserted encroaches them.
    due: VecDeque<([u32; 2], bool)>,
}

/// The outcome of an attempt to improve a cell.
enum Attempt {
    Inserted,
    /// These subsegments must be divided first.
    Encroached(Vec<[u32; 2]>),
    /// No point can be inserted.
    Impossible,
}

impl<'a> Refiner<'a> {
    /// Prepares the cells of the domain for refinement to a least angle in degrees.
    pub(super) fn new(
        domain: &'a Domain<DVec2>,
        rules: Rules<'a, DVec2>,
        start: Start,
        degrees: f64,
    ) -> Self {
        let cosine = degrees.to_radians().cos();
        let extent = crate::bvh::Bounds::of(start.made.points().iter().copied()).extent().max_element();
        let carriers = (0..start.made.points().len() as u32).map(Carrier::Corner).collect();
        let lines = (0u32..).zip(&start.chains).map(|(s, &ends)| (ascending(ends), s)).collect();
        let (made, components) = start.into_inside();
        Refiner {
            domain,
            rules,
            made,
            components,
            carriers,
            lines,
            good: cosine * cosine,
            off_centre: 0.475 * ((1.0 + cosine) / (1.0 - cosine)).sqrt(),
            least: extent * 1e-11,
            bad: BinaryHeap::new(),
            due: VecDeque::new(),
        }
    }

    /// Refines until all cells are good.
    ///
    /// # Errors
    /// Returns [`GenerationError::TooMany`].
    pub(super) fn run<E>(&mut self) -> Result<(), GenerationError<E>> {
        for cell in 0..self.made.cells.len() as u32 {
            self.judge(cell);
        }
        loop {
            if self.made.points.len() as u64 > self.rules.most {
                return Err(GenerationError::TooMany(self.rules.most));
            }
            if let Some((ends, is_forced)) = self.due.pop_front() {
                if let Some((cell, corner)) = self.subsegment(ends)
                    && (is_forced || self.is_encroached(cell, corner))
                {
                    self.divide(cell, corner);
                }
                continue;
            }
            let Some(bad) = self.bad.pop() else { return Ok(()) };
            if sorted(self.made.cells[bad.cell as usize]) != bad.corners {
                continue;
            }
            if let Attempt::Encroached(edges) = self.improve(bad.cell) {
                self.due.extend(edges.into_iter().map(|edge| (edge, true)));
                self.bad.push(bad);
            }
        }
    }

    /// Returns the cell and corner opposite a subsegment, if it still is one.
    fn subsegment(&self, [a, b]: [u32; 2]) -> Option<(u32, usize)> {
        let cell = self.made.beside(a, b).into_iter().flatten().next()?;
        let corner = self.made.cells[cell as usize].iter().position(|v| *v != a && *v != b)?;
        self.made.is_constrained(cell, corner).then_some((cell, corner))
    }

    /// Whether the corner of a cell, or of the one beyond, encroaches the edge opposite.
    fn is_encroached(&self, cell: u32, corner: usize) -> bool {
        let beyond =
            self.made.across(cell, corner).map(|other| (other, self.made.corner_towards(other, cell)));
        [Some((cell, corner)), beyond].into_iter().flatten().any(|(cell, corner)| {
            let corners = self.made.cells[cell as usize];
            let [a, b, v] = [next(corner), previous(corner), corner].map(|i| self.made.point(corners[i]));
            self.encroaches([a, b], v)
        })
    }

    /// Whether a point sees a segment at more than `180 - 2 t` degrees.
    fn encroaches(&self, [a, b]: [DVec2; 2], v: DVec2) -> bool {
        let (to_a, to_b) = (a - v, b - v);
        let dot = to_a.dot(to_b);
        let least = 2.0 * self.good - 1.0;
        dot < 0.0 && dot * dot >= least * least * to_a.length_squared() * to_b.length_squared()
    }

    /// Queues a cell if it is bad, and its encroached subsegments.
    fn judge(&mut self, cell: u32) {
        let corners = self.made.cells[cell as usize];
        for corner in 0..3 {
            if self.made.is_constrained(cell, corner) {
                let [a, b] = [corners[next(corner)], corners[previous(corner)]];
                if self.encroaches([self.made.point(a), self.made.point(b)], self.made.point(corners[corner]))
                {
                    self.due.push_back((ascending([a, b]), false));
                }
            }
        }
        if let Some(badness) = self.badness(cell) {
            self.bad.push(Bad { badness, corners: sorted(corners), cell });
        }
    }

    /// Returns the square of the cosine of the least angle if the cell is bad.
    fn badness(&self, cell: u32) -> Option<f64> {
        let corners = self.made.cells[cell as usize];
        let shape = Shape::of(corners.map(|v| self.made.point(v)));
        let cosine = shape.cosine2();
        if cosine > self.good && !self.is_hopeless(cell, shape.shortest) {
            return Some(cosine);
        }
        let centre = shape.centre?;
        let radius = (centre - self.made.point(corners[0])).length();
        let size = self.rules.size.at(centre);
        // Below every cosine; the largest cells come first.
        (radius > size).then(|| -size / radius)
    }

    /// Whether no point improves the least angle of a cell, which lies opposite its shortest edge.
    fn is_hopeless(&self, cell: u32, apex: usize) -> bool {
        let corners = self.made.cells[cell as usize];
        let is_wall = |i| self.made.is_constrained(cell, i);
        if is_wall(next(apex)) && is_wall(previous(apex)) && self.is_corner(corners[apex]) {
            return true;
        }
        let ends = [corners[next(apex)], corners[previous(apex)]];
        let [Carrier::Segment(s), Carrier::Segment(t)] = ends.map(|v| self.carriers[v as usize]) else {
            return false;
        };
        if s == t {
            return false;
        }
        let segments = [s, t].map(|s| self.domain.segments[s as usize].ends());
        let Some(&common) = segments[0].iter().find(|v| segments[1].contains(v)) else { return false };
        let corner = self.domain.points()[common as usize];
        let [d, e] = ends.map(|v| (self.made.point(v) - corner).length_squared());
        d < 1.001 * e && d > 0.999 * e
    }

    fn is_corner(&self, v: u32) -> bool {
        matches!(self.carriers[v as usize], Carrier::Corner(_))
    }

    /// Divides the subsegment opposite a corner of a cell.
    fn divide(&mut self, cell: u32, corner: usize) {
        let corners = self.made.cells[cell as usize];
        let [a, b] = [corners[next(corner)], corners[previous(corner)]];
        let Some(segment) = self.segment_of(a, b) else { return };
        let [p, q] = [a, b].map(|v| self.made.point(v));
        let at = match self.share(cell, corner) {
            Some(share) => p + (q - p) * share,
            None => p + (q - p) * 0.5,
        };
        let at = self.domain.simplices.frame.snapped(at);
        let is_apart = |r: DVec2| (at - r).length() > self.least;
        if is_apart(p) && is_apart(q) && self.made.is_inside_quad(cell, corner, at) {
            let seeds = [Some(cell), self.made.across(cell, corner)];
            let conflicts = self.made.conflicts_of(at, &seeds);
            self.insert(at, Carrier::Segment(segment), &conflicts, Some([a, b]));
        }
    }

    /// Returns the share of a subsegment at which it is divided if other segments begin at its ends in the cells beside
    /// it.
    fn share(&self, cell: u32, corner: usize) -> Option<f64> {
        let corners = self.made.cells[cell as usize];
        let ends = [next(corner), previous(corner)].map(|i| corners[i]);
        let beyond =
            self.made.across(cell, corner).map(|other| (other, self.made.corner_towards(other, cell)));
        let meets = |v: u32| {
            self.is_corner(v)
                && [Some((cell, corner)), beyond].into_iter().flatten().any(|(cell, corner)| {
                    let own = self.made.cells[cell as usize];
                    // The other edge at v lies opposite the other end.
                    let other = [next(corner), previous(corner)].into_iter().find(|&i| own[i] != v);
                    other.is_some_and(|i| self.made.is_constrained(cell, i))
                })
        };
        let [at_start, at_end] = ends.map(meets);
        if !at_start && !at_end {
            return None;
        }
        let [p, q] = ends.map(|v| self.made.point(v));
        let length = (q - p).length();
        // The power of two that divides the segment most evenly.
        let mut power = 1.0;
        while length > 3.0 * power {
            power *= 2.0;
        }
        while length < 1.5 * power {
            power *= 0.5;
        }
        let share = power / length;
        Some(if at_end && !at_start { 1.0 - share } else { share })
    }

    /// Returns the segment on which a subsegment lies.
    pub(super) fn segment_of(&self, a: u32, b: u32) -> Option<u32> {
        match (self.carriers[a as usize], self.carriers[b as usize]) {
            (Carrier::Segment(s), _) | (_, Carrier::Segment(s)) => Some(s),
            _ => self.lines.get(&ascending([a, b])).copied(),
        }
    }

    /// Tries to insert a point that removes a bad cell.
    fn improve(&mut self, cell: u32) -> Attempt {
        let corners = self.made.cells[cell as usize];
        let shape = Shape::of(corners.map(|v| self.made.point(v)));
        let Some(centre) = shape.centre else { return Attempt::Impossible };
        let is_thin = shape.cosine2() > self.good;
        let [p, q] = [next(shape.shortest), previous(shape.shortest)].map(|i| self.made.point(corners[i]));
        let middle = p + (q - p) * 0.5;
        let off = middle + (q - p).perp() * self.off_centre;
        let is_nearer = (off - middle).length_squared() < (centre - middle).length_squared();
        let at = self.domain.simplices.frame.snapped(if is_thin && is_nearer { off } else { centre });
        let found = match self.locate(cell, at) {
            Ok(found) => found,
            Err(Some(edge)) => return Attempt::Encroached(vec![edge]),
            Err(None) => return Attempt::Impossible,
        };
        let conflicts = self.made.conflicts_of(at, &[Some(found)]);
        let mut encroached = Vec::new();
        for &(cell, corner) in &conflicts.boundary {
            let own = self.made.cells[cell as usize];
            let [a, b] = [own[next(corner)], own[previous(corner)]];
            let ends = [self.made.point(a), self.made.point(b)];
            if self.made.is_constrained(cell, corner)
                && (self.encroaches(ends, at) || orientation(&[ends[0], ends[1], at]) != Sign::Positive)
            {
                encroached.push(ascending([a, b]));
            }
            if (ends[0] - at).length() <= self.least {
                return Attempt::Impossible;
            }
        }
        if !encroached.is_empty() {
            encroached.sort_unstable();
            return Attempt::Encroached(encroached);
        }
        if self.insert(at, Carrier::Volume, &conflicts, None) {
            Attempt::Inserted
        } else {
            Attempt::Impossible
        }
    }

    /// Walks from a cell to the one that contains a point. Returns the subsegment behind which the point lies as an
    /// error.
    fn locate(&mut self, mut cell: u32, at: DVec2) -> Result<u32, Option<[u32; 2]>> {
        for _ in 0..self.made.cells.len() {
            let corners = self.made.cells[cell as usize];
            let (mut way, mut wall) = (None, None);
            for corner in 0..3 {
                let [a, b] = [corners[next(corner)], corners[previous(corner)]];
                self.made.work += 1;
                if orientation(&[self.made.point(a), self.made.point(b), at]) == Sign::Negative {
                    if self.made.is_constrained(cell, corner) {
                        wall = Some(ascending([a, b]));
                    } else {
                        way = way.or(self.made.across(cell, corner));
                    }
                }
            }
            match (way, wall) {
                (Some(next), _) => cell = next,
                (None, Some(edge)) => return Err(Some(edge)),
                (None, None) => return Ok(cell),
            }
        }
        Err(None)
    }

    /// Inserts a point into the cells in conflict with it. If it divides a subsegment, its ends are given. Returns
    /// whether the point was inserted.
    fn insert(
        &mut self,
        at: DVec2,
        carrier: Carrier,
        conflicts: &Conflicts,
        divided: Option<[u32; 2]>,
    ) -> bool {
        let Some(new) = self.made.insert(at, conflicts, divided, &mut self.components) else { return false };
        self.carriers.push(carrier);
        for cell in new {
            self.judge(cell);
        }
        true
    }

    /// Returns the faces on segments: segment, ends, and the cells beside.
    pub(super) fn faces(&self, outside: u32) -> Vec<(u32, [u32; 2], [u32; 2])> {
        let mut faces = Vec::new();
        for (cell, corners) in (0u32..).zip(&self.made.cells) {
            for corner in 0..3 {
                let beyond = self.made.across[cell as usize][corner];
                if !self.made.is_constrained(cell, corner) || (beyond != NONE && beyond < cell) {
                    continue;
                }
                let [a, b] = [corners[next(corner)], corners[previous(corner)]];
                if let Some(segment) = self.segment_of(a, b) {
                    let other = if beyond == NONE { outside } else { beyond };
                    faces.push((segment, ascending([a, b]), [cell, other]));
                }
            }
        }
        faces.sort_unstable();
        faces
    }
}

/// Sorts the corners of a cell.
fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// The measures of a triangle.
struct Shape {
    /// The squared lengths of the edges opposite the corners.
    edges: [f64; 3],
    /// The corner opposite the shortest edge.
    shortest: usize,
    /// The circumcentre, if it is finite.
    centre: Option<DVec2>,
}

impl Shape {
    fn of([a, b, c]: [DVec2; 3]) -> Self {
        let edges = [(c - b).length_squared(), (a - c).length_squared(), (b - a).length_squared()];
        let shortest = (1..3).fold(0, |k, i| if edges[i] < edges[k] { i } else { k });
        let twice = 2.0 * (b - a).perp_dot(c - a);
        let centre = a + ((b - a) * edges[1] - (c - a) * edges[2]).perp() / twice;
        Shape { edges, shortest, centre: centre.is_finite().then_some(centre) }
    }

    /// Returns the square of the cosine of the least angle.
    fn cosine2(&self) -> f64 {
        let s = self.edges[self.shortest];
        let [l, m] = [self.edges[next(self.shortest)], self.edges[previous(self.shortest)]];
        let sum = l + m - s;
        sum * sum / (4.0 * l * m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_of_triangles() {
        let shape = Shape::of([DVec2::new(1.0, 1.0), DVec2::new(5.0, 1.0), DVec2::new(1.0, 4.0)]);
        assert_eq!(shape.centre, Some(DVec2::new(3.0, 2.5)));
        assert_eq!(shape.shortest, 1);
        assert!((shape.cosine2() - 0.64).abs() < 1e-15);
    }
}
