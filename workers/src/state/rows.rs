//! The cells of a rank as rows of vertices and neighbours.

use septet_geometry::incremental::FIRST_MARK;

/// A neighbour entry in the rows of cells, which marks a facet on the hull.
pub const HULL: u32 = u32::MAX;

/// A neighbour entry in the rows of cells, which marks a neighbour that belongs to another worker. All cell indices are
/// smaller.
pub const INTERFACE: u32 = FIRST_MARK;

/// The cells that belong to a worker.
#[derive(Debug)]
pub(crate) struct AdjacencyRows {
    /// `2 (d + 1)` entries per cell: the vertices as local indices, then the neighbour opposite to each, which is a
    /// cell index, [`HULL`] or [`INTERFACE`].
    rows: Vec<u32>,
    /// The indices of the cells with an entry [`HULL`] or [`INTERFACE`].
    open: Vec<u32>,
}

impl AdjacencyRows {
    /// Creates rows with the indices of the open cells.
    pub(crate) fn new(rows: Vec<u32>, open: Vec<u32>) -> Self {
        AdjacencyRows { rows, open }
    }

    /// Returns the rows and the indices of the open cells.
    pub(crate) fn into_parts(self) -> (Vec<u32>, Vec<u32>) {
        (self.rows, self.open)
    }
}
