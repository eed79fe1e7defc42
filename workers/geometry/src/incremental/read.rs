//! What a triangulation tells: its cells, stars, links and nearest vertices.

use std::collections::BTreeSet;

use super::cells::Cells;
use super::sphere::Frame;
use super::triangulation::Incremental;
use crate::complex::{INFINITE, NONE};
use crate::point::{Point, Simplex, dist2};

/// The points of a cell; infinity stands as some finite point.
#[inline]
pub(super) fn corners<P: Point>(points: &[P], vertices: &P::Cell) -> [P; 4] {
    let mut out = [P::default(); 4];
    for (corner, &v) in out.iter_mut().zip(vertices.as_ref()) {
        if let Some(p) = points.get(v as usize) {
            *corner = *p;
        }
    }
    out
}

impl<P: Point> Incremental<P> {
    /// The coordinates of every vertex, by number.
    pub fn vertices(&self) -> &[P] {
        &self.points
    }

    /// The cells with their neighbours, infinite ones included.
    pub fn complex(&self) -> &Cells<P::Cell> {
        &self.cells
    }

    /// The finite cells, positively oriented, in slot order.
    pub fn cells(&self) -> impl Iterator<Item = P::Cell> + '_ {
        let vertices = self.cells.entries().map(|(_, vertices, _)| *vertices);
        vertices.filter(|vertices| !vertices.as_ref().contains(&INFINITE))
    }

    /// The coordinates of a finite cell, in its first `DIM + 1` entries.
    pub fn corners(&self, cell: u32) -> [P; 4] {
        corners(&self.points, self.cells.cell(cell))
    }

    /// A ball that holds the circumball of a finite cell, a little larger: centre and squared radius.
    /// `None` for infinite cells, and for cells so flat that their ball is not known well: nothing but
    /// the exact predicates says what conflicts with them.
    pub fn ball(&self, cell: u32) -> Option<(P, f64)> {
        self.frame.ball(self.cells.slots[cell as usize].sphere())
    }

    /// No vertex is farther than this from the origin of the rounded spheres, each coordinate of which is a median of
    /// the first points'.
    pub fn extent(&self) -> f64 {
        self.frame.extent()
    }

    /// A number that no circumradius of a finite cell exceeds, known without a square root: all of its circumball is
    /// within twice that of each of its vertices. Not a number where [`Incremental::ball`] knows none.
    #[inline]
    pub fn radius_bound(&self, cell: u32) -> f64 {
        self.frame.radius_bound(self.cells.slots[cell as usize].sphere())
    }

    /// The radius of a finite cell's rounded sphere, in units of its own, to be compared with
    /// [`Incremental::radius_within`]. Not a number where [`Incremental::ball`] knows none.
    #[inline]
    pub fn rounded_radius(&self, cell: u32) -> f32 {
        Frame::<P>::rounded_radius(self.cells.slots[cell as usize].sphere())
    }

    /// A rounded radius up to which all of a finite cell's circumball is within `across` of each of its vertices (twice its
    /// [`Incremental::radius_bound`] at most); 0, which none has, if there is none.
    pub fn radius_within(&self, across: f64) -> f32 {
        self.frame.radius_within(across)
    }

    /// Which of the slots from `64 * word` on have a cell, and which pass a test of a cell's vertices: a bit each, the first
    /// slot's the lowest. All are asked, those without a cell too, for no branch depends on it.
    #[inline]
    pub fn masks(&self, word: usize, test: impl Fn(&P::Cell) -> bool) -> (u64, u64) {
        let (slots, first) = (&self.cells.slots, word * u64::BITS as usize);
        let (mut live, mut passing) = (0, 0);
        for (i, cell) in slots[first..slots.len().min(first + u64::BITS as usize)].iter().enumerate() {
            live |= u64::from(!cell.is_removed()) << i;
            passing |= u64::from(test(cell.vertices())) << i;
        }
        (live, passing)
    }

    /// Replaces `out` by the cells around `vertex`, infinite ones included.
    pub fn star(&self, vertex: u32, out: &mut Vec<u32>) {
        out.clear();
        out.push(self.incident[vertex as usize + 1]);
        let mut seen = Seen::default();
        seen.add(out[0]);
        let mut head = 0;
        while head < out.len() {
            let cell = out[head];
            head += 1;
            for (slot, &v) in self.cells.cell(cell).as_ref().iter().enumerate() {
                let next = self.cells.neighbour(cell, slot).0;
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
        out.extend(star.iter().map(|&cell| facet_without::<P>(self.cells.cell(cell), vertex)));
    }

    /// A vertex nearest to `q` (one of them), the walk starting as in [`Incremental::locate`].
    /// Distances are compared as rounded.
    pub fn nearest_vertex(&self, q: P, hint: Option<u32>) -> u32 {
        let distance = |v: u32| dist2(self.points[v as usize], q);
        let corners = *self.cells.cell(self.locate(q, hint));
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
                for &v in self.cells.cell(cell).as_ref() {
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
