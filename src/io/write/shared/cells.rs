//! The cells of a subdomain as canonical rows.

use rayon::prelude::*;
use septet_core::WorkerShare;
use septet_core::result::canonical::canonical_row;

use crate::write::quality::radius_edge_ratio;

/// Writes the input indices of the vertices of a cell in canonical order to the beginning of `row`.
pub(super) fn write_row(subdomain: &WorkerShare, cell: usize, row: &mut [u64]) {
    let vertices = subdomain.cell(cell);
    let row = &mut row[..vertices.len()];
    for (to, &vertex) in row.iter_mut().zip(vertices) {
        *to = subdomain.ids[vertex as usize];
    }
    canonical_row(row);
}

/// Appends the cells of a subdomain as rows in the order of the subdomain. If `with_ratio` is set, the bits of the
/// radius-edge ratio follow the vertices.
pub(super) fn append_rows(subdomain: &WorkerShare, space: usize, with_ratio: bool, rows: &mut Vec<u64>) {
    let corners = space + 1;
    let width = corners + usize::from(with_ratio);
    let start = rows.len();
    rows.resize(start + subdomain.cell_count() * width, 0);
    rows[start..].par_chunks_exact_mut(width).enumerate().for_each(|(cell, row)| {
        write_row(subdomain, cell, row);
        if with_ratio {
            row[corners] = ratio(subdomain, space, cell, &row[..corners]).to_bits();
        }
    });
}

/// Returns the radius-edge ratio of a cell. The vertices are taken in the order of the row, on which the rounding of the
/// ratio depends.
fn ratio(subdomain: &WorkerShare, space: usize, cell: usize, row: &[u64]) -> f64 {
    let mut corners = [0.0; 12];
    for (to, id) in corners.chunks_exact_mut(space).zip(row) {
        let mut vertices = subdomain.cell(cell).iter().map(|&vertex| vertex as usize);
        // The row has the vertices of the cell.
        let vertex = vertices.find(|&vertex| subdomain.ids[vertex] == *id).unwrap_or_default();
        to.copy_from_slice(&subdomain.coordinates[vertex * space..][..space]);
    }
    radius_edge_ratio(space, &corners, &[0, 1, 2, 3][..=space])
}
