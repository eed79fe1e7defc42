//! Writers of point sets in all formats.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::{OutputError, WriteFault};
use super::format::PointFormat;
use super::options::{WriteOptions, check_first_id};
use super::records::{WriteProgress, push_point, write_records};
use super::stage::{self, Stage};
use super::{npy, off, tetgen, vtk, vtu};
use septet_core::model::Points;

/// Checks that points can be written under this path, before any other work. `-` is always accepted, and its format is
/// `.xyz` text unless the options state another.
///
/// # Errors
/// Returns an [`OutputError`] that names the obstacle.
pub fn check_points_output(path: &Path, options: &WriteOptions<'_>) -> Result<PointFormat, OutputError> {
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
    check_first_id(options.first_id)?;
    if path.as_os_str() == "-" {
        let advice = "standard output is not a file, use a stream".to_owned();
        return Err(OutputError::UnknownFormat {
            path: path.to_path_buf(),
            advice,
            known: "file names".to_owned(),
        });
    }
    let mut progress = WriteProgress::new(total(format, points), progress);
    let mut stage = Stage::default();
    stage.write(path, |out| write_body(out, format, points, options, &mut progress))?;
    let files = stage.commit()?;
    progress.finish();
    Ok(files)
}

/// Writes points to a stream, such as standard output.
///
/// # Errors
/// Returns [`OutputError::Stream`] if writing to the stream fails.
pub fn write_points_to(
    writer: &mut dyn Write,
    format: PointFormat,
    points: &Points,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<(), OutputError> {
    check_first_id(options.first_id)?;
    let mut progress = WriteProgress::new(total(format, points), progress);
    let written = write_body(writer, format, points, options, &mut progress);
    written.and_then(|()| Ok(writer.flush()?)).map_err(WriteFault::of_stream)?;
    progress.finish();
    Ok(())
}

/// Returns the number of records to write.
fn total(format: PointFormat, points: &Points) -> u64 {
    let arrays = match format {
        PointFormat::Vtu => 5,
        PointFormat::Vtk => 3,
        _ => 1,
    };
    arrays * points.len() as u64
}

fn write_body(
    out: &mut dyn Write,
    format: PointFormat,
    points: &Points,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, coordinates) = (points.dimension(), points.coordinates());
    match format {
        PointFormat::Node => {
            tetgen::write_nodes(out, dimension, (coordinates, None), options.first_id, progress)
        }
        PointFormat::Xyz => write_lines(out, points, b"", b' ', false, progress),
        PointFormat::Csv => write_lines(out, points, b"", b',', false, progress),
        PointFormat::Obj => write_lines(out, points, b"v ", b' ', true, progress),
        PointFormat::Npy => npy::write_points(out, points, progress),
        PointFormat::Off => off::write_points(out, points, progress),
        PointFormat::Vtu => vtu::write_points(out, points, progress),
        PointFormat::Vtk => vtk::write_points(out, points, progress),
        PointFormat::Ply => write_ply(out, points, progress),
    }
}

fn write_lines(
    out: &mut dyn Write,
    points: &Points,
    prefix: &[u8],
    separator: u8,
    space: bool,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, coordinates) = (points.dimension(), points.coordinates());
    write_records(out, points.len(), progress, |buffer, i| {
        buffer.extend_from_slice(prefix);
        let point = &coordinates[i * dimension..(i + 1) * dimension];
        push_point(buffer, point, separator, space);
        buffer.push(b'\n');
    })?;
    Ok(())
}

fn write_ply(
    out: &mut dyn Write,
    points: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, coordinates) = (points.dimension(), points.coordinates());
    write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points.len())?;
    out.write_all(b"property double x\nproperty double y\nproperty double z\nend_header\n")?;
    write_records(out, points.len(), progress, |buffer, i| {
        for coordinate in &coordinates[i * dimension..(i + 1) * dimension] {
            buffer.extend_from_slice(&coordinate.to_le_bytes());
        }
        if dimension == 2 {
            buffer.extend_from_slice(&0.0f64.to_le_bytes());
        }
    })?;
    Ok(())
}

#[cfg(test)]
#[path = "points_tests.rs"]
mod tests;
