//! Reads a file by the reader of its format.

use std::io::Read;
use std::path::Path;

use super::cells::{CellFile, CellOptions};
use super::error::{InputError, Place};
use super::format::{self, Format};
use super::load::{self, Packing};
use super::points::{PointFile, ReadOptions, ReadProgress};
use super::text::Source;
use super::{cells, columns, extension, medit, msh, node, npy, obj, off, ply, raw, signature, stl, vtk, vtu};
use crate::ending;

/// Reads points from a file, or from standard input if `path` is `-`. From a mesh (`.vtu`, `.vtk`, `.msh`, `.mesh`) it
/// reads the vertices.
///
/// # Errors
/// Returns [`InputError`] if the file is missing, of unknown format or damaged, if it has invalid points and
/// `skip_invalid` is not set, or if its columns are ambiguous.
pub fn read(
    path: &Path,
    options: &ReadOptions,
    progress: &mut ReadProgress<'_>,
) -> Result<PointFile, InputError> {
    check_options(path, options)?;
    points(path, &load::load(path, Packing::of_points(path, options), progress)?, options)
}

/// Reads points from any reader. `name` is the file in messages, and its extension determines the format and gzip as in
/// [`read`]. `total` is the size in bytes, if it is known.
///
/// # Errors
/// See [`read`].
pub fn read_from<R: Read>(
    reader: R,
    name: &Path,
    total: Option<u64>,
    options: &ReadOptions,
    progress: &mut ReadProgress<'_>,
) -> Result<PointFile, InputError> {
    check_options(name, options)?;
    let packing = Packing::of_points(name, options);
    points(name, &load::load_from(reader, name, total, packing, progress)?, options)
}

/// Reads cells from a file, or from standard input if `path` is `-`.
///
/// # Errors
/// Returns [`InputError`] if the file is missing, of unknown format or damaged, if it refers to points that do not
/// exist, or if it has cells other than triangles and tetrahedra.
pub fn read_cells(
    path: &Path,
    options: &CellOptions,
    progress: &mut ReadProgress<'_>,
) -> Result<CellFile, InputError> {
    check_dimension(path, options.dimension)?;
    cell_list(path, &load::load(path, Packing::of(path), progress)?, options)
}

/// Reads cells from any reader. `name` and `total` are as in [`read_from`].
///
/// # Errors
/// See [`read_cells`].
pub fn read_cells_from<R: Read>(
    reader: R,
    name: &Path,
    total: Option<u64>,
    options: &CellOptions,
    progress: &mut ReadProgress<'_>,
) -> Result<CellFile, InputError> {
    check_dimension(name, options.dimension)?;
    cell_list(name, &load::load_from(reader, name, total, Packing::of(name), progress)?, options)
}

/// Checks the options for a file of points before it is read.
pub(super) fn check_options(path: &Path, options: &ReadOptions) -> Result<(), InputError> {
    if let (Some(Format::Raw(_)), Some(known)) = (options.format, Format::of_path(path)) {
        return Err(InputError::NotRaw { path: path.to_owned(), format: known.name() });
    }
    check_dimension(path, options.dimension)
}

fn check_dimension(path: &Path, dimension: Option<usize>) -> Result<(), InputError> {
    match dimension {
        None | Some(2 | 3) => Ok(()),
        Some(found) => {
            let (path, found) = (path.to_owned(), found as u64);
            Err(InputError::UnsupportedDimension { path, place: Place::Whole, found })
        }
    }
}

/// Returns the format of a file of points, given by its name, or by its content if the name does not determine it.
/// Standard input is a table unless its content identifies another format.
fn format_of_points(path: &Path, data: &[u8]) -> Option<Format> {
    let named = Format::of_path(path);
    // The rows of a list of cells also form a table.
    let known = match named {
        Some(Format::Text) if signature::is_ele(data) => Some(Format::Ele),
        Some(Format::Node) if signature::is_ele_despite_name(data) => Some(Format::Ele),
        _ => named.or_else(|| Format::of_content(data)),
    };
    let is_table = || path.as_os_str() == "-" || (extension::may_be_table(path) && columns::is_table(data));
    known.or_else(|| is_table().then_some(Format::Text))
}

