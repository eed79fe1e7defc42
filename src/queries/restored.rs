//! A triangulation from its points and cells, with checks.
//!
//! **Checks.** Rows are canonical, and cells are positively oriented. A facet has one cell, or two on its two sides. Neither sphere
//! of these two contains the vertex of the other, with ties as in the kernel. The facets with one cell form closed surfaces that are
//! convex at each of their ridges. The cells are connected.
//!
//! **Statement.** A Delaunay triangulation passes, and one that lacks cells does not. A walk ends in cells that pass
//! ([`crate::locate`]): it needs only that the power of the query decreases from cell to cell, which the check of each facet ensures.
//!
//! **Work.** O(m log m) for m cells.

use septet_geometry::point::{Simplex, lex_cmp};
use septet_geometry::predicates::{Sign, affine_frame, in_sphere, orientation};

use crate::dimension::Dimension;
use crate::error::{QueryError, RowFault};
use crate::loops;
use crate::rows::{Rows, matched, sort};
use crate::tessellation::{NONE, Tessellation};

impl<P: Dimension> Tessellation<P> {
    /// Takes a triangulation from its points and its cells, as [`Tessellation::cells`] returns them. A point that is no vertex
    /// must coincide with one of a smaller number, or have a coordinate that is not finite.
    ///
    /// # Errors
    /// Fails if the cells are not the canonical rows of a Delaunay triangulation of the points.
    pub fn of_cells(points: &[P], cells: &[P::Cell]) -> Result<Self, QueryError> {
        for (what, count) in [("points", points.len()), ("cells", cells.len())] {
            if count >= NONE as usize {
                return Err(QueryError::TooMany { what, count });
            }
        }
        check_rows(points, cells)?;
        let (duplicates, is_vertex) = vertices(points, cells)?;
        let neighbours = matched::<P>(cells, points.len());
        let rows = Rows { cells: cells.to_vec(), neighbours };
        let mut made = Self::of_rows(points, rows, (duplicates, &is_vertex, P::DIM as isize))?;
        if cells.is_empty() {
            let vertices: Vec<P> = made.loose.iter().map(|&v| made.points[v as usize]).collect();
            made.dimension = affine_frame(&vertices).0;
            if let (true, Some(&first)) = (made.dimension == P::DIM as isize, made.loose.first()) {
                return Err(QueryError::Unused { point: first as usize });
            }
            return Ok(made);
        }
        let faults = loops::blocks(cells.len(), |block| {
            block.into_iter().find_map(|cell| made.fault(cell as u32).map(|fault| (cell, fault)))
        });
        if let Some((cell, fault)) = faults.into_iter().flatten().next() {
            return Err(QueryError::Row { cell, fault });
        }
        match made.gap() {
            Some(cell) => Err(QueryError::Row { cell: cell as usize, fault: RowFault::Gap }),
            None => Ok(made),
        }
    }

    /// Returns what is wrong with a cell and its facets.
    fn fault(&self, cell: u32) -> Option<RowFault> {
        let corners = self.corners(cell);
        if orientation(&corners[..P::Cell::LEN]) != Sign::Positive {
            return Some(RowFault::Orientation);
        }
        for (slot, &next) in self.neighbours[cell as usize].as_ref().iter().enumerate() {
            if next == NONE {
                continue;
            }
            let Some(back) = self.neighbours[next as usize].as_ref().iter().position(|&n| n == cell) else {
                return Some(RowFault::Facet);
            };
            let apex = self.points[self.cells[next as usize].as_ref()[back] as usize];
            let mut replaced = corners;
            replaced[slot] = apex;
            if orientation(&replaced[..P::Cell::LEN]) != Sign::Negative {
                return Some(RowFault::Facet);
            }
            if in_sphere(&corners[..P::Cell::LEN], apex) {
                return Some(RowFault::NotDelaunay);
            }
        }
        None
    }

