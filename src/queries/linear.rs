//! Linear maps of cells: to barycentric coordinates, and from values to gradients.
//!
//! **Statement.** The barycentric coordinate of corner `i` is the orientation determinant of the cell with the corner replaced by
//! the query, divided by that of the cell. The numerator is linear in the query. Its gradient is the normal of the opposite
//! facet, negated if the corner is an odd number of places before the last one.
//!
//! **Rounding.** The determinant of a thin cell is computed by big integers and rounded once; normals are rounded.
//!
//! **Work.** O(1) for each cell and column.

use septet_geometry::point::Simplex;
use septet_geometry::range::scale;

use crate::dimension::Dimension;
use crate::error::QueryError;
use crate::exact;
use crate::locate::Query;
use crate::loops;
use crate::tessellation::{NONE, Tessellation};
use crate::weights::check_values;

impl<P: Dimension> Tessellation<P> {
    /// Returns the affine maps of cells to barycentric coordinates: `d + 1` points for each cell. Let `r` be the last of them, the
    /// last corner. The coordinates of `x` but the last are the inner products of the others with `x - r`.
    pub fn transforms(&self) -> Vec<P> {
        let one = |cell: usize| {
            let gradients = self.slopes(cell as u32);
            let corner = self.point(self.cells[cell].as_ref()[P::DIM]);
            (0..=P::DIM).map(move |i| if i < P::DIM { gradients[i] } else { corner })
        };
        let blocks = loops::blocks(self.cells.len(), |block| block.flat_map(one).collect::<Vec<P>>());
        loops::joined(self.cells.len() * (P::DIM + 1), blocks)
    }

    /// Returns the gradient of the linear interpolant in each cell, given `columns` values for each point: `d` rows of `columns`
    /// numbers for each cell.
    ///
    /// # Errors
    /// Fails if the number of values is not `columns` for each point.
    pub fn gradients(&self, values: &[f64], columns: usize) -> Result<Vec<f64>, QueryError> {
        check_values(values, columns, self.points.len())?;
        let blocks = loops::blocks(self.cells.len(), |block| {
            let mut all = Vec::with_capacity(block.len() * P::DIM * columns);
            for cell in block {
                let slopes = self.slopes(cell as u32);
                let row = |corner: usize| {
                    let vertex = self.cells[cell].as_ref()[corner] as usize;
                    &values[vertex * columns..][..columns]
                };
                let last = row(P::DIM);
                for axis in 0..P::DIM {
                    let one = |column: usize| -> f64 {
                        (0..P::DIM).map(|i| (row(i)[column] - last[column]) * slopes[i].coord(axis)).sum()
                    };
                    all.extend((0..columns).map(one));
                }
            }
            all
        });
        Ok(loops::joined(self.cells.len() * P::DIM * columns, blocks))
    }

    /// Returns the barycentric coordinates of each query in a given cell, `d + 1` each. They may be negative, and add up to 1. Those
    /// of a query that is not finite, and of a cell [`NONE`], are NaN.
    ///
    /// # Errors
    /// Fails if there is not one cell for each query, or if there is no such cell.
    pub fn barycentric_in(&self, queries: &[P], cells: &[u32]) -> Result<Vec<f64>, QueryError> {
        if queries.len() != cells.len() {
            return Err(QueryError::Cells { given: cells.len(), queries: queries.len() });
        }
        let exists = |cell: u32| cell == NONE || (cell as usize) < self.cells.len();
        if let Some(at) = cells.iter().position(|&cell| !exists(cell)) {
            return Err(QueryError::NoCell { at, cell: cells[at], cells: self.cells.len() });
        }
        let one = |at: usize| {
            let (given, cell) = (queries[at], cells[at]);
            if cell == NONE || (0..P::DIM).any(|axis| !given.coord(axis).is_finite()) {
                return [f64::NAN; 4];
            }
            let query = Query::of(self, given);
            if query.in_box {
                return self.coordinates(&query, cell);
            }
            exact::barycentric(&self.corners(cell).map(|corner| scale(corner, -self.exponent)), given)
        };
        let blocks = loops::blocks(queries.len(), |block| {
            block.flat_map(|at| one(at).into_iter().take(P::Cell::LEN)).collect::<Vec<f64>>()
        });
        Ok(loops::joined(queries.len() * P::Cell::LEN, blocks))
    }

    /// Returns the gradients of the barycentric coordinates of a cell but the last.
    fn slopes(&self, cell: u32) -> [P; 3] {
        let corners = self.corners(cell);
        let det = self.determinant(cell);
        let mut slopes = [P::default(); 3];
        for (i, slope) in slopes.iter_mut().enumerate().take(P::DIM) {
            let mut others = (0..=P::DIM).filter(|k| *k != i).map(|k| corners[k]);
            let base = others.next().unwrap_or_default();
            let mut sides = [P::default(); 2];
            sides.iter_mut().zip(others).for_each(|(side, corner)| *side = corner - base);
            let turn = if (P::DIM - i).is_multiple_of(2) { 1.0 } else { -1.0 };
            let scaled = P::hull_normal(&sides[..P::DIM - 1]) * (turn / det);
            (0..P::DIM).for_each(|axis| slope.set_coord(axis, self.unscaled(scaled.coord(axis), -1)));
        }
        slopes
    }
}
