//! The sequential kernel: incremental Delaunay triangulation in the plane and in space.
//!
//! **Statement.** Bowyer (1981) and Watson (1981): the cells whose circumsphere contains a new point
//! form a ball around it; replacing them by the cone from the point over the ball's boundary gives the
//! Delaunay triangulation of the larger set. A cell of the ball is found by a visibility walk, which
//! leaves a cell through any facet that separates it from the point and never comes back (Edelsbrunner
//! 1990: cells are acyclic in front of any viewpoint, in every regular triangulation, so also under
//! the perturbation of [`crate::predicates`]).
//!
//! **Work.** In the order of [`insertion_order`] (biased random rounds along a curve: Amenta, Choi and
//! Rote 2003) O(n log n) expected for points whose samples have linear triangulations; in the plane
//! always; in space O(n^2) at worst, which is the size of the result.
//!
//! **Departures.** Outer space is a vertex, so a point outside the hull needs no special step. The
//! walk tries facets in the order of their slots, without the usual coin: acyclicity makes it stop
//! all the same, and runs can be repeated. Since ties are perturbed by coordinates, the set of cells is
//! a function of the set of points: neither order nor numbering matters.

mod order;

use std::collections::BTreeSet;

pub use order::insertion_order;
use thiserror::Error;

use crate::complex::{Complex, INFINITE, NONE};
use crate::point::{Point, Simplex, dist2};
use crate::predicates::{Sign, conflicts_infinite, in_sphere, orientation, raises_dimension};

/// Why points could not be triangulated.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum IncrementalError {
    /// The points span a point, a line or a plane, or there are none (-1).
    #[error("the points span dimension {dimension}: no cell can be built")]
    Flat {
        /// Dimension of the affine hull.
        dimension: isize,
    },
    /// A point has the coordinates of a vertex.
    #[error("point {point} coincides with vertex {vertex}")]
    Coincident {
        /// The number of the point that was not inserted.
        point: u32,
        /// The vertex with its coordinates.
        vertex: u32,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {point} has a coordinate that is not finite")]
    NotFinite {
        /// The number of the point.
        point: u32,
    },
    /// It was told to stop.
    #[error("the triangulation was stopped")]
    Stopped,
    /// More points or cells than one triangulation can number.
    #[error("more than 2^26 points or 2^29 cells in one triangulation")]
    TooMany,
}

/// A Delaunay triangulation that grows point by point. Vertices are numbers of points.
#[derive(Clone, Debug)]
pub struct Incremental<P: Point> {
    points: Vec<P>,
    complex: Complex<P::Cell>,
    /// A live cell of every vertex, finite or not; `NONE` before insertion.
    incident: Vec<u32>,
    last: u32,
}

/// Random points in space have 6.8 cells each: at this number less than [`MOST_CELLS`].
const MOST_POINTS: usize = 1 << 26;

/// Half of what the complex can number: one insertion adds at most two cells per vertex.
const MOST_CELLS: u32 = 1 << 29;

/// Points between two questions whether to go on.
pub const ASKED_EVERY: usize = 4096;

impl<P: Point> Incremental<P> {
    /// Triangulates `points`; vertex `i` is `points[i]`. Equal to [`Incremental::build`] with
    /// [`insertion_order`].
    ///
    /// # Errors
    ///
    /// Any [`IncrementalError`]; of coincident points, the first met in the order of insertion.
    pub fn new(points: Vec<P>) -> Result<Self, IncrementalError> {
        let order = insertion_order(&points);
        Self::build(points, Some(&order))
    }

    /// Triangulates `points` in the given order (each number once), or as they stand. Points stored
    /// along [`insertion_order`] and inserted as they stand are kindest to the caches.
    ///
    /// # Errors
    ///
    /// Any [`IncrementalError`]; of coincident points, the first met in the order of insertion.
    pub fn build(points: Vec<P>, order: Option<&[u32]>) -> Result<Self, IncrementalError> {
        Self::build_while(points, order, &mut || true)
    }

