//! `.pvtu` files: every process writes the pieces of its workers, and process 0 the file that lists them.

use std::path::Path;

use septet_core::result::part::Part as Piece;
use septet_protocol::wire::{Ended, Processes};

use super::counts::Counts;
use super::fault::{SharedFault, describe};
use super::flat::{self, FLAT_WORKER};
use super::ghosts::Ghosts;
use super::mesh::SharedMesh;
use super::piece::piece;
use crate::write::folder::Pieces;
use crate::write::formats::pvtu::{stage_list, write_piece};
use crate::write::options::WriteOptions;
use crate::write::staged::Staged;

/// The content of the pieces, apart from the subdomains.
enum Content {
    /// Ghost cells.
    Ghosts(Ghosts),
    /// All points, which are those of worker 1, because they do not span the space.
    Flat(Piece),
}

/// Writes the pieces of the workers of this process to the folder that process 0 creates.
pub(super) fn write(
    processes: &mut Processes<'_>,
    staged: &mut Staged,
    path: &Path,
    mesh: &SharedMesh<'_>,
    counts: &Counts,
    options: &WriteOptions<'_>,
) -> Result<(), Ended> {
    let files = staged.create_folder(processes, path, counts.workers)?;
    let content = if mesh.is_flat() {
        Content::Flat(flat::gather(processes, mesh)?)
    } else {
        Content::Ghosts(Ghosts::exchange(processes, mesh, counts)?)
    };
    let mut written = write_pieces(&files, &content, mesh, counts, options);
    if processes.process() == 0 && written.is_ok() {
        let empty = Piece { dimension: mesh.run.space, ..Piece::default() };
        let list = stage_list(&mut staged.stage, path, &empty, options, &files, counts.workers);
        written = list.map_err(SharedFault::from);
    }
    processes.agree(written, describe)
}

/// Writes one piece after another, so that one of them is in memory.
fn write_pieces(
    files: &Pieces,
    content: &Content,
    mesh: &SharedMesh<'_>,
    counts: &Counts,
    options: &WriteOptions<'_>,
) -> Result<(), SharedFault> {
    let space = mesh.run.space;
    for (subdomain, &first_cell) in mesh.run.shares.iter().zip(&counts.first_cells) {
        let worker = subdomain.rank;
        match content {
            Content::Ghosts(ghosts) => {
                let piece = piece(subdomain, ghosts, space, first_cell).map_err(SharedFault::inconsistent)?;
                write_piece(files, worker, &piece, options)?;
            }
            Content::Flat(piece) if worker == FLAT_WORKER => write_piece(files, worker, piece, options)?,
            Content::Flat(_) => {
                let empty = Piece { dimension: space, ..Piece::default() };
                write_piece(files, worker, &empty, options)?;
            }
        }
    }
    Ok(())
}
