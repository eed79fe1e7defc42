//! Nearest vertices.
//!
//! **Statement.** If another vertex is nearer to a query than this one, so is a neighbour of this one in the Delaunay
//! triangulation. For the query lies outside of its Voronoi cell, so beyond the bisector of one of its neighbours. A descent along edges therefore
//! ends at a nearest vertex. The nearest vertices of a query lie on an empty sphere around it. Their convex hull is a face of the
//! Delaunay subdivision, which the perturbation triangulates, so edges connect them. The smallest of them is the answer.
//!
//! **Source.** Dickerson and Drysdale, "Fixed-radius near neighbors search algorithms for points and segments" (1990).
//!
//! **Method.** Distances are compared in rounded arithmetic. Each of the rounded squares has a relative error below `6 u` with
//! `u = 2^-53`: a difference counts twice, then a square and two additions. Closer calls are decided by big integers.
//!
//! **Work.** O(1) expected for each query after its location, on evenly spread points.

use std::cmp::Ordering;

use septet_geometry::point::dist2;

use crate::dimension::Dimension;
use crate::exact;
use crate::locate::Query;
use crate::seen::Seen;
use crate::tessellation::{NONE, Tessellation};

/// A bound on the relative error of a rounded squared distance, with a margin for the error of the bound.
const ERROR: f64 = 6.5 * (f64::EPSILON / 2.0);

impl<P: Dimension> Query<P> {
    /// Compares the distances of two vertices to the query.
    fn nearer(&self, t: &Tessellation<P>, a: u32, b: u32) -> Ordering {
        if self.in_box && self.fits {
            let [x, y] = [a, b].map(|v| dist2(t.points[v as usize], self.near));
            if (x - y).abs() > ERROR * (x + y) {
                return x.total_cmp(&y);
            }
            return exact::nearer(self.near, t.points[a as usize], t.points[b as usize]);
        }
        let [a, b] = [a, b].map(|v| t.point(v));
        let [x, y] = [a, b].map(|p| dist2(p, self.given));
        // Sums that are infinite, not numbers, or so small that digits were lost are not certain.
        if (x - y).abs() > ERROR * (x + y) + f64::MIN_POSITIVE {
            return x.total_cmp(&y);
        }
        exact::nearer(self.given, a, b)
    }
}

impl<P: Dimension> Tessellation<P> {
    /// Returns the vertex nearest to each query, or [`NONE`] if the query is not finite or there are no points. Of several, the
    /// smallest. Exact. Points that do not span the space have no cells; then the work for each query is O(n).
    pub fn nearest(&self, queries: &[P]) -> Vec<u32> {
        if self.cells.is_empty() {
            return crate::loops::map(queries.len(), |i| self.nearest_loose(queries[i]));
        }
        self.each(queries, NONE, |query, place, seen| self.descend(query, place.cell, seen))
    }

    /// Compares a query with all vertices.
    fn nearest_loose(&self, given: P) -> u32 {
        if (0..P::DIM).any(|axis| !given.coord(axis).is_finite()) {
            return NONE;
        }
        let query = Query { given, near: given, fits: false, in_box: false };
        let nearest = self.loose.iter().copied().min_by(|&a, &b| query.nearer(self, a, b).then(a.cmp(&b)));
        nearest.unwrap_or(NONE)
    }

    /// Descends along edges from a vertex of `cell` to the smallest of the vertices nearest to the query.
    fn descend(&self, query: &Query<P>, cell: u32, star: &mut Seen) -> u32 {
        let mut best = self.cells[cell as usize].as_ref()[0];
        for &v in &self.cells[cell as usize].as_ref()[1..] {
            if query.nearer(self, v, best).is_lt() {
                best = v;
            }
        }
        let mut tied = Seen::default();
        loop {
            tied.clear();
            tied.push(best);
            let before = best;
            let mut head = 0;
            while let Some(vertex) = tied.get(head) {
                head += 1;
                self.star(vertex, star);
                for v in self.vertices_of(star.list()).filter(|v| *v != before) {
                    let order = query.nearer(self, v, best);
                    if order.is_lt() {
                        best = v;
                    } else if order.is_eq() {
                        tied.push(v);
                    }
                }
                if best != before {
                    break;
                }
            }
            if best == before {
                return tied.list().iter().copied().min().unwrap_or(best);
            }
        }
    }

    /// Returns the vertices of cells, some of them several times.
    pub(crate) fn vertices_of<'a>(&'a self, cells: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
        cells.iter().flat_map(|&cell| self.cells[cell as usize].as_ref().iter().copied())
    }
}
