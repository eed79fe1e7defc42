//! Writers of triangulations and point sets.
//!
//! A file appears under its name only when it is complete; the files of a set appear together. Devices and pipes are
//! written to as they are. The bytes depend on the mesh and the options alone, not on the number of threads.

mod buckets;
mod error;
mod format;
mod labels;
mod medit;
mod msh;
mod msh_labelled;
mod npy;
mod off;
mod options;
mod points;
mod quality;
mod records;
#[doc(hidden)]
pub mod stage;
mod stl;
mod tetgen;
pub mod topology;
mod vtu;
mod vtu_faces;

use std::path::{Path, PathBuf};

use septet_core::model::MeshView;

pub use error::OutputError;
pub use format::{MshVersion, OutputFormat, PointFormat};
pub use options::WriteOptions;
pub use points::{check_points_output, write_points, write_points_to};
pub use quality::radius_edge_ratio;

use options::check_first_id;
use records::Progress;
use stage::Stage;

/// Checks before any work starts that the path can be written and its extension is known.
///
/// # Errors
/// An [`OutputError`] that tells what stands in the way.
pub fn check_output(path: &Path) -> Result<OutputFormat, OutputError> {
    let format = OutputFormat::of(path)?;
    stage::probe(path)?;
    if format == OutputFormat::TetGen {
        for file in tetgen::siblings(path) {
            stage::probe(&file)?;
        }
    }
    Ok(format)
}

/// Checks before any work starts that a file of text can be written under this path.
///
/// # Errors
/// An [`OutputError`] that tells what stands in the way.
pub fn check_text_output(path: &Path) -> Result<(), OutputError> {
    stage::probe(path)
}

/// Writes text (a report, a table) to a file that appears whole or not at all; to a device or a pipe as it is.
///
/// # Errors
/// An [`OutputError`]; a file that was there before remains as it was.
pub fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    let mut stage = Stage::default();
    stage.write(path, |out| Ok(out.write_all(text.as_bytes())?))?;
    stage.commit().map(|_| ())
}

/// The second file of a `.vtu` of a mesh of a domain, which has its faces: `mesh.faces.vtu` beside `mesh.vtu`.
pub fn faces_path(path: &Path) -> PathBuf {
    path.with_extension("faces.vtu")
}

/// Writes one output; returns the files written. Naming any one of `.node`, `.ele`, `.face`,
/// `.edge` and `.neigh` writes the whole set beside it (in the plane there is no `.face`). A `.vtu` of a mesh with
/// labels has its faces in a file of their own ([`faces_path`]).
///
/// `progress` hears how many of how many records are done.
///
/// # Errors
/// An [`OutputError`]; the files that were there before remain as they were.
pub fn write(
    path: &Path,
    mesh: &MeshView<'_>,
    options: &WriteOptions,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<PathBuf>, OutputError> {
    let format = OutputFormat::of(path)?;
    check_mesh(mesh)?;
    check_first_id(options.first_id)?;
    let total = match format {
        OutputFormat::Vtu => vtu::records(mesh),
        OutputFormat::TetGen => tetgen::records(mesh),
        OutputFormat::Npy | OutputFormat::Stl => mesh.cell_count() as u64,
        OutputFormat::Msh(_) | OutputFormat::Medit | OutputFormat::Off => {
            (mesh.point_count() + mesh.cell_count()) as u64
        }
    };
    let mut progress = Progress::new(total, progress);
    let mut stage = Stage::default();
    match format {
        OutputFormat::TetGen => tetgen::write(path, mesh, options, &mut stage, &mut progress)?,
        _ => stage.write(path, |out| match format {
            OutputFormat::Vtu => vtu::write(out, mesh, options, &mut progress),
            OutputFormat::Msh(version) => {
                msh::write(out, mesh, version.unwrap_or(options.msh), &mut progress)
            }
            OutputFormat::Medit => medit::write(out, mesh, &mut progress),
            OutputFormat::Npy => npy::write_cells(out, mesh, &mut progress),
            OutputFormat::Stl => stl::write(out, mesh, &mut progress),
            OutputFormat::Off | OutputFormat::TetGen => off::write(out, mesh, &mut progress),
        })?,
    }
    if let (OutputFormat::Vtu, Some(labels)) = (format, mesh.labels) {
        stage.write(&faces_path(path), |out| vtu_faces::write(out, mesh, labels, &mut progress))?;
    }
    let files = stage.commit()?;
    progress.finish();
    Ok(files)
}

/// Do the arrays fit together?
fn check_mesh(mesh: &MeshView<'_>) -> Result<(), OutputError> {
    let invalid = |reason: String| Err(OutputError::InvalidMesh { reason });
    let (dimension, length) = (mesh.dimension, mesh.coordinates.len());
    if !(2..=3).contains(&dimension) {
        return invalid(format!("dimension {dimension} is neither 2 nor 3"));
    }
    if !length.is_multiple_of(dimension) {
        return invalid(format!("{length} coordinates do not make whole points"));
    }
    if let Err(error) = topology::check_cells(dimension, mesh.point_count(), mesh.cells) {
        return invalid(error.to_string());
    }
    let cells = mesh.cell_count();
    let lengths =
        [("owners", mesh.owner.map(<[u32]>::len)), ("home leaves", mesh.home_leaf.map(<[u64]>::len))];
    for (what, length) in lengths {
        if let Some(length) = length
            && length != cells
        {
            return invalid(format!("{length} {what} for {cells} cells"));
        }
    }
    mesh.labels.map_or(Ok(()), |labels| labels::check(mesh, labels).or_else(invalid))
}

#[cfg(test)]
mod tests;
