//! A grid of one piece: points, cells, and their types.

use super::arrays::{self, Arrays, DataArray};
use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::formats::vtk::kind_of_type;
use crate::read::mesh::{CellKind, FileMesh};
use crate::read::points::ReadOptions;
use crate::read::scalar::Scalar;
use crate::read::text::{Source, integer, number};

/// Reads the mesh.
pub fn parse<'a>(source: Source<'a>, options: &ReadOptions) -> Result<FileMesh<'a>, InputError> {
    let options = &ReadOptions { dimension: None, ..options.clone() };
    let grid = arrays::open(source)?;
    let points = read_points(&grid, options)?;
    let mut mesh = FileMesh::new(source, points, 0);
    mesh.other = grid.strips.map(|place| (place, "a triangle strip".to_owned()));
    read_cells(&grid, &mut mesh)?;
    Ok(mesh)
}

fn read_points<'a>(grid: &Arrays<'a>, options: &ReadOptions) -> Result<Collector<'a>, InputError> {
    let source = grid.source;
    let Some(array) = &grid.points else {
        if grid.point_count == 0 {
            return Collector::new(source, options, (Place::Whole, 3), (0, 0, 1));
        }
        return Err(source.truncated(Place::Whole, "point arrays", 1, 0));
    };
    if array.components != 3 {
        let place = array.place();
        return Err(InputError::UnsupportedDimension {
            path: source.path.to_owned(),
            place,
            found: array.components,
        });
    }
    let values = grid.values(array, Scalar::float, number)?;
    let (found, over) = ((values.len() / 3) as u64, values.len() % 3 > 0);
    agree(grid, array, "points", grid.point_count, found, over)?;
    let place = array.place();
    let mut points = Collector::new(source, options, (place, 3), (found, values.len(), 3))?;
    points.coordinate_type = array.is_binary().then(|| array.scalar.coordinate_type());
    for (i, at) in values.chunks_exact(3).enumerate() {
        let axis = at.iter().position(|c| !c.is_finite()).unwrap_or(0);
        let pushed = points.push(place, at);
        pushed.map_err(|error| error.at(grid.locate(array, 3 * i + axis)))?;
    }
    Ok(points)
}

/// Compares the number of rows with the announced number. `over` is `true` if an incomplete row follows.
pub fn agree(
    grid: &Arrays<'_>,
    array: &DataArray<'_>,
    what: &'static str,
    announced: u64,
    found: u64,
    over: bool,
) -> Result<(), InputError> {
    let place = array.place();
    if found < announced {
        return Err(grid.source.truncated(place, what, announced, found));
    }
    if found > announced || over {
        return Err(grid.source.surplus(place, what, announced));
    }
    Ok(())
}

fn read_cells(grid: &Arrays<'_>, mesh: &mut FileMesh<'_>) -> Result<(), InputError> {
    let source = grid.source;
    let integers = |array: &Option<DataArray<'_>>| match array {
        Some(array) => integers(grid, array),
        None if grid.cell_count == 0 => Ok(Vec::new()),
        None => Err(source.truncated(Place::Whole, "arrays connectivity, offsets and types", 3, 2)),
    };
    let connectivity = integers(&grid.connectivity)?;
    let offsets = integers(&grid.offsets)?;
    let types = if grid.has_polygons { types_of_polygons(&offsets) } else { integers(&grid.types)? };
    for (array, values) in [(&grid.offsets, &offsets), (&grid.types, &types)] {
        if let Some(array) = array {
            agree(grid, array, "cells", grid.cell_count, values.len() as u64, false)?;
        }
    }
    let Some(array) = &grid.connectivity else {
        return Ok(());
    };
    let place = array.place();
    let mut start = 0;
    for (end, cell) in offsets.iter().zip(&types) {
        let range = usize::try_from(*end).ok().and_then(|end| connectivity.get(start..end));
        let nodes = range.ok_or_else(|| {
            source.truncated(
                place,
                "entries of connectivity",
                u64::try_from(*end).unwrap_or(0),
                connectivity.len() as u64,
            )
        })?;
        start += nodes.len();
        let kind = kind_of_type(*cell, nodes.len());
        if kind == CellKind::Other && mesh.other.is_none() {
            mesh.other = Some((place, format!("a cell of VTK type {cell} with {} points", nodes.len())));
        }
        if let Some(list) = mesh.list(kind) {
            for (i, node) in (start - nodes.len()..).zip(nodes) {
                let pushed = list.push(place, i128::from(*node));
                pushed.map_err(|error| error.at(grid.locate(array, i)))?;
            }
        }
    }
    Ok(())
}

/// Returns the VTK types of polygons, which are given by their ends.
fn types_of_polygons(offsets: &[i64]) -> Vec<i64> {
    const TRIANGLE: i64 = 5;
    const POLYGON: i64 = 7;
    let starts = std::iter::once(&0).chain(offsets);
    offsets
        .iter()
        .zip(starts)
        .map(|(end, start)| if end.checked_sub(*start) == Some(3) { TRIANGLE } else { POLYGON })
        .collect()
}

/// Returns the values of an array of integers.
pub fn integers(grid: &Arrays<'_>, array: &DataArray<'_>) -> Result<Vec<i64>, InputError> {
    grid.values(array, |scalar, bytes, endian| narrow(scalar.integer(bytes, endian)), integer)
}

/// Converts an index to `i64`. An index out of range becomes `i64::MAX`, which no point has as its index.
fn narrow(value: i128) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}
