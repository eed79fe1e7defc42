//! Voronoi diagrams.

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use septet_doors::Triangulated;

use crate::arrays::{self, Array, Width};
use crate::delaunay::Core;

/// A box: its lower and its upper corner.
type Corners<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>);

/// Runs a query of the Voronoi diagram in a box, or of the unbounded one.
macro_rules! within {
    ($py:ident, $of:ident, $corners:ident, $threads:ident, $query:ident) => {{
        let corners =
            $corners.as_ref().map(|(low, high)| Ok::<_, PyErr>((low.as_slice()?, high.as_slice()?)));
        let corners = corners.transpose()?;
        $of.ask($py, ($of.made.cell_count(), $threads), |t, call| t.$query(corners, call))
    }};
}

/// Returns the area or volume of each Voronoi cell.
#[pyfunction]
pub fn voronoi_volumes(
    py: Python<'_>,
    of: &Core,
    corners: Option<Corners<'_>>,
    threads: Option<usize>,
) -> PyResult<Array> {
    arrays::list(py, within!(py, of, corners, threads, voronoi_volumes)?)
}

/// Returns the centroid of each Voronoi cell.
#[pyfunction]
pub fn voronoi_centroids(
    py: Python<'_>,
    of: &Core,
    corners: Option<Corners<'_>>,
    threads: Option<usize>,
) -> PyResult<Array> {
    arrays::rows(py, within!(py, of, corners, threads, voronoi_centroids)?, of.made.columns())
}

/// Returns the points of the ridges, their vertices as rows (offsets and entries), and their areas.
#[pyfunction]
pub fn voronoi_ridges(
    py: Python<'_>,
    of: &Core,
    threads: Option<usize>,
) -> PyResult<(Array, Array, Array, Array)> {
    let found = of.ask(py, (of.made.cell_count(), threads), |t, call| t.ridges(None, call))?;
    Ok((
        of.width.rows(py, found.points.into_flattened(), 2)?,
        arrays::offsets(py, found.vertices.offsets)?,
        of.width.list(py, found.vertices.indices)?,
        arrays::list(py, found.areas)?,
    ))
}

/// Returns the diagram in a box: its vertices, the points of the ridges, their vertices as rows (offsets and entries), and their
/// areas.
#[pyfunction]
pub fn voronoi_in(
    py: Python<'_>,
    of: &Core,
    low: PyReadonlyArray1<'_, f64>,
    high: PyReadonlyArray1<'_, f64>,
    threads: Option<usize>,
) -> PyResult<(Array, Array, Array, Array, Array)> {
    let (low, high) = (low.as_slice()?, high.as_slice()?);
    let found = of.ask(py, (of.made.cell_count(), threads), |t, call| t.voronoi_in(low, high, call))?;
    Ok((
        arrays::rows(py, found.vertices, of.made.columns())?,
        of.width.rows(py, found.points, 2)?,
        arrays::offsets(py, found.corners.offsets)?,
        of.width.list(py, found.corners.indices)?,
        arrays::list(py, found.areas)?,
    ))
}

/// Returns the vertices of the cell of each point as rows: offsets and entries.
#[pyfunction]
pub fn voronoi_regions(py: Python<'_>, of: &Core, threads: Option<usize>) -> PyResult<(Array, Array)> {
    let found = of.ask(py, (of.made.cell_count(), threads), Triangulated::voronoi_regions)?;
    Ok((arrays::offsets(py, found.offsets)?, of.width.list(py, found.indices)?))
}

/// Returns the corners of the power cells, and the corners of each as rows: offsets and entries.
#[pyfunction]
pub fn power_cells(
    py: Python<'_>,
    of: &Core,
    corners: Option<Corners<'_>>,
    threads: Option<usize>,
) -> PyResult<(Array, Array, Array)> {
    let found = within!(py, of, corners, threads, power_cells)?;
    // There are more corners than points.
    let width = Width::of(found.cells.indices.len(), of.made.cell_count());
    Ok((
        arrays::rows(py, found.corners, of.made.columns())?,
        arrays::offsets(py, found.cells.offsets)?,
        width.list(py, found.cells.indices)?,
    ))
}
