//! One output of a triangulation that a process has as a whole.

use std::path::Path;

use septet_core::model::MeshView;

use super::error::OutputError;
use super::formats::{Body, vtu_faces, writer};
use super::input_rows::InputRows;
use super::names::faces_path;
use super::options::WriteOptions;
use super::records::WriteProgress;
use super::staged::Staged;
use crate::format::{Format, Role};

/// Writes a triangulation under temporary names. Points are numbered by the rows of the input if the format asks for it
/// and rows were dropped.
pub(super) fn add(
    staged: &mut Staged,
    path: &Path,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<(), OutputError> {
    let format = options.format_of(path)?;
    let Some(kept) = options.kept.filter(|_| format.row().has_input_rows) else {
        return add_as(format, staged, (path, mesh), options, progress);
    };
    let rows = InputRows::of(mesh, options.point_data, kept);
    let options = WriteOptions { point_data: &rows.columns, kept: None, ..*options };
    add_as(format, staged, (path, &rows.view(mesh)), &options, progress)
}

fn add_as(
    format: Format,
    staged: &mut Staged,
    (path, mesh): (&Path, &MeshView<'_>),
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<(), OutputError> {
    let writer = writer(format);
    let body = writer.mesh.ok_or_else(|| OutputError::unknown(path, Role::Triangulation))?;
    let mut progress = WriteProgress::new((writer.records)(mesh), progress);
    match body {
        Body::Pieces(write) => write(path, mesh, options, staged, &mut progress)?,
        Body::Set(write) => write(path, mesh, options, &mut staged.stage, &mut progress)?,
        Body::One(write) => staged.stage.write(path, |out| write(out, mesh, options, &mut progress))?,
    }
    if let (Format::Vtu, Some(labels)) = (format, mesh.labels) {
        staged.stage.write(&faces_path(path), |out| vtu_faces::write(out, mesh, labels, &mut progress))?;
    }
    progress.finish();
    Ok(())
}
