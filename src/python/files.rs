//! Readers of files, and the verifier.

use std::path::Path;

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use septet_doors::NONE;
use septet_io::Format;
use septet_io::read::{CellFile, InputError, PointFile, ReadOptions, read, read_mesh};
use septet_verify::{LEVELS, Triangulation, VerifyOptions, verify as verified};

use crate::arrays::{self, Array, Width, flat};
use crate::errors;
use crate::watch::{UNWATCHED, Watch};

/// Reads points, and their cells if the format holds them.
fn read_any(
    path: &Path,
    options: &ReadOptions,
    watch: &Watch,
) -> Result<(PointFile, Option<CellFile>), InputError> {
    let mut progress = |_: u64, _: Option<u64>| watch.unwind_if_cancelled();
    if Format::of_path(path).is_some_and(Format::holds_mesh) {
        match read_mesh(path, options, &mut progress) {
            Ok((points, cells)) => return Ok((points, Some(cells))),
            // A mesh of vertices only.
            Err(InputError::Unsupported { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Ok((read(path, options, &mut progress)?, None))
}

/// Reads a file. Returns its points, and its cells or none.
#[pyfunction]
pub fn read_file(
    py: Python<'_>,
    path: &str,
    columns: Option<Vec<String>>,
    ndim: Option<usize>,
) -> PyResult<(Array, Option<Array>)> {
    let options = ReadOptions { dimension: ndim, columns, ..ReadOptions::default() };
    let watch = Watch::new(None);
    let call = watch.call(None);
    let file = watch.run(py, usize::MAX, || call.within(|| read_any(Path::new(path), &options, &watch)))?;
    let (points, cells) = file.map_err(|error| errors::of_input(py, &error))?;
    let dimension = points.points.dimension();
    let width = Width::of(points.points.len(), cells.as_ref().map_or(0, CellFile::cell_count));
    let cells = cells.map(|file| {
        // Readers check that indices are those of points.
        let rows: Result<Vec<u32>, _> = file.cells.iter().map(|&v| u32::try_from(v)).collect();
        match rows {
            Ok(rows) => width.rows(py, rows, file.dimension + 1),
            Err(_) => arrays::rows(py, file.cells.iter().map(|&v| v as i64).collect(), file.dimension + 1),
        }
    });
    Ok((arrays::rows(py, points.points.coordinates().to_vec(), dimension)?, cells.transpose()?))
}

/// Verifies a triangulation. Returns whether it passes, the faults, and the simplices that they name.
#[pyfunction]
pub fn verify(
    py: Python<'_>,
    points: PyReadonlyArray2<'_, f64>,
    simplices: PyReadonlyArray2<'_, i64>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(bool, Vec<String>, Array)> {
    let dimension = points.shape()[1];
    let width = Width::of(points.shape()[0], simplices.shape()[0]);
    let size = points.shape()[0] + simplices.shape()[0];
    // A negative index becomes a large one, which no point has.
    let cells: Vec<u64> = simplices.as_slice()?.iter().map(|&v| v as u64).collect();
    let mesh = Triangulation { dimension, coordinates: flat(&points)?, cells: &cells };
    let watch = Watch::new(progress);
    // With a number of threads, the verifier runs on a pool of its own.
    let all = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let threads = if size < UNWATCHED { 1 } else { threads.unwrap_or_else(all) };
    let options = VerifyOptions { perturbed: false, threads, any_order: true };
    let report = watch.run(py, size, || {
        let mut step = |stage: &str, _: u64, _: u64| {
            watch.unwind_if_cancelled();
            let position = LEVELS.iter().position(|level| *level == stage).unwrap_or(0);
            watch.note(stage, position as u64, LEVELS.len() as u64);
        };
        Ok(verified(&mesh, &options, &mut step))
    })?;
    let (mut faults, mut named) = (Vec::new(), Vec::new());
    for level in &report.levels {
        for fault in &level.faults {
            faults.push(format!("{}: {fault}", level.name));
            named.extend(fault.cells().into_iter().map(|cell| u32::try_from(cell).unwrap_or(NONE)));
        }
        let more = level.fault_count - level.faults.len() as u64;
        if more > 0 {
            faults.push(format!("{}: {more} more faults", level.name));
        }
    }
    named.sort_unstable();
    named.dedup();
    Ok((report.passed(), faults, width.list(py, named)?))
}