    /// The same, as long as `go_on`, which is asked every [`ASKED_EVERY`] points, answers yes.
    ///
    /// # Errors
    ///
    /// As [`Incremental::build`]; [`IncrementalError::Stopped`].
    pub fn build_while(
        points: Vec<P>,
        order: Option<&[u32]>,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Self, IncrementalError> {
        if points.len() > MOST_POINTS {
            return Err(IncrementalError::TooMany);
        }
        let mut this =
            Incremental { incident: vec![NONE; points.len()], points, complex: Complex::default(), last: 0 };
        for (i, p) in (0u32..).zip(&mut this.points) {
            *p = cleaned(*p).ok_or(IncrementalError::NotFinite { point: i })?;
        }
        match order {
            Some(order) => this.fill(order.iter().copied(), go_on)?,
            None => this.fill(0..this.points.len() as u32, go_on)?,
        }
        Ok(this)
    }

    /// Starts from the first affinely independent points of the order and inserts the others.
    fn fill<I>(&mut self, order: I, go_on: &mut dyn FnMut() -> bool) -> Result<(), IncrementalError>
    where
        I: Iterator<Item = u32> + Clone,
    {
        let mut frame: Vec<u32> = Vec::with_capacity(P::DIM + 1);
        let mut basis: Vec<P> = Vec::with_capacity(P::DIM + 1);
        for v in order.clone() {
            let p = self.points[v as usize];
            if raises_dimension(&basis, p) {
                frame.push(v);
                basis.push(p);
                if basis.len() > P::DIM {
                    break;
                }
            }
        }
        if basis.len() <= P::DIM {
            return Err(IncrementalError::Flat { dimension: basis.len() as isize - 1 });
        }
        let mut cell = P::Cell::splat(0);
        cell.as_mut().copy_from_slice(&frame);
        if orientation(&basis) == Sign::Negative {
            cell.as_mut().swap(0, 1);
        }
        self.complex.start(cell);
        for &v in &frame {
            self.incident[v as usize] = 0;
        }
        for (i, v) in order.enumerate() {
            if i % ASKED_EVERY == 0 && !go_on() {
                return Err(IncrementalError::Stopped);
            }
            if !frame.contains(&v) {
                self.insert_vertex(v, self.last)?;
            }
        }
        Ok(())
    }

    /// Adds a point and returns its vertex. The walk starts at the cell `hint` if that is live, else at
    /// the last cell made.
    ///
    /// # Errors
    ///
    /// [`IncrementalError::Coincident`] with the vertex that stands there already; `NotFinite` and
    /// `TooMany`. The triangulation is then as before.
    pub fn insert(&mut self, p: P, hint: Option<u32>) -> Result<u32, IncrementalError> {
        let vertex = self.points.len() as u32;
        if self.points.len() >= MOST_POINTS {
            return Err(IncrementalError::TooMany);
        }
        let p = cleaned(p).ok_or(IncrementalError::NotFinite { point: vertex })?;
        self.points.push(p);
        self.incident.push(NONE);
        let done = self.insert_vertex(vertex, self.start_of(hint));
        if done.is_err() {
            self.points.pop();
            self.incident.pop();
        }
        done.map(|()| vertex)
    }

    fn insert_vertex(&mut self, vertex: u32, start: u32) -> Result<(), IncrementalError> {
        if self.complex.slots() > MOST_CELLS {
            return Err(IncrementalError::TooMany);
        }
        let q = self.points[vertex as usize];
        let seed = self.walk(q, start);
        // Only the cell that holds a point can have it as a vertex.
        for &v in self.complex.cell(seed).as_ref() {
            if v != INFINITE && self.points[v as usize] == q {
                return Err(IncrementalError::Coincident { point: vertex, vertex: v });
            }
        }
        let points = &self.points;
        self.complex.insert(vertex, seed, |complex, cell| conflicts(complex, points, cell, q));
        for &cell in self.complex.created() {
            for &v in self.complex.cell(cell).as_ref() {
                if v != INFINITE {
                    self.incident[v as usize] = cell;
                }
            }
        }
        self.last = self.complex.created()[0];
        Ok(())
    }

    fn start_of(&self, hint: Option<u32>) -> u32 {
        match hint {
            Some(cell) if cell < self.complex.slots() && self.complex.is_live(cell) => cell,
            _ => self.last,
        }
    }

    /// The finite cell whose closure holds `q`, or an infinite cell whose hull facet `q` lies beyond.
    /// The walk starts at the cell `hint` if that is live, else at the last cell made.
    pub fn locate(&self, q: P, hint: Option<u32>) -> u32 {
        self.walk(q, self.start_of(hint))
    }

    fn walk(&self, q: P, start: u32) -> u32 {
        let n = P::DIM + 1;
        let mut entered = n;
        let mut cell = match self.complex.infinite_slot(start) {
            Some(slot) => self.complex.neighbour(start, slot).0,
            None => start,
        };
        'walk: loop {
            let mut corners = corners(&self.complex, &self.points, cell);
            for slot in (0..n).filter(|&slot| slot != entered) {
                let corner = std::mem::replace(&mut corners[slot], q);
                if orientation(&corners[..n]) == Sign::Negative {
                    let (next, back) = self.complex.neighbour(cell, slot);
                    if self.complex.infinite_slot(next).is_some() {
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

    /// The coordinates of every vertex, by number.
    pub fn vertices(&self) -> &[P] {
        &self.points
    }

    /// The cells with their neighbours, infinite ones included.
    pub fn complex(&self) -> &Complex<P::Cell> {
        &self.complex
    }

    /// The finite cells, positively oriented, in slot order.
    pub fn cells(&self) -> impl Iterator<Item = P::Cell> + '_ {
        let finite = |&cell: &u32| self.complex.infinite_slot(cell).is_none();
        self.complex.live_cells().filter(finite).map(|cell| *self.complex.cell(cell))
    }

    /// The coordinates of a finite cell, in its first `DIM + 1` entries.
    pub fn corners(&self, cell: u32) -> [P; 4] {
        corners(&self.complex, &self.points, cell)
    }

    /// Replaces `out` by the cells around `vertex`, infinite ones included.
    pub fn star(&self, vertex: u32, out: &mut Vec<u32>) {
        out.clear();
        out.push(self.incident[vertex as usize]);
        let mut seen = Seen::default();
        seen.add(out[0]);
        let mut head = 0;
        while head < out.len() {
            let cell = out[head];
            head += 1;
            for (slot, &v) in self.complex.cell(cell).as_ref().iter().enumerate() {
                let next = self.complex.neighbour(cell, slot).0;
                if v != vertex && seen.add(next) {
                    out.push(next);
                }
            }
        }
    }

    /// Replaces `out` by the facets of the link of `vertex`, infinite ones included: each is a cell
    /// without the vertex, ordered so that `(vertex, facet..)` is oriented as the cell is.
    pub fn link_of(&self, vertex: u32, out: &mut Vec<P::Facet>) {
        let mut star = Vec::with_capacity(SHORT);
        self.star(vertex, &mut star);
        out.clear();
        out.extend(star.iter().map(|&cell| facet_without::<P>(self.complex.cell(cell), vertex)));
    }

    /// A vertex nearest to `q` (one of them), the walk starting as in [`Incremental::locate`].
    /// Distances are compared as rounded.
    pub fn nearest_vertex(&self, q: P, hint: Option<u32>) -> u32 {
        let distance = |v: u32| dist2(self.points[v as usize], q);
        let corners = *self.complex.cell(self.locate(q, hint));
        let mut best = corners.as_ref()[0];
        if best == INFINITE {
            best = corners.as_ref()[1];
        }
        let mut star = Vec::with_capacity(SHORT);
        // Some neighbour of a vertex is nearer to q, unless none is: a descent without valleys.
        loop {
            let before = best;
            self.star(before, &mut star);
            for &cell in &star {
                for &v in self.complex.cell(cell).as_ref() {
                    if v != INFINITE && distance(v) < distance(best) {
                        best = v;
                    }
                }
            }
            if best == before {
                return best;
            }
        }
    }
}

/// Stars up to this size need no allocation.
const SHORT: usize = 128;

/// A set of cells: an open table of twice [`SHORT`] entries, and a tree for what goes beyond.
struct Seen {
    table: [u32; 2 * SHORT],
    len: usize,
    rest: BTreeSet<u32>,
}

impl Default for Seen {
    fn default() -> Self {
        Seen { table: [NONE; 2 * SHORT], len: 0, rest: BTreeSet::new() }
    }
}

impl Seen {
    /// Adds a cell; was it new?
    fn add(&mut self, cell: u32) -> bool {
        let mut at = (cell.wrapping_mul(0x9E37_79B9) >> 24) as usize;
        while self.table[at] != NONE {
            if self.table[at] == cell {
                return false;
            }
            at = (at + 1) % self.table.len();
        }
        if self.len == SHORT {
            return self.rest.insert(cell);
        }
        self.len += 1;
        self.table[at] = cell;
        true
    }
}

/// The point with `-0.0` read as `0.0`, if it is finite.
fn cleaned<P: Point>(mut p: P) -> Option<P> {
    for i in 0..P::DIM {
        if !p.coord(i).is_finite() {
            return None;
        }
        p.set_coord(i, p.coord(i) + 0.0);
    }
    Some(p)
}

/// The points of a cell; infinity stands as some finite point.
#[inline]
fn corners<P: Point>(complex: &Complex<P::Cell>, points: &[P], cell: u32) -> [P; 4] {
    let mut out = [P::default(); 4];
    for (corner, &v) in out.iter_mut().zip(complex.cell(cell).as_ref()) {
        if let Some(p) = points.get(v as usize) {
            *corner = *p;
        }
    }
    out
}

#[inline]
fn conflicts<P: Point>(complex: &Complex<P::Cell>, points: &[P], cell: u32, q: P) -> bool {
    let n = P::DIM + 1;
    let this = corners(complex, points, cell);
    match complex.infinite_slot(cell) {
        None => in_sphere(&this[..n], q),
        Some(slot) => {
            let finite = corners(complex, points, complex.neighbour(cell, slot).0);
            conflicts_infinite(&this[..n], slot, &finite[..n], q)
        }
    }
}

/// A cell without one of its vertices, ordered so that `(vertex, facet..)` is oriented as the cell.
pub fn facet_without<P: Point>(cell: &P::Cell, vertex: u32) -> P::Facet {
    let mut facet = P::Facet::splat(INFINITE);
    let mut odd = false;
    let mut to = 0;
    for (slot, &v) in cell.as_ref().iter().enumerate() {
        if v == vertex {
            odd = slot % 2 == 1;
        } else {
            facet.as_mut()[to] = v;
            to += 1;
        }
    }
    if odd {
        facet.as_mut().swap(0, 1);
    }
    facet
}

#[cfg(test)]
mod tests;
