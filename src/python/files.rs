//! Readers of files, and the verifier.

use std::path::{Path, PathBuf};

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use septet_doors::NONE;
use septet_io::Format;
use septet_io::read::{CellFile, InputError, PointFile, ReadOptions, read, read_mesh};
use septet_verify::{
    HIDDEN_SITES, LEVELS, PeriodicBox, Sites, Triangulation, VerifyOptions, verify as verified,
};

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
    path: PathBuf,
    columns: Option<Vec<String>>,
    ndim: Option<usize>,
) -> PyResult<(Array, Option<Array>)> {
    let options = ReadOptions { dimension: ndim, columns, ..ReadOptions::default() };
    let watch = Watch::new(None);
    let call = watch.call(None);
    let file = watch.run(py, usize::MAX, || call.within(|| read_any(&path, &options, &watch)))?;
    let (points, cells) = file.map_err(|error| errors::of_input(py, &error, errors::OF_READ))?;
    if points.rounded > 0 {
        let message = format!(
            "{}: float64 does not hold {} of the integers exactly; round or shift them first",
            path.display(),
            points.rounded
        );
        return Err(errors::of_file(py, &message, &path, None));
    }
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

/// The weights of points; the lengths of a periodic box, and the offsets of the vertices, one after the other.
type Sited<'py> =
    (Option<PyReadonlyArray1<'py, f64>>, Option<Vec<Option<f64>>>, Option<PyReadonlyArray1<'py, i32>>);

/// Returns the position of the level to which a stage of the verifier belongs.
fn level_of(stage: &str) -> usize {
    let level = match stage {
        "points" | "cells" => LEVELS[0],
        "facets" | "vertices" => LEVELS[2],
        other => other,
    };
    LEVELS
        .iter()
        .position(|name| *name == level)
        .unwrap_or(LEVELS.len() - 1 + usize::from(level == HIDDEN_SITES))
}

/// Verifies a triangulation. Returns whether it passes, the faults, and the simplices that they name.
#[pyfunction]
pub fn verify(
    py: Python<'_>,
    points: PyReadonlyArray2<'_, f64>,
    simplices: PyReadonlyArray2<'_, i64>,
    sited: Sited<'_>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(bool, Vec<String>, Array)> {
    let dimension = points.shape()[1];
    let width = Width::of(points.shape()[0], simplices.shape()[0]);
    let size = points.shape()[0] + simplices.shape()[0];
    // A negative index becomes a large one, which no point has.
    let cells: Vec<u64> = simplices.as_slice()?.iter().map(|&v| v as u64).collect();
    let mesh = Triangulation { dimension, coordinates: flat(&points)?, cells: &cells };
    let (weights, lengths, offsets) = &sited;
    let weights = weights.as_ref().map(|weights| weights.as_slice()).transpose()?;
    let offsets = offsets.as_ref().map(|offsets| offsets.as_slice()).transpose()?;
    let periodic =
        lengths.as_ref().map(|lengths| PeriodicBox { lengths, offsets: offsets.unwrap_or_default() });
    let sites = Sites { mesh, weights, periodic };
    let watch = Watch::new(progress);
    // With a number of threads, the verifier runs on a pool of its own.
    let all = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let threads = if size < UNWATCHED { 1 } else { threads.unwrap_or_else(all) };
    let options = VerifyOptions { perturbed: false, threads, any_order: true };
    let count = LEVELS.len() + usize::from(weights.is_some());
    let report = watch.run(py, size, || {
        let mut step = |stage: &str, _: u64, _: u64| {
            watch.unwind_if_cancelled();
            watch.note(stage, level_of(stage) as u64, count as u64);
        };
        let report = verified(sites, &options, &mut step);
        let last = if weights.is_some() { HIDDEN_SITES } else { LEVELS[LEVELS.len() - 1] };
        watch.note(last, count as u64 - 1, count as u64);
        Ok(report)
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
