//! Location of many queries.
//!
//! **Statement.** A walk leaves a cell through any facet that the query lies strictly beyond. In a regular triangulation,
//! also a symbolically perturbed one, it never returns to a cell, because cells that a ray passes have increasing powers. So it
//! ends in a cell whose closure contains the query, or at a hull facet. In the latter case, the query lies strictly beyond the
//! facet, so it is outside of the hull. Suppose that the query lies on facets of the cell. All cells that contain it are
//! connected by facets that contain it, because they form the star of the face in whose interior it lies. The smallest
//! of them is the answer, so the answer is a function of points and query.
//!
//! **Source.** Edelsbrunner, "An acyclicity theorem for cell complexes in d dimensions" (1990); Devillers, Pion and Teillaud,
//! "Walking in a triangulation" (2002).
//!
//! **Method.** Queries are ordered along a Hilbert curve and cut into blocks. A walk starts where the last one ended; the
//! first of a block starts at the nearest of about `n^(1/d)` vertices. A query outside of the bounding box of the points is
//! outside of the hull. Signs are exact ([`septet_geometry::predicates`]); queries whose digits do not fit into the range of
//! these predicates are decided by big integers.
//!
//! **Work.** O(1) expected for each of many queries, O(n^(1/d)) for a single one, on evenly spread points. Depth: that of a
//! block.
//!
//! **Departures.** The walk is not randomised; the theorem makes this unnecessary. The facet just crossed is not tested again.

use septet_geometry::incremental::curve_order;
use septet_geometry::point::{Simplex, dist2};
use septet_geometry::predicates::{Sign, orientation};
use septet_geometry::range::{Digits, scale};

use crate::dimension::Dimension;
use crate::exact;
use crate::loops;
use crate::seen::Seen;
use crate::tessellation::{NONE, Tessellation, least, most};

/// A query with finite coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Query<P> {
    /// As given.
    pub(crate) given: P,
    /// Multiplied as the points are, if it lies in their bounding box; otherwise moved to the nearest place in it.
    pub(crate) near: P,
    /// Whether `near` is exact, and its digits fit into the range of exact predicates.
    pub(crate) fits: bool,
    /// Whether it lies in the bounding box of the vertices.
    pub(crate) in_box: bool,
}

/// A cell to which a walk came.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// A cell that contains the query if it is inside, and one near it otherwise.
    pub(crate) cell: u32,
    /// Whether the query lies in the closed hull.
    pub(crate) inside: bool,
}

impl<P: Dimension> Query<P> {
    /// Returns the query in the units of the triangulation.
    pub(crate) fn of(t: &Tessellation<P>, given: P) -> Self {
        let scaled = scale(given, t.exponent) + P::splat(0.0);
        let near = most(least(scaled, t.bounds[1]), t.bounds[0]);
        let in_box = near == scaled;
        let digits = Digits::of(&[near]).is_some_and(Digits::fits);
        Query { given, near, fits: digits && (!in_box || scale(near, -t.exponent) == given), in_box }
    }

    /// Returns the orientation of a cell after `corner` has been replaced by the query.
    fn side(&self, t: &Tessellation<P>, cell: u32, corner: usize) -> Sign {
        let mut corners = t.corners(cell);
        corners[corner] = self.near;
        if self.fits {
            return orientation(&corners[..=P::DIM]);
        }
        for corner in &mut corners {
            *corner = scale(*corner, -t.exponent);
        }
        corners[corner] = if self.in_box { self.given } else { scale(self.near, -t.exponent) };
        exact::orientation(&corners[..=P::DIM])
    }
}

impl<P: Dimension> Tessellation<P> {
    /// Returns the smallest cell that contains each query, or [`NONE`] outside of the hull. A query on the hull is inside, so
    /// every vertex is. A query that is not finite is outside. Exact.
    pub fn locate(&self, queries: &[P]) -> Vec<u32> {
        self.each(
            queries,
            NONE,
            |query, place, seen| {
                if place.inside { self.smallest(query, place.cell, seen) } else { NONE }
            },
        )
    }

    /// Returns the answers to all queries in their order, and `missing` for queries that are not finite or if there are no
    /// cells. The answer must not depend on the cell of the place if several contain the query.
    pub(crate) fn each<U: Clone + Send + Sync>(
        &self,
        queries: &[P],
        missing: U,
        answer: impl Fn(&Query<P>, Place, &mut Seen) -> U + Sync,
    ) -> Vec<U> {
        if self.cells.is_empty() {
            return vec![missing; queries.len()];
        }
        let near = loops::map(queries.len(), |i| Query::of(self, queries[i]).near);
        let order = curve_order(&near);
        let blocks = loops::blocks(queries.len(), |block| {
            let mut seen = Seen::default();
            let mut cell = NONE;
            let one = |&i: &u32| {
                loops::check();
                let given = queries[i as usize];
                if (0..P::DIM).any(|axis| !given.coord(axis).is_finite()) {
                    return missing.clone();
                }
                let query = Query::of(self, given);
                if cell == NONE {
                    cell = self.start(query.near);
                }
                let place = self.walk(&query, cell);
                cell = place.cell;
                answer(&query, place, &mut seen)
            };
            order[block].iter().map(one).collect::<Vec<U>>()
        });
        let mut all = vec![missing; queries.len()];
        for (answer, &i) in blocks.into_iter().flatten().zip(&order) {
            all[i as usize] = answer;
        }
        all
    }

    /// Returns a cell from which a walk to `q` is short.
    fn start(&self, q: P) -> u32 {
        let distance = |v: u32| dist2(self.points[v as usize], q);
        let nearest = self.starts.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(0, |v| self.vertex_cell[v as usize])
    }

    /// Walks to a cell that contains the query. If the query is outside, the walk ends at a cell of the hull.
    fn walk(&self, query: &Query<P>, start: u32) -> Place {
        let (mut cell, mut from) = (start, NONE);
        'walk: loop {
            for corner in 0..P::Cell::LEN {
                let next = self.neighbours[cell as usize].as_ref()[corner];
                if next == from && next != NONE {
                    continue;
                }
                if query.side(self, cell, corner) == Sign::Negative {
                    if next == NONE {
                        return Place { cell, inside: false };
                    }
                    (cell, from) = (next, cell);
                    continue 'walk;
                }
            }
            return Place { cell, inside: query.in_box };
        }
    }

    /// Returns the smallest cell that contains the query, which `cell` contains.
    pub(crate) fn smallest(&self, query: &Query<P>, cell: u32, seen: &mut Seen) -> u32 {
        seen.clear();
        seen.push(cell);
        let (mut head, mut smallest) = (0, cell);
        while let Some(cell) = seen.get(head) {
            head += 1;
            smallest = smallest.min(cell);
            for corner in 0..P::Cell::LEN {
                let next = self.neighbours[cell as usize].as_ref()[corner];
                if next != NONE && query.side(self, cell, corner) == Sign::Zero {
                    seen.push(next);
                }
            }
        }
        smallest
    }
}
