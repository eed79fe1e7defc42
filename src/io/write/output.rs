//! One output of a triangulation that a process has as a whole.

use std::path::Path;

use septet_core::model::MeshView;

use super::error::OutputError;
use super::folder::Folder;
use super::formats::{Body, poly_mesh, writer};
use super::options::WriteOptions;
use super::records::WriteProgress;
use super::shared::pieces;
use super::staged::Staged;
use crate::format::Role;

/// Writes a triangulation under temporary names.
pub(super) fn add(
    staged: &mut Staged,
    path: &Path,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<(), OutputError> {
    let format = options.format_of(path)?;
    let writer = writer(format);
    let body = writer.mesh.ok_or_else(|| OutputError::unknown(path, Role::Triangulation))?;
    let mut progress = WriteProgress::new((writer.records)(mesh), progress);
    match body {
        Body::Pieces => pieces::write_alone(staged, path, mesh, options, &mut progress)?,
        Body::Folder => {
            let folder = Folder::create_named(path, &poly_mesh::FILES)?;
            poly_mesh::write(folder.pieces(), mesh, &mut progress)?;
            staged.folders.push(folder);
        }
        Body::Set(write) => write(path, mesh, options, &mut staged.stage, &mut progress)?,
        Body::One(write) => staged.stage.write(path, |out| write(out, mesh, options, &mut progress))?,
    }
    progress.finish();
    Ok(())
}
