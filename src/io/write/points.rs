//! Writers of point sets in all formats.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::{OutputError, WriteFault};
use super::formats::{WritePoints, check_dimension, writer};
use super::options::{WriteOptions, check_first_id};
use super::records::WriteProgress;
use super::stage::{self, Stage};
use crate::format::{Format, Role};
use septet_core::model::Points;

/// Checks that points can be written under this path, before any other work. `-` is always accepted, and its format is
/// `.xyz` text unless the options state another.
///
/// # Errors
/// Returns an [`OutputError`] that names the obstacle.
pub fn check_points_output(path: &Path, options: &WriteOptions<'_>) -> Result<Format, OutputError> {
    let format = options.point_format_of(path)?;
    if path.as_os_str() != "-" {
        stage::probe(path)?;
    }
    Ok(format)
}

/// Writes points to a file and returns the path. The options or the extension determine the format.
///
/// # Errors
/// Returns an [`OutputError`] if writing fails. An existing file then remains unchanged. The path `-` is refused,
/// because it is not a file.
pub fn write_points(
    path: &Path,
    points: &Points,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<PathBuf>, OutputError> {
    let format = options.point_format_of(path)?;
    if path.as_os_str() == "-" {
        let (path, advice) = (path.to_path_buf(), "write standard output as a stream".to_owned());
        return Err(OutputError::UnknownFormat { path, advice, role: Role::PointSet });
    }
    check_first_id(options.first_id)?;
    let (write, mut progress) = prepare(format, points, path, progress)?;
    let mut stage = Stage::default();
    stage.write(path, |out| write(out, points, options, &mut progress))?;
    let files = stage.commit()?;
    progress.finish();
    Ok(files)
}

/// Writes points to a stream, such as standard output.
///
/// # Errors
/// Returns [`OutputError::Stream`] if writing to the stream fails.
pub fn write_points_to(
    out: &mut dyn Write,
    format: Format,
    points: &Points,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<(), OutputError> {
    check_first_id(options.first_id)?;
    let (write, mut progress) = prepare(format, points, Path::new("-"), progress)?;
    let written = write(out, points, options, &mut progress);
    written.and_then(|()| Ok(out.flush()?)).map_err(WriteFault::of_stream)?;
    progress.finish();
    Ok(())
}

/// Returns the writer of a format of points, and the progress of its records.
fn prepare<'a>(
    format: Format,
    points: &Points,
    path: &Path,
    progress: &'a mut dyn FnMut(u64, u64),
) -> Result<(WritePoints, WriteProgress<'a>), OutputError> {
    let writer = writer(format);
    let write = writer.points.ok_or_else(|| OutputError::unknown(path, Role::PointSet))?;
    check_dimension(format, path, points.dimension())?;
    Ok((write, WriteProgress::new(writer.records_per_point * points.len() as u64, progress)))
}

#[cfg(test)]
#[path = "points_tests.rs"]
mod tests;
