//! Writers of triangulations and point sets.
//!
//! A file appears under its name only when it is complete. The files of a set appear together. Devices and pipes
//! receive the bytes directly. The output depends on the mesh and the options, but not on the number of threads.

mod buckets;
mod cell_range;
mod elements;
mod error;
mod folder;
mod formats;
mod images;
mod labels;
mod names;
mod netcdf;
mod offsets;
mod options;
mod output;
mod place;
mod points;
mod quality;
mod records;
mod row_table;
mod rows;
mod shared;
#[doc(hidden)]
pub mod stage;
mod staged;
pub mod topology;

use std::io::Write;
use std::path::{Path, PathBuf};

use septet_core::model::MeshView;

pub use error::OutputError;
pub use images::image_columns;
pub use offsets::{check_offsets_output, write_offsets};
pub use options::{MshVersion, Order, WriteOptions};
pub use points::{check_points_output, write_points, write_points_to};
pub use quality::radius_edge_ratio;
pub use rows::{check_rows_output, write_rows, write_rows_to};
pub use shared::{
    GATHER_LIMIT, SharedMesh, check_gathered, check_shared, numbers_on_first, to_first, write_shared,
};

use crate::format::{Files, Format};
use error::WriteFault;
use formats::{Body, poly_mesh, pvtu, writer};
use options::check_first_id;
use records::WriteProgress;
use stage::Stage;
use staged::Staged;

/// Checks that a triangulation can be written under this path, before any other work.
///
/// # Errors
/// Returns an [`OutputError`] that names the obstacle.
pub fn check_output(path: &Path, options: &WriteOptions<'_>) -> Result<Format, OutputError> {
    let format = options.format_of(path)?;
    check_order(path, options)?;
    match format.row().files {
        Files::Pieces => pvtu::check(path)?,
        Files::One => stage::probe(path)?,
        Files::Folder => {
            folder::check(path, &poly_mesh::FILES)?;
            stage::beside(path, |file| {
                std::fs::File::create_new(file).and_then(|_| std::fs::remove_file(file))
            })?;
        }
        Files::Set => {
            stage::probe(path)?;
            format.files(path).iter().try_for_each(|file| stage::probe(file))?;
        }
    }
    Ok(format)
}

/// Checks that the format of a path holds elements of the requested order.
fn check_order(path: &Path, options: &WriteOptions<'_>) -> Result<(), OutputError> {
    let format = options.format_of(path)?;
    if options.order == Order::Two && !format.row().has_order_2 {
        return Err(OutputError::OnlyLinear { path: path.to_owned(), format: format.name() });
    }
    Ok(())
}

/// Checks that a triangulation of this dimension can be written under this path, before it is made.
///
/// # Errors
/// Returns an [`OutputError`] if the format holds only triangulations in the plane, only those in space, or none above three
/// dimensions.
pub fn check_dimension(path: &Path, options: &WriteOptions<'_>, dimension: usize) -> Result<(), OutputError> {
    let format = options.format_of(path)?;
    if format.row().is_plane && dimension != 2 {
        return Err(OutputError::OnlyPlane { path: path.to_owned() });
    }
    if format.row().is_space && dimension == 2 {
        return Err(OutputError::NotPlane { path: path.to_owned(), format: format.name() });
    }
    formats::check_dimension(format, path, dimension)
}

/// Checks that a text file can be written under this path, before any other work.
///
/// # Errors
/// Returns an [`OutputError`] that names the obstacle.
pub fn check_text_output(path: &Path) -> Result<(), OutputError> {
    stage::probe(path)
}

/// Writes text, such as a report or a table, to a file. If its name ends in `.gz`, the text is compressed. The write is
/// atomic, except that a device or pipe receives the text directly.
///
/// # Errors
/// Returns an [`OutputError`] if writing fails. An existing file then remains unchanged.
pub fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    let mut stage = Stage::default();
    stage.write(path, |out| Ok(out.write_all(text.as_bytes())?))?;
    stage.commit().map(|_| ())
}

