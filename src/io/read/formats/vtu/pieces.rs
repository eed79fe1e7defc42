//! The cells of a `.pvtu` file, which lists `.vtu` files as its pieces. A cell belongs to one piece, and is a ghost in others.

use std::path::{Path, PathBuf};

use super::arrays::{self, Arrays, DataArray, first_tag};
use super::xml::next_tag;
use super::{agree, integers, parse};
use crate::read::cells::{CellFile, CellOptions, Indices};
use crate::read::error::{InputError, Place};
use crate::read::load::{Packing, load};
use crate::read::points::ReadOptions;
use crate::read::text::Source;

/// The bit of a ghost cell (`DUPLICATECELL`).
const GHOST: i64 = 1;

/// The data of a piece besides its cells.
const ADVICE: &str = "give a .pvtu file of septet, or a .vtu file of the whole triangulation";

/// Reads the cells of all pieces that are not ghosts. Their vertices are the global ids of points.
pub fn read_pieces(source: Source<'_>, options: &CellOptions) -> Result<CellFile, InputError> {
    let mut all = CellFile {
        dimension: options.dimension.unwrap_or(3),
        cells: Vec::new(),
        first_id: 0,
        notes: Vec::new(),
    };
    for path in paths(source)? {
        let data = load(&path, Packing::of(&path), &mut |_, _| {})?;
        let piece = read_piece(Source { path: &path, data: &data }, options)?;
        if !all.cells.is_empty() && !piece.cells.is_empty() && all.dimension != piece.dimension {
            return Err(source.unsupported(Place::Whole, "triangles and tetrahedra in its pieces", ADVICE));
        }
        if !piece.cells.is_empty() {
            all.dimension = piece.dimension;
        }
        all.cells.extend(piece.cells);
    }
    Ok(all)
}

/// Returns the paths of the pieces.
fn paths(source: Source<'_>) -> Result<Vec<PathBuf>, InputError> {
    let root =
        first_tag(source.data, b"VTKFile").filter(|root| root.attribute("type") == Some("PUnstructuredGrid"));
    let mut at = root
        .ok_or_else(|| source.bad_at(0, "no parallel grid", "a VTK XML file of type PUnstructuredGrid"))?
        .end;
    let folder = source.path.parent().unwrap_or(Path::new(""));
    let mut paths = Vec::new();
    while let Some(tag) = next_tag(source.data, at) {
        at = tag.end;
        if tag.name == b"Piece" && !tag.closing {
            let name = tag.attribute("Source");
            let name = name.ok_or_else(|| source.bad_at(tag.start, "no Source", "the file of the piece"))?;
            paths.push(folder.join(unescaped(name)));
        }
    }
    Ok(paths)
}

/// Replaces the entities of XML.
fn unescaped(name: &str) -> String {
    name.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

fn read_piece(source: Source<'_>, options: &CellOptions) -> Result<CellFile, InputError> {
    let grid = arrays::open(source)?;
    let file = parse(source, &ReadOptions::default())?.into_cells(options)?;
    let ids = values(&grid, grid.point_ids.as_ref(), "points", grid.point_count)?;
    let ghosts = values(&grid, grid.ghosts.as_ref(), "cells", grid.cell_count)?;
    if file.cell_count() as u64 != grid.cell_count {
        return Err(source.unsupported(Place::Whole, "a piece with cells of several kinds", ADVICE));
    }
    let width = file.dimension + 1;
    let mut cells = Indices::new(source, width, 0, options.point_count);
    let own = file.cells.chunks_exact(width).zip(&ghosts).filter(|(_, ghost)| **ghost & GHOST == 0);
    for vertex in own.flat_map(|(cell, _)| cell) {
        cells.push(Place::Whole, i128::from(ids[*vertex as usize]))?;
    }
    Ok(cells.finish(file.notes))
}

/// Returns the values of an array of a piece, one for each of `count` points or cells.
fn values(
    grid: &Arrays<'_>,
    array: Option<&DataArray<'_>>,
    what: &'static str,
    count: u64,
) -> Result<Vec<i64>, InputError> {
    let Some(array) = array else {
        let needed = "a piece without GlobalPointIds and vtkGhostType";
        return Err(grid.source.unsupported(Place::Whole, needed, ADVICE));
    };
    let values = integers(grid, array)?;
    agree(grid, array, what, count, values.len() as u64, false)?;
    Ok(values)
}
