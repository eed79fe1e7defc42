//! Cells as a vertex and a facet of its link.

use septet_geometry::complex::INFINITE;
use septet_geometry::point::{Point, Simplex};

/// The vertices of a cell `(centre, facet)`, or `None` if it is infinite.
pub(crate) fn finite_cell<P: Point>(centre: u32, facet: &P::Facet) -> Option<P::Cell> {
    let mut cell = P::Cell::splat(centre);
    for (slot, &v) in facet.as_ref().iter().enumerate() {
        if v == INFINITE {
            return None;
        }
        cell.as_mut()[slot + 1] = v;
    }
    Some(cell)
}