/// Writes a triangulation to a file and returns the files written.
///
/// The options or the extension determine the format. Each of `.node`, `.ele`, `.face`, `.edge` and `.neigh` writes the
/// whole set (in the plane, without `.face`). `NAME.pvtu` lists the files of the folder `NAME.pieces`, one for each worker, and replaces the
/// folder; the mesh must have [`MeshView::run`]. If the name ends in `.gz`, the output is compressed.
///
/// `progress` receives the number of records written and their total.
///
/// # Errors
/// Returns an [`OutputError`] if writing fails. Existing files then remain unchanged.
pub fn write(
    path: &Path,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<PathBuf>, OutputError> {
    check_dimension(path, options, mesh.dimension)?;
    check_order(path, options)?;
    check_mesh(mesh, options)?;
    let mut staged = Staged::default();
    output::add(&mut staged, path, mesh, options, progress)?;
    staged.commit()
}

/// Writes a triangulation to a stream, such as standard output. The options must state the format.
///
/// # Errors
/// Returns [`OutputError::Stream`] if writing to the stream fails, [`OutputError::UnknownFormat`] if the options
/// state no format, and [`OutputError::NotOneFile`] if the format consists of several files.
pub fn write_to(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<(), OutputError> {
    let path = Path::new("-");
    let format = options.format_of(path)?;
    formats::check_dimension(format, path, mesh.dimension)?;
    check_order(path, options)?;
    let writer = writer(format);
    let Some(Body::One(write)) = writer.mesh else { return Err(OutputError::NotOneFile) };
    check_mesh(mesh, options)?;
    let mut progress = WriteProgress::new((writer.records)(mesh), progress);
    let written = write(out, mesh, options, &mut progress);
    written.and_then(|()| Ok(out.flush()?)).map_err(WriteFault::of_stream)?;
    progress.finish();
    Ok(())
}

/// Checks that the arrays of the mesh and of the options are consistent.
fn check_mesh(mesh: &MeshView<'_>, options: &WriteOptions<'_>) -> Result<(), OutputError> {
    check_first_id(options.first_id)?;
    let invalid = |reason: String| Err(OutputError::InvalidMesh { reason });
    let (dimension, length) = (mesh.dimension, mesh.coordinates.len());
    if !(2..=6).contains(&dimension) {
        return invalid(format!("dimension {dimension} is not between 2 and 6"));
    }
    if !length.is_multiple_of(dimension) {
        return invalid(format!("{length} coordinates do not form whole points"));
    }
    let is_periodic = mesh.run.is_some_and(|run| run.kept.periodic.is_some());
    let check = if is_periodic { topology::check_periodic_cells } else { topology::check_cells };
    if let Err(error) = check(dimension, mesh.point_count(), mesh.cells) {
        return invalid(error.to_string());
    }
    let cells = mesh.cell_count();
    let lengths =
        [("owners", mesh.owner.map(<[u32]>::len)), ("owning leaves", mesh.owning_leaf.map(<[u64]>::len))];
    for (what, length) in lengths {
        if let Some(length) = length
            && length != cells
        {
            return invalid(format!("{length} {what} for {cells} cells"));
        }
    }
    let points = mesh.point_count();
    if let Some(column) = options.point_data.iter().find(|column| column.values.len() != points) {
        return invalid(format!("{} values of {} for {points} points", column.values.len(), column.name));
    }
    if let Some(heights) = mesh.heights.filter(|heights| heights.len() != points || dimension != 2) {
        return invalid(format!("{} heights of {points} points with {dimension} coordinates", heights.len()));
    }
    if let Some(source) = options.source.filter(|source| source.len() != points) {
        return invalid(format!("{} input rows of {points} points", source.len()));
    }
    mesh.labels.map_or(Ok(()), |labels| labels::check(mesh, labels).or_else(invalid))
}

#[cfg(test)]
mod tests;
