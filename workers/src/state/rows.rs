//! The cells of a rank as rows of vertices and neighbours.

use septet_geometry::hash::finalise;
use septet_geometry::incremental::FIRST_MARK;
use septet_protocol::checksum::{checksum, row_hash};
use septet_protocol::ids::Rank;

/// A neighbour entry in the rows of cells, which marks a facet on the hull.
pub const HULL: u32 = u32::MAX;

/// A neighbour entry in the rows of cells, which marks a neighbour that belongs to another worker. All cell indices are
/// smaller.
pub const INTERFACE: u32 = FIRST_MARK;

/// Returns the hash of the cells of a worker whose rows have local indices: of the sum of the hashes of its cells, and
/// of the input index of each local index.
pub fn piece_hash(owner: Rank, cells: u64, ids: &[u64]) -> u64 {
    let odd = finalise(u64::from(owner)) | 1;
    cells.wrapping_add(checksum(bytemuck::cast_slice(ids))).wrapping_mul(odd)
}

/// Returns the sum of the hashes of the cells in rows of `width` entries, of which the first `corners` are the vertices.
pub fn cells_hash(rows: &[u32], corners: usize, width: usize) -> u64 {
    let hash = |row: &[u32]| row_hash(&row[..corners]);
    rows.chunks_exact(width).fold(0, |sum, row| sum.wrapping_add(hash(row)))
}

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

    /// Returns the rows.
    pub(crate) fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// Returns the indices of the open cells.
    pub(crate) fn open(&self) -> &[u32] {
        &self.open
    }

    /// Returns the rows and the indices of the open cells.
    pub(crate) fn into_parts(self) -> (Vec<u32>, Vec<u32>) {
        (self.rows, self.open)
    }
}
