//! The piece of a worker, made from its share and its ghost cells.

use std::sync::atomic::{AtomicBool, Ordering};

use septet_core::WorkerShare;
use septet_core::cores::each_chunk_mut;

use super::cells::{Layout, ShareRows};
use super::ghosts::Ghosts;
use super::mesh::SharedMesh;
use super::words::{dedup_rows, sort_rows};
use crate::write::formats::pvtu::Piece;

/// Vertices for each unit of parallel work.
const BLOCK: usize = 16384;

/// The points of a piece.
struct PiecePoints {
    owned: usize,
    /// Rows: those of the worker, ascending, then those of others, ascending.
    rows: Vec<u64>,
    coordinates: Vec<f64>,
}

impl PiecePoints {
    /// Returns the points of the worker, and the other vertices of its cells and of its ghost cells.
    fn of(mesh: &SharedMesh<'_>, share: &WorkerShare, ghosts: &Ghosts) -> Self {
        let (owned, width) = (share.owned, mesh.run.space + 1);
        let mut others: Vec<u64> = Vec::new();
        for vertex in other_vertices(share) {
            others.push(share.ids[vertex as usize]);
            others.extend(mesh.place(share, vertex).iter().map(|coordinate| coordinate.to_bits()));
        }
        others.extend(ghosts.points(share.rank));
        sort_rows(&mut others, width);
        dedup_rows(&mut others, width);
        let mut order: Vec<u64> = (0..owned).flat_map(|point| [share.ids[point], point as u64]).collect();
        sort_rows(&mut order, 2);
        let count = owned + others.len() / width;
        let (mut rows, mut coordinates) =
            (Vec::with_capacity(count), Vec::with_capacity(count * mesh.run.space));
        for row in order.chunks_exact(2) {
            rows.push(row[0]);
            coordinates.extend_from_slice(mesh.place(share, row[1] as u32));
        }
        for other in others.chunks_exact(width) {
            rows.push(other[0]);
            coordinates.extend(other[1..].iter().map(|bits| f64::from_bits(*bits)));
        }
        PiecePoints { owned, rows, coordinates }
    }

    /// Returns the position of a row in the piece.
    fn position(&self, row: u64) -> Option<u64> {
        let (owned, others) = self.rows.split_at(self.owned);
        let in_others = |_| others.binary_search(&row).map(|at| self.owned + at);
        owned.binary_search(&row).or_else(in_others).ok().map(|at| at as u64)
    }
}

/// Returns the vertices of the cells of a share that are points of other workers.
fn other_vertices(share: &WorkerShare) -> impl Iterator<Item = u32> + '_ {
    let mut is_used = vec![false; share.ids.len()];
    for cell in 0..share.cell_count() {
        share.cell(cell).iter().for_each(|&vertex| is_used[vertex as usize] = true);
    }
    (share.owned as u32..share.ids.len() as u32).filter(move |&vertex| is_used[vertex as usize])
}

/// Returns the piece of a worker, given the number of its first cell.
///
/// # Errors
/// Fails if a vertex of a ghost cell is missing.
pub(super) fn piece(
    mesh: &SharedMesh<'_>,
    share: &WorkerShare,
    ghosts: &Ghosts,
    first_cell: u64,
) -> Result<Piece, String> {
    let layout = Layout { with_ratio: false, ..ghosts.layout };
    let (corners, width) = (layout.corners, layout.width());
    let points = PiecePoints::of(mesh, share, ghosts);
    let mut of_others: Vec<u64> = ghosts.cells(share.rank).collect();
    sort_rows(&mut of_others, width + 1);
    let owned_cells = share.cell_count();
    let count = owned_cells + of_others.len() / (width + 1);
    let mut words = Vec::with_capacity(count * width);
    ShareRows::of(mesh, share, layout).append(&mut words);
    sort_rows(&mut words, width);
    let mut cell_ids = Vec::with_capacity(count);
    cell_ids.extend((first_cell..).take(owned_cells));
    for row in of_others.chunks_exact(width + 1) {
        words.extend_from_slice(&row[..width]);
        cell_ids.push(row[width]);
    }
    let label = |at: usize| words.chunks_exact(width).map(move |row| row[corners + at]);
    let owner = layout.with_owner.then(|| label(0).map(|owner| owner as u32).collect());
    let owning_leaf = layout.with_owner.then(|| label(1).collect());
    let mut cells = words;
    if layout.with_owner {
        cells = cells.chunks_exact(width).flat_map(|row| &row[..corners]).copied().collect();
    }
    let is_missing = AtomicBool::new(false);
    each_chunk_mut(&mut cells, BLOCK, |_, vertices| {
        for vertex in vertices {
            match points.position(*vertex) {
                Some(position) => *vertex = position,
                None => is_missing.store(true, Ordering::Relaxed),
            }
        }
    });
    if is_missing.into_inner() {
        return Err(format!("a vertex of a ghost cell of worker {} is missing", share.rank));
    }
    Ok(Piece {
        dimension: mesh.run.space,
        owned_points: points.owned,
        owned_cells,
        rows: points.rows,
        coordinates: points.coordinates,
        cells,
        cell_ids,
        owner,
        owning_leaf,
    })
}
