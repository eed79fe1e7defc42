//! The piece of a worker, made from its subdomain and its ghost cells.

use rayon::prelude::*;
use septet_core::WorkerShare;
use septet_core::result::part::Part as Piece;

use super::cells::append_rows;
use super::ghosts::Ghosts;
use super::words::{dedup_rows, sort_rows};

/// The points of a piece.
struct PiecePoints {
    owned: usize,
    /// Input indices: those of the worker, ascending, then those of others, ascending.
    ids: Vec<u64>,
    coordinates: Vec<f64>,
}

impl PiecePoints {
    /// Returns the points of a subdomain, of which `owned` belong to the worker, and the other points of ghost cells.
    fn of(subdomain: &WorkerShare, ghosts: &Ghosts, space: usize) -> Self {
        let (owned, width) = (subdomain.owned, space + 1);
        let mut others: Vec<u64> = Vec::new();
        for (id, place) in subdomain.ids.iter().zip(subdomain.coordinates.chunks_exact(space)).skip(owned) {
            others.push(*id);
            others.extend(place.iter().map(|coordinate| coordinate.to_bits()));
        }
        others.extend(ghosts.points(subdomain.rank));
        sort_rows(&mut others, width);
        dedup_rows(&mut others, width);
        let mut order: Vec<u32> = (0..owned as u32).collect();
        order.par_sort_unstable_by_key(|&point| subdomain.ids[point as usize]);
        let count = owned + others.len() / width;
        let (mut ids, mut coordinates) = (Vec::with_capacity(count), Vec::with_capacity(count * space));
        for point in order.into_iter().map(|point| point as usize) {
            ids.push(subdomain.ids[point]);
            coordinates.extend_from_slice(&subdomain.coordinates[point * space..][..space]);
        }
        for other in others.chunks_exact(width) {
            ids.push(other[0]);
            coordinates.extend(other[1..].iter().map(|bits| f64::from_bits(*bits)));
        }
        PiecePoints { owned, ids, coordinates }
    }

    /// Returns the position of a point in the piece.
    fn position(&self, id: u64) -> Option<u64> {
        let (owned, others) = self.ids.split_at(self.owned);
        let in_others = |_| others.binary_search(&id).map(|at| self.owned + at);
        owned.binary_search(&id).or_else(in_others).ok().map(|at| at as u64)
    }
}

/// Returns the piece of a worker, given the number of its first cell.
///
/// # Errors
/// Fails if a vertex of a ghost cell is missing.
pub(super) fn piece(
    subdomain: &WorkerShare,
    ghosts: &Ghosts,
    space: usize,
    first_cell: u64,
) -> Result<Piece, String> {
    let corners = space + 1;
    let points = PiecePoints::of(subdomain, ghosts, space);
    let mut of_others: Vec<u64> = ghosts.cells(subdomain.rank).collect();
    sort_rows(&mut of_others, corners + 1);
    let owned_cells = subdomain.cell_count();
    let count = owned_cells + of_others.len() / (corners + 1);
    let mut cells = Vec::with_capacity(count * corners);
    append_rows(subdomain, space, false, &mut cells);
    sort_rows(&mut cells, corners);
    let mut cell_ids = Vec::with_capacity(count);
    cell_ids.extend((first_cell..).take(owned_cells));
    for row in of_others.chunks_exact(corners + 1) {
        cells.extend_from_slice(&row[..corners]);
        cell_ids.push(row[corners]);
    }
    let found = cells.par_iter_mut().try_for_each(|vertex| {
        *vertex = points.position(*vertex)?;
        Some(())
    });
    if found.is_none() {
        return Err(format!("a vertex of a ghost cell of worker {} is missing", subdomain.rank));
    }
    Ok(Piece {
        dimension: space,
        owned_points: points.owned,
        owned_cells,
        point_ids: points.ids,
        coordinates: points.coordinates,
        cells,
        cell_ids,
        owner: None,
        owning_leaf: None,
    })
}
