//! Queries of a triangulation: cells, stars, links and nearest vertices.
//!
//! **Statement.** The cells of a star are connected by facets that contain the vertex, so a breadth-first search finds
//! them. A vertex that is not nearest to a point has a Delaunay neighbour nearer to that point, so a descent along
//! edges ends at a nearest vertex.
//!
//! **Work.** A star query is linear in the size of the star. The search for a nearest vertex is linear in the total
//! size of the stars on its way.

use std::collections::BTreeSet;

use super::cells::Cells;
use super::sphere::Frame;
use super::triangulation::Incremental;
use crate::complex::{INFINITE, NONE};
use crate::point::{Point, Simplex, dist2};

/// Returns the points of a cell. The entry for infinity is some finite point.
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
    /// Returns the coordinates of all vertices, by index.
    pub fn vertices(&self) -> &[P] {
        &self.points
    }

    /// Returns the cells with their neighbours, infinite ones included.
    pub fn complex(&self) -> &Cells<P::Cell> {
        &self.cells
    }

    /// Iterates over the finite cells, positively oriented, in the order of their slots.
    pub fn cells(&self) -> impl Iterator<Item = P::Cell> + '_ {
        let vertices = self.cells.entries().map(|(_, vertices, _)| *vertices);
        vertices.filter(|vertices| !vertices.as_ref().contains(&INFINITE))
    }

    /// Returns the corners of a finite cell, in the first `DIM + 1` entries.
    pub fn corners(&self, cell: u32) -> [P; 4] {
        corners(&self.points, self.cells.cell(cell))
    }

    /// Returns the centre and the squared radius of a ball that contains the circumball of a finite cell and is
    /// slightly larger. Returns `None` for infinite cells, and for cells that are too flat for a bound. Conflicts with
    /// such cells require the exact predicates.
    pub fn ball(&self, cell: u32) -> Option<(P, f64)> {
        self.frame.ball(self.cells.slots[cell as usize].sphere())
    }

    /// Returns the largest distance of a vertex from the origin of the rounded spheres. Each coordinate of that
    /// origin is the median of a sample of the points.
    pub fn extent(&self) -> f64 {
        self.frame.extent()
    }

    /// Returns an upper bound on the circumradius of a finite cell, computed without a square root. The circumball
    /// lies within twice this distance of each vertex of the cell. The result is NaN if [`Incremental::ball`] returns
    /// `None`.
    #[inline]
    pub fn radius_bound(&self, cell: u32) -> f64 {
        self.frame.radius_bound(self.cells.slots[cell as usize].sphere())
    }

    /// Returns the radius of a finite cell's rounded sphere, in internal units, for comparison with
    /// [`Incremental::radius_within`]. The result is NaN if [`Incremental::ball`] returns `None`.
    #[inline]
    pub fn rounded_radius(&self, cell: u32) -> f32 {
        Frame::<P>::rounded_radius(self.cells.slots[cell as usize].sphere())
    }

    /// Returns a threshold for [`Incremental::rounded_radius`]. If the rounded radius of a finite cell is at most the
    /// threshold, twice its [`Incremental::radius_bound`] is at most `across`, so its circumball lies within `across`
    /// of each of its vertices. If no radius satisfies this condition, the threshold is 0, which is below every
    /// radius.
    pub fn radius_within(&self, across: f64) -> f32 {
        self.frame.radius_within(across)
    }

    /// Returns two bit masks over the 64 slots from `64 * word` on, lowest bit first: the slots that have a cell, and
    /// the slots whose vertices pass a test. The test runs on all slots, including those without a cell, because a
    /// branch would be slower.
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

    /// Returns `true` if the vertex is hidden, so that no cell contains it. Only points with weights can be hidden.
    #[inline]
    pub fn is_hidden(&self, vertex: u32) -> bool {
        self.incident[vertex as usize + 1] == NONE
    }

    /// Returns a finite cell that contains the position of a hidden vertex. It lies strictly below the vertex.
    pub fn cover_of(&self, vertex: u32) -> P::Cell {
        *self.cells.cell(self.locate(self.points[vertex as usize], None))
    }

    /// Replaces `out` by the cells around `vertex`, including infinite ones. The vertex must not be hidden.
    pub fn star(&self, vertex: u32, out: &mut Vec<u32>) {
        out.clear();
        out.push(self.incident[vertex as usize + 1]);
        let mut seen = CellSet::default();
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

    /// Replaces `out` by the facets of the link of `vertex`, including infinite ones. Each facet is a cell without the
    /// vertex, ordered so that `(vertex, facet..)` has the orientation of the cell.
    pub fn link_of(&self, vertex: u32, out: &mut Vec<P::Facet>) {
        let mut star = Vec::with_capacity(SHORT);
        self.star(vertex, &mut star);
        out.clear();
        out.extend(star.iter().map(|&cell| facet_without::<P>(self.cells.cell(cell), vertex)));
    }

    /// Finds a vertex nearest to `q`. The walk starts as in [`Incremental::locate`].
    pub fn nearest_vertex(&self, q: P, hint: Option<u32>) -> u32 {
        let distance = |v: u32| dist2(self.points[v as usize], q);
        let corners = *self.cells.cell(self.locate(q, hint));
        let mut best = corners.as_ref()[0];
        if best == INFINITE {
            best = corners.as_ref()[1];
        }
        let mut star = Vec::with_capacity(SHORT);
        // If a vertex is not nearest to `q`, one of its neighbours is nearer. So the descent cannot end in a local
        // minimum.
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

/// A set of cells: a hash table with twice [`SHORT`] entries, and a tree for the cells that are not in the table.
struct CellSet {
    table: [u32; 2 * SHORT],
    len: usize,
    rest: BTreeSet<u32>,
}

impl Default for CellSet {
    fn default() -> Self {
        CellSet { table: [NONE; 2 * SHORT], len: 0, rest: BTreeSet::new() }
    }
}

impl CellSet {
    /// Adds a cell. Returns `true` if it was not in the set.
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

/// Removes a vertex from a cell. The facet is ordered so that `(vertex, facet..)` has the orientation of the cell.
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
