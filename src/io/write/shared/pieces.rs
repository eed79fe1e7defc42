//! `.pvtu` files: every process writes the pieces of its workers, and process 0 the file that lists them. One process has all
//! workers.

use std::borrow::Cow;
use std::path::Path;

use septet_core::cores;
use septet_core::model::MeshView;
use septet_protocol::wire::{Alone, Ended, Processes};

use super::counts::Counts;
use super::fault::{SharedFault, describe};
use super::flat::{self, FLAT_WORKER};
use super::ghosts::Ghosts;
use super::mesh::SharedMesh;
use super::piece::piece;
use crate::write::error::OutputError;
use crate::write::folder::{Folder, Pieces};
use crate::write::formats::pvtu::{Piece, check, stage_list, write_piece};
use crate::write::formats::vtu;
use crate::write::names::pieces_path;
use crate::write::options::WriteOptions;
use crate::write::records::WriteProgress;
use crate::write::row_table::RowTable;
use crate::write::staged::Staged;

/// The content of the pieces, apart from the shares.
enum Content {
    /// Ghost cells.
    Ghosts(Ghosts),
    /// All points, which are those of worker 1, because they do not span the space.
    Flat(Piece),
}

/// The pieces of the workers of a process.
struct OwnPieces<'a> {
    mesh: &'a SharedMesh<'a>,
    counts: &'a Counts,
    table: &'a RowTable<'a>,
    content: Content,
}

/// Writes the pieces of the workers of this process to the folder that process 0 creates.
pub(super) fn write(
    processes: &mut Processes<'_>,
    staged: &mut Staged,
    path: &Path,
    (mesh, counts): (&SharedMesh<'_>, &Counts),
    table: &RowTable<'_>,
) -> Result<(), Ended> {
    let files = staged.create_folder(processes, path, counts.workers)?;
    let own = OwnPieces::gather(processes, (mesh, counts), table)?;
    let mut ignore = |_, _| {};
    let mut written = own.write(&files, 1, &mut WriteProgress::new(0, &mut ignore));
    if processes.process() == 0 && written.is_ok() {
        written = stage_list(&mut staged.stage, path, &files, (&own.empty(), table));
    }
    processes.agree(written.map_err(SharedFault::from), describe)
}

/// Writes the pieces of one process.
pub(in crate::write) fn write_alone(
    staged: &mut Staged,
    path: &Path,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), OutputError> {
    check(path)?;
    let run = mesh.run.ok_or_else(|| OutputError::NoPieces { path: path.to_path_buf() })?;
    let (dropped, source_index) = (0, None);
    let (coordinates, heights) = (mesh.coordinates, mesh.heights);
    let mesh = &SharedMesh { run, coordinates, heights, first: 0, source_index, dropped };
    let mut wire = Alone;
    let processes = &mut Processes::over(&mut wire);
    let ended = |ended: Ended| OutputError::InvalidMesh { reason: ended.to_string() };
    let counts = &Counts::collect(processes, mesh, options.with_owner).map_err(ended)?;
    counts.check(mesh, 0).map_err(|reason| OutputError::InvalidMesh { reason })?;
    let table = &RowTable { heights: heights.map(Cow::Borrowed), ..RowTable::of_options(options) };
    let folder = Folder::create(&pieces_path(path), counts.workers)?;
    let files = folder.pieces().clone();
    // If a piece fails, dropping the folder removes it.
    staged.folders.push(folder);
    let own = OwnPieces::gather(processes, (mesh, counts), table).map_err(ended)?;
    own.write(&files, cores::threads(), progress)?;
    stage_list(&mut staged.stage, path, &files, (&own.empty(), table))
}

impl<'a> OwnPieces<'a> {
    /// Exchanges the ghost cells.
    fn gather(
        processes: &mut Processes<'_>,
        (mesh, counts): (&'a SharedMesh<'a>, &'a Counts),
        table: &'a RowTable<'a>,
    ) -> Result<Self, Ended> {
        let content = if mesh.is_flat() {
            Content::Flat(flat::gather(processes, mesh)?)
        } else {
            Content::Ghosts(Ghosts::exchange(processes, mesh, counts)?)
        };
        Ok(OwnPieces { mesh, counts, table, content })
    }

    /// Writes the pieces, of which at most `together` are in memory.
    fn write(
        &self,
        files: &Pieces,
        together: usize,
        progress: &mut WriteProgress<'_>,
    ) -> Result<(), OutputError> {
        let positions: Vec<usize> = (0..self.mesh.run.shares.len()).collect();
        for batch in positions.chunks(together) {
            let written = cores::map(batch, |&share| self.write_piece(files, share));
            progress.advance(written.into_iter().sum::<Result<u64, OutputError>>()?);
        }
        Ok(())
    }

    /// Writes the piece of a share. Returns the number of records.
    fn write_piece(&self, files: &Pieces, share: usize) -> Result<u64, OutputError> {
        let (share, first_cell) = (&self.mesh.run.shares[share], self.counts.first_cells[share]);
        let made;
        let piece = match &self.content {
            Content::Flat(piece) if share.rank == FLAT_WORKER => piece,
            Content::Flat(_) => {
                made = self.empty();
                &made
            }
            Content::Ghosts(ghosts) => {
                let piece = piece(self.mesh, share, ghosts, first_cell);
                made = piece.map_err(|reason| OutputError::InvalidMesh { reason })?;
                &made
            }
        };
        write_piece(files, share.rank, piece, self.table)?;
        Ok(vtu::records(piece.owned_points, piece.owned_cells))
    }

    /// Returns a piece without points and cells.
    fn empty(&self) -> Piece {
        Piece::empty(self.mesh.run.space, self.counts.with_owner)
    }
}
