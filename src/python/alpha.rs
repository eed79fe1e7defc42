//! Alpha complexes.

use pyo3::prelude::*;
use septet_doors::Triangulated;

use crate::arrays::{self, Array};
use crate::delaunay::Core;

/// Returns cells, facets, their values, edges and their values.
#[pyfunction]
pub fn alpha_filtration(py: Python<'_>, of: &Core) -> PyResult<(Array, Array, Array, Array, Array)> {
    let columns = of.made.columns();
    let found = of.ask(py, (of.made.cell_count(), of.threads()), Triangulated::alpha_filtration)?;
    Ok((
        arrays::list(py, found.cells)?,
        of.width.rows(py, found.facets, columns)?,
        arrays::list(py, found.facet_values)?,
        of.width.rows(py, found.edges, 2)?,
        arrays::list(py, found.edge_values)?,
    ))
}

/// Returns whether each cell belongs to the complex of a radius, its boundary, its singular facets, and its volume.
#[pyfunction]
pub fn alpha_shape(py: Python<'_>, of: &Core, radius: f64) -> PyResult<(Array, Array, Array, f64)> {
    let columns = of.made.columns();
    let found = of.ask(py, (of.made.cell_count(), of.threads()), |t, call| t.alpha_shape(radius, call))?;
    Ok((
        arrays::list(py, found.cells)?,
        of.width.rows(py, found.boundary, columns)?,
        of.width.rows(py, found.singular, columns)?,
        found.volume,
    ))
}