    /// Returns a cell at a place where the boundary is not closed or not convex, or one that is not connected with the first.
    fn gap(&self) -> Option<u32> {
        // Each facet of the hull with its cell, once for each of its ridges: the ridge comes first, then the vertex off it.
        let mut ridges: Vec<([u32; 2], u32, u32, usize)> = Vec::new();
        for (cell, next) in (0u32..).zip(&self.neighbours) {
            let open = next.as_ref().iter().enumerate().filter(|(_, next)| **next == NONE);
            for (slot, _) in open {
                let row = self.cells[cell as usize].as_ref();
                let facet = || row.iter().enumerate().filter(|(i, _)| *i != slot).map(|(_, &v)| v);
                for apex in facet() {
                    let mut ridge = [NONE; 2];
                    ridge.iter_mut().zip(facet().filter(|v| *v != apex)).for_each(|(to, v)| *to = v);
                    ridge.sort_unstable();
                    ridges.push((ridge, apex, cell, slot));
                }
            }
        }
        ridges.sort_unstable();
        for pair in ridges.chunk_by(|a, b| a.0 == b.0) {
            let &[(_, _, cell, slot), (_, apex, ..)] = pair else { return Some(pair[0].2) };
            let mut replaced = self.corners(cell);
            replaced[slot] = self.points[apex as usize];
            if orientation(&replaced[..P::Cell::LEN]) == Sign::Negative {
                return Some(cell);
            }
        }
        self.unconnected()
    }

    /// Returns a cell that is not connected with the first.
    fn unconnected(&self) -> Option<u32> {
        let mut is_reached = vec![false; self.cells.len()];
        is_reached[0] = true;
        let mut open = vec![0];
        while let Some(cell) = open.pop() {
            for &next in self.neighbours[cell as usize].as_ref().iter().filter(|next| **next != NONE) {
                if !std::mem::replace(&mut is_reached[next as usize], true) {
                    open.push(next);
                }
            }
        }
        is_reached.iter().position(|is_reached| !is_reached).map(|cell| cell as u32)
    }
}

/// Checks the numbers and the order of rows.
fn check_rows<P: Dimension>(points: &[P], cells: &[P::Cell]) -> Result<(), QueryError> {
    let is_finite = |&v: &u32| (0..P::DIM).all(|axis| points[v as usize].coord(axis).is_finite());
    for (cell, row) in cells.iter().enumerate() {
        let mut sorted = *row;
        sort(sorted.as_mut(), &mut [0; 4][..P::Cell::LEN]);
        let fault = if row.as_ref().iter().any(|&v| v as usize >= points.len()) {
            RowFault::NoPoint
        } else if !row.as_ref().iter().all(is_finite) {
            RowFault::NotFinite
        } else if sorted != *row || (cell > 0 && cells[cell - 1] >= *row) {
            RowFault::Order
        } else {
            continue;
        };
        return Err(QueryError::Row { cell, fault });
    }
    Ok(())
}

/// Finds the coincident points, and whether each point is a vertex.
fn vertices<P: Dimension>(points: &[P], cells: &[P::Cell]) -> Result<(Vec<[u32; 2]>, Vec<bool>), QueryError> {
    let mut is_used = vec![cells.is_empty(); points.len()];
    for &v in cells.iter().flat_map(AsRef::as_ref) {
        is_used[v as usize] = true;
    }
    let place = |v: u32| points[v as usize] + P::splat(0.0);
    let is_finite = |v: &u32| (0..P::DIM).all(|axis| points[*v as usize].coord(axis).is_finite());
    let mut order: Vec<u32> = (0..points.len() as u32).filter(is_finite).collect();
    order.sort_unstable_by(|&a, &b| lex_cmp(&place(a), &place(b)).then(a.cmp(&b)));
    let (mut duplicates, mut is_vertex) = (Vec::new(), vec![false; points.len()]);
    for group in order.chunk_by(|&a, &b| place(a) == place(b)) {
        let first = group[0];
        if !is_used[first as usize] {
            return Err(QueryError::Unused { point: first as usize });
        }
        is_vertex[first as usize] = true;
        duplicates.extend(group[1..].iter().map(|&v| [v, first]));
    }
    duplicates.sort_unstable();
    let is_second = |row: &P::Cell| row.as_ref().iter().any(|&v| !is_vertex[v as usize]);
    match cells.iter().position(is_second) {
        Some(cell) => Err(QueryError::Row { cell, fault: RowFault::Order }),
        None => Ok((duplicates, is_vertex)),
    }
}
