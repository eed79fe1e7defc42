//! A `.pvtu` file, which lists `.vtu` files as its pieces. A point and a cell belong to one piece, and are ghosts in others.

mod agreement;
mod piece;

use std::path::{Path, PathBuf};

use septet_core::model::Points;

use super::arrays::first_tag;
use super::xml::next_tag;
use crate::read::cells::{CellFile, CellOptions};
use crate::read::error::{InputError, Place};
use crate::read::listed::ListedFile;
use crate::read::load::{Packing, load};
use crate::read::points::{PointFile, ReadOptions};
use crate::read::terrain::dimension_of_cells;
use crate::read::text::Source;
use agreement::Agreed;
use piece::{ADVICE, Piece};

/// Reads the cells of all pieces that are not ghosts. Their vertices are the global ids of points.
pub fn read_cells(source: Source<'_>, options: &CellOptions) -> Result<CellFile, InputError> {
    let (pieces, agreed) = read_pieces(source, options)?;
    let mut file = cells_of(&pieces, &agreed);
    for vertex in &mut file.cells {
        *vertex = agreed.ids[*vertex as usize];
    }
    check_range(&file, options)?;
    Ok(file)
}

/// Reads the points and the cells of all pieces without ghosts. The points ascend by their global ids, which are their
/// rows.
pub fn read_both(source: Source<'_>, options: &ReadOptions) -> Result<(PointFile, CellFile), InputError> {
    let chosen = CellOptions { dimension: dimension_of_cells(options), ..CellOptions::default() };
    let (pieces, agreed) = read_pieces(source, &chosen)?;
    let cells = cells_of(&pieces, &agreed);
    let is_plane = cells.dimension == 2 && !cells.cells.is_empty();
    let points = if is_plane && agreed.places.iter().all(|place| place.z == 0.0) {
        Points::Plane(agreed.places.iter().map(|place| place.truncate()).collect())
    } else {
        Points::Space(agreed.places)
    };
    let mut file = PointFile::of_points(points);
    // Duplicates and dropped rows are in no piece.
    if agreed.ids.iter().zip(0..).any(|(id, at)| *id != at) {
        file.source_index = Some(agreed.ids);
    }
    Ok((file, cells))
}

/// Reads the pieces, and compares their ghosts.
fn read_pieces(source: Source<'_>, options: &CellOptions) -> Result<(Vec<Piece>, Agreed), InputError> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut dimension = None;
    for path in paths(source)? {
        let data = load(&path, Packing::of(&path), &mut |_, _| {})?;
        let piece = Piece::read(Source { path: &path, data: &data }, options)?;
        if !piece.is_empty() {
            if dimension.is_some_and(|found| found != piece.dimension) {
                return Err(source.unsupported(
                    Place::Whole,
                    "triangles and tetrahedra in its pieces",
                    ADVICE,
                ));
            }
            dimension = Some(piece.dimension);
        }
        pieces.push(piece);
    }
    let agreed = agreement::check(&pieces)?;
    Ok((pieces, agreed))
}

/// Returns the cells of all pieces that are not ghosts. Their vertices are positions among the agreed points.
fn cells_of(pieces: &[Piece], agreed: &Agreed) -> CellFile {
    let dimension = pieces.iter().find(|piece| !piece.is_empty()).map_or(3, |piece| piece.dimension);
    let mut file =
        CellFile { dimension, cells: Vec::new(), first_id: 0, notes: Vec::new(), pieces: Vec::new() };
    for (piece, positions) in pieces.iter().zip(&agreed.positions) {
        let first_row = file.cell_count() as u64;
        for (_, cell) in piece.owned_cells() {
            file.cells.extend(cell.iter().map(|&vertex| positions[vertex as usize]));
        }
        let rows = file.cell_count() as u64 - first_row;
        file.pieces.push(ListedFile { path: piece.path.clone(), first_row, rows });
        file.notes.extend(piece.notes.iter().cloned());
    }
    file
}

/// Refuses vertices beyond the number of points, if it is given.
fn check_range(file: &CellFile, options: &CellOptions) -> Result<(), InputError> {
    let Some(limit) = options.point_count else { return Ok(()) };
    let Some(at) = file.cells.iter().position(|vertex| *vertex >= limit) else { return Ok(()) };
    let row = (at / (file.dimension + 1)) as u64;
    let piece = ListedFile::of_row(&file.pieces, row);
    let (path, first) = piece.map_or((PathBuf::new(), 0), |piece| (piece.path.clone(), piece.first_row));
    let value = i128::from(file.cells[at]);
    let (place, cell, limit) = (Place::Whole, row - first, Some(limit));
    Err(InputError::OutOfRangeIndex { path, place, cell, value, first: 0, limit })
}

/// Returns the paths of the pieces.
fn paths(source: Source<'_>) -> Result<Vec<PathBuf>, InputError> {
    let root =
        first_tag(source.data, b"VTKFile").filter(|root| root.attribute("type") == Some("PUnstructuredGrid"));
    let mut at = root
        .ok_or_else(|| source.bad_at(0, "no parallel grid", "a VTK XML file of type PUnstructuredGrid"))?
        .end;
    let folder = source.path.parent().unwrap_or(Path::new(""));
    let (mut paths, mut is_closed) = (Vec::new(), false);
    while let Some(tag) = next_tag(source.data, at) {
        at = tag.end;
        is_closed |= tag.name == b"VTKFile" && tag.closing;
        if tag.name == b"Piece" && !tag.closing {
            let name = tag.attribute("Source");
            let name = name.ok_or_else(|| source.bad_at(tag.start, "no Source", "the file of the piece"))?;
            paths.push(folder.join(unescaped(name)));
        }
    }
    if !is_closed {
        return Err(source.truncated(Place::Whole, "closing tag VTKFile", 1, 0));
    }
    Ok(paths)
}

/// Replaces the entities of XML.
fn unescaped(name: &str) -> String {
    name.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}
