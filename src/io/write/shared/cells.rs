//! The cells of a share as rows of words.

use septet_core::WorkerShare;
use septet_core::cores::each_chunk_mut;
use septet_core::result::canonical::canonical_row;

use super::mesh::SharedMesh;
use crate::write::quality::radius_edge_ratio;

/// The largest number of words of a row: four vertices, a ratio and two labels.
pub(super) const WIDEST: usize = 7;

/// Cells for each unit of parallel work.
const BLOCK: usize = 4096;

/// The words of a row: the vertices in canonical order, the bits of the radius-edge ratio, the owner and the leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Number of vertices.
    pub corners: usize,
    /// Whether a row has the radius-edge ratio.
    pub with_ratio: bool,
    /// Whether a row has the owner and the leaf.
    pub with_owner: bool,
}

impl Layout {
    /// Returns the number of words.
    pub fn width(self) -> usize {
        self.corners + usize::from(self.with_ratio) + 2 * usize::from(self.with_owner)
    }
}

/// The rows of the cells of a share.
pub(super) struct ShareRows<'a> {
    pub mesh: &'a SharedMesh<'a>,
    pub share: &'a WorkerShare,
    pub layout: Layout,
    /// The leaf of each cell, if rows have it.
    leaves: Vec<u64>,
}

impl<'a> ShareRows<'a> {
    pub fn of(mesh: &'a SharedMesh<'a>, share: &'a WorkerShare, layout: Layout) -> Self {
        let leaves = share.leaf_of_cells().filter(|_| layout.with_owner).map(|leaf| leaf.0).collect();
        ShareRows { mesh, share, layout, leaves }
    }

    /// Appends all rows in the order of the share.
    pub fn append(&self, words: &mut Vec<u64>) {
        let (start, width) = (words.len(), self.layout.width());
        words.resize(start + self.share.cell_count() * width, 0);
        each_chunk_mut(&mut words[start..], BLOCK * width, |block, rows| {
            let cells = (block * BLOCK..).zip(rows.chunks_exact_mut(width));
            cells.for_each(|(cell, row)| self.write(cell, row));
        });
    }

    /// Writes the row of a cell.
    pub fn write(&self, cell: usize, row: &mut [u64]) {
        let Layout { corners, with_ratio, with_owner } = self.layout;
        let (vertices, labels) = row.split_at_mut(corners);
        for (to, id) in vertices.iter_mut().zip(self.share.cell_ids(cell)) {
            *to = id;
        }
        canonical_row(vertices);
        if with_ratio {
            labels[0] = self.ratio(cell, vertices).to_bits();
        }
        if with_owner {
            labels[usize::from(with_ratio)..]
                .copy_from_slice(&[u64::from(self.share.rank), self.leaves[cell]]);
        }
    }

    /// Returns the radius-edge ratio of a cell. The vertices are taken in the order of the row, on which the rounding of the
    /// ratio depends.
    fn ratio(&self, cell: usize, row: &[u64]) -> f64 {
        let (share, space) = (self.share, self.mesh.run.space);
        let mut corners = [0.0; 12];
        for (to, id) in corners.chunks_exact_mut(space).zip(row) {
            // The row has the vertices of the cell.
            let vertices = share.cell(cell);
            let at =
                vertices.iter().position(|&vertex| share.ids[vertex as usize] == *id).unwrap_or_default();
            to.copy_from_slice(self.mesh.place(share, vertices[at]));
        }
        radius_edge_ratio(space, &corners, &[0, 1, 2, 3][..=space])
    }
}
