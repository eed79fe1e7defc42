//! The piece of points that do not span the space: all vertices belong to worker 1, and there are no cells.

use septet_protocol::wire::{Ended, Parcel, Processes, WireError};

use super::mesh::SharedMesh;
use super::words::{append, words_of};
use crate::write::formats::pvtu::Piece;

/// The worker that counts as the owner of all points.
pub(super) const FLAT_WORKER: u32 = 1;

/// Sends the vertices to the process of worker 1. Returns the piece of this worker on its process, and an empty piece on
/// the others. Only that process needs memory for all points.
pub(super) fn gather(processes: &mut Processes<'_>, mesh: &SharedMesh<'_>) -> Result<Piece, Ended> {
    let space = mesh.run.space;
    let mut bytes = Vec::with_capacity(8 + 8 * (mesh.row_count() * (space + 1)));
    for (row, place) in mesh.vertices() {
        append(&mut bytes, std::iter::once(row).chain(place.iter().map(|c| c.to_bits())));
    }
    let process = mesh.run.placement.process_of(FLAT_WORKER);
    let arrived = processes.scatter(vec![Parcel { process, bytes }])?;
    let mut piece = Piece { dimension: space, ..Piece::default() };
    let row = 8 * (space + 1);
    let count = arrived.iter().map(|parcel| parcel.bytes.len() / row).sum();
    piece.rows.reserve_exact(count);
    piece.coordinates.reserve_exact(count * space);
    for Parcel { process, bytes } in arrived {
        if !bytes.len().is_multiple_of(row) {
            return Err(WireError::Corrupt { process, reason: "its points are not whole".to_string() }.into());
        }
        for point in bytes.chunks_exact(row) {
            let (id, place) = point.split_at(8);
            piece.rows.extend(words_of(id));
            piece.coordinates.extend(words_of(place).map(f64::from_bits));
        }
    }
    piece.owned_points = piece.rows.len();
    Ok(piece)
}
