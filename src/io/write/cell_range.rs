//! Cells in canonical order: all cells of a triangulation, or those that a process writes.

use septet_core::model::MeshView;

/// Consecutive cells of a triangulation in canonical order.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellRange<'a> {
    /// Number of vertices of a cell.
    pub corners: usize,
    /// The number of the first cell.
    pub first: usize,
    /// Number of cells of the triangulation.
    pub total: usize,
    /// Words per row, the vertices first.
    pub width: usize,
    /// The rows.
    pub words: &'a [u64],
}

impl<'a> CellRange<'a> {
    /// Returns all cells of a triangulation.
    pub fn whole(mesh: &MeshView<'a>) -> Self {
        let corners = mesh.dimension + 1;
        CellRange { corners, first: 0, total: mesh.cell_count(), width: corners, words: mesh.cells }
    }

    /// Returns the number of cells in the range.
    pub fn len(&self) -> usize {
        self.words.len() / self.width
    }

    /// Returns the vertices of a cell, given by its position in the range.
    pub fn row(&self, cell: usize) -> &'a [u64] {
        &self.words[cell * self.width..][..self.corners]
    }

    /// Returns a word that follows the vertices of a cell.
    pub fn extra(&self, cell: usize, word: usize) -> u64 {
        self.words[cell * self.width + self.corners + word]
    }
}