pub(super) fn points(path: &Path, data: &[u8], options: &ReadOptions) -> Result<PointFile, InputError> {
    let read = parsed_points(path, data, options);
    read.map_err(
        |error| if is_domain(path, data) { a_domain(Source { path, data }, "points") } else { error },
    )
}

/// Returns `true` if the name or the content is that of a `.poly` or `.smesh` file.
pub(super) fn is_domain(path: &Path, data: &[u8]) -> bool {
    matches!(ending::extension(path).as_str(), "poly" | "smesh") || signature::is_poly(data)
}

/// Returns the error for a domain instead of points or cells.
pub(super) fn a_domain(source: Source<'_>, wanted: &str) -> InputError {
    source.unsupported(Place::Whole, format!("a domain (.poly) as {wanted}"), "mesh it with `septet mesh`")
}

fn parsed_points(path: &Path, data: &[u8], options: &ReadOptions) -> Result<PointFile, InputError> {
    let source = Source { path, data };
    let Some(format) = options.format.or_else(|| format_of_points(path, data)) else {
        let (path, advice) = (path.to_owned(), format::advice(path));
        return Err(InputError::UnknownFormat { path, advice, known: Format::POINTS });
    };
    if format != Format::Text && (options.columns.is_some() || options.keep_columns) {
        return Err(InputError::NotATable { path: path.to_owned(), format: format.name() });
    }
    match format {
        Format::Node => node::read(source, options),
        Format::Text => columns::read(source, options),
        Format::Npy => npy::read(source, options),
        Format::Raw(rows) => raw::read(source, rows, options),
        Format::Off => off::read(source, options),
        Format::Ply => ply::read(source, options),
        Format::Stl => stl::read(source, options),
        Format::Obj => obj::read(source, options),
        Format::Vtu => vtu::parse(source, options)?.into_points(options),
        Format::Vtk => vtk::parse(source, options)?.into_points(options),
        Format::Msh => msh::parse(source, options)?.into_points(options),
        Format::Medit => medit::parse(source, options)?.into_points(options),
        Format::Ele => {
            let what = "a list of cells (.ele) as points";
            let advice =
                "give the .node file of its points, or check the cells with `septet verify POINTS CELLS`";
            Err(source.unsupported(Place::Whole, what, advice))
        }
    }
}

pub(super) fn cell_list(path: &Path, data: &[u8], options: &CellOptions) -> Result<CellFile, InputError> {
    let source = Source { path, data };
    let plain = ReadOptions::default();
    let cells = match options.format.or_else(|| Format::of_path(path)).or_else(|| Format::of_content(data)) {
        Some(Format::Ele) => cells::read_ele(source, options)?,
        Some(Format::Npy) => npy::read_cells(source, options)?,
        Some(Format::Off) => off::read_cells(source)?,
        Some(Format::Vtu) => vtu::parse(source, &plain)?.into_cells(options)?,
        Some(Format::Vtk) => vtk::parse(source, &plain)?.into_cells(options)?,
        Some(Format::Msh) => msh::parse(source, &plain)?.into_cells(options)?,
        Some(Format::Medit) => medit::parse(source, &plain)?.into_cells(options)?,
        _ if is_domain(path, data) => return Err(a_domain(source, "cells")),
        found if matches!(found, Some(Format::Node | Format::Text)) || columns::is_of_points(data) => {
            let advice = "give the cells of these points, such as an .ele file, or create them with `septet triangulate`";
            return Err(source.unsupported(Place::Whole, "a table of points as cells", advice));
        }
        _ => {
            let (path, advice) = (path.to_owned(), format::advice(path));
            return Err(InputError::UnknownFormat { path, advice, known: Format::CELLS });
        }
    };
    match options.dimension {
        Some(dimension) if dimension != cells.dimension => {
            let what = format!("cells of dimension {} for points of dimension {dimension}", cells.dimension);
            Err(source.unsupported(Place::Whole, what, "give the cells that belong to the points"))
        }
        _ => Ok(cells),
    }
}
