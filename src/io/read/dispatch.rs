//! Reads a file by the reader of its format.

use std::io::Read;
use std::path::Path;

use super::cells::{CellFile, CellOptions};
use super::collect::MOST_COORDINATES;
use super::error::{InputError, Place, WeightError};
use super::formats::{by_content, described, of_content, of_file, raw, read_by_name, reader};
use super::load::{self, Packing};
use super::points::{PointFile, ReadOptions, ReadProgress};
use super::text::Source;
use super::weights::check_format;
use super::{columns, signature, terrain, weight_file};
use crate::format::{Format, Role, may_be_table};

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
    let wanted = &*terrain::in_space(path, options)?;
    check_options(path, wanted)?;
    let file = points(path, &load::load(path, Packing::of_points(path, wanted), progress)?, wanted)?;
    weight_file::joined(terrain::lowered(file, options), options, progress)
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
    let wanted = &*terrain::in_space(name, options)?;
    check_options(name, wanted)?;
    let packing = Packing::of_points(name, wanted);
    let file = points(name, &load::load_from(reader, name, total, packing, progress)?, wanted)?;
    weight_file::joined(terrain::lowered(file, options), options, progress)
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

/// Reads the points of a file and their cells, from a format that has both, or from standard input if `path` is `-`.
/// The cells of a terrain are triangles.
///
/// The pieces of a `.pvtu` file must agree: every point and cell belongs to one piece, and its ghosts are equal in others.
/// Rows of their points are global ids.
///
/// # Errors
/// Returns [`InputError`] as [`read`] and [`read_cells`] do, if the format has points or cells only, or if a piece does not
/// agree with the others.
pub fn read_mesh(
    path: &Path,
    options: &ReadOptions,
    progress: &mut ReadProgress<'_>,
) -> Result<(PointFile, CellFile), InputError> {
    let wanted = &*terrain::in_space(path, options)?;
    check_options(path, wanted)?;
    let data = load::load(path, Packing::of(path), progress)?;
    let (points, cells) = whole_mesh(Source { path, data: &data }, wanted)?;
    let points = weight_file::joined(terrain::lowered(points, options), options, progress)?;
    Ok((points, cells))
}

/// Reads points and cells. The points of a terrain are in space.
fn whole_mesh(source: Source<'_>, options: &ReadOptions) -> Result<(PointFile, CellFile), InputError> {
    let format = options.format.or_else(|| of_file(source.path, source.data));
    match format.and_then(|format| Some((format, reader(format).mesh?))) {
        Some((format, _)) if options.columns.is_some() || options.keep_columns => {
            Err(InputError::NotATable { path: source.path.to_owned(), format: format.name() })
        }
        Some((format, read)) => {
            check_weights(source.path, format, options)?;
            read(source, options)
        }
        None if is_domain(source.path, source.data) => Err(a_domain(source, "points and cells")),
        None => {
            let what = format.map_or_else(|| "this file".to_owned(), described);
            let advice = "give the points and the cells: `septet verify POINTS CELLS`";
            Err(source.unsupported(Place::Whole, format!("{what} as points with their cells"), advice))
        }
    }
}

/// Checks the options for a file of points before it is read.
pub(super) fn check_options(path: &Path, options: &ReadOptions) -> Result<(), InputError> {
    if let (Some(_), Some(known)) = (options.raw, read_by_name(path)) {
        return Err(InputError::NotRaw { path: path.to_owned(), format: known.name() });
    }
    if options.terrain && options.weights.is_some() {
        return Err(WeightError::Terrain { path: path.to_owned() }.into());
    }
    if options.raw.is_some() && options.weight_column().is_some() {
        return Err(WeightError::NoColumns { path: path.to_owned(), format: "raw" }.into());
    }
    check_dimension(path, options.dimension)
}

/// Refuses a column of weights in a file of a format without columns to choose.
fn check_weights(path: &Path, format: Format, options: &ReadOptions) -> Result<(), InputError> {
    options.weight_column().map_or(Ok(()), |_| check_format(path, format))
}

fn check_dimension(path: &Path, dimension: Option<usize>) -> Result<(), InputError> {
    match dimension {
        None | Some(2..=MOST_COORDINATES) => Ok(()),
        Some(found) => {
            let (path, found) = (path.to_owned(), found as u64);
            Err(InputError::UnsupportedDimension { path, place: Place::Whole, found })
        }
    }
}

/// Returns the format of a file of points, given by its name, or by its content if the name does not determine it.
/// Standard input is a table unless its content identifies another format.
fn format_of_points(path: &Path, data: &[u8]) -> Option<Format> {
    let named = read_by_name(path);
    // The rows of a list of cells also form a table.
    let known = match named {
        Some(format) if format.row().is_table && signature::is_ele(data) => Some(Format::Ele),
        // A signature beats the name of a table.
        Some(format) if format.row().is_table => by_content(path, data).or(named),
        Some(Format::Node) if signature::is_ele_despite_name(data) => Some(Format::Ele),
        _ => named.or_else(|| of_content(data)),
    };
    let is_table = || path.as_os_str() == "-" || (may_be_table(path) && columns::is_table(data));
    known.or_else(|| is_table().then_some(Format::Xyz))
}

/// Returns the points in the bytes of a file. The points of a terrain are in space.
pub(super) fn points(path: &Path, data: &[u8], options: &ReadOptions) -> Result<PointFile, InputError> {
    let read = parsed_points(path, data, options);
    read.map_err(
        |error| if is_domain(path, data) { a_domain(Source { path, data }, "points") } else { error },
    )
}

/// Returns `true` if the name or the content is that of a `.poly` or `.smesh` file.
pub(super) fn is_domain(path: &Path, data: &[u8]) -> bool {
    let named = Format::of_path(path);
    named.is_some_and(|format| format.has(Role::Domain) && !format.has(Role::Points))
        || signature::is_poly(data)
}

/// Returns the error for a domain instead of points or cells.
pub(super) fn a_domain(source: Source<'_>, wanted: &str) -> InputError {
    source.unsupported(Place::Whole, format!("a domain (.poly) as {wanted}"), "mesh it with `septet mesh`")
}

/// Returns the error for a file whose format is unknown, or has not this use.
fn unknown(path: &Path, role: Role) -> InputError {
    InputError::UnknownFormat { path: path.to_owned(), advice: role.advice(path), role }
}

fn parsed_points(path: &Path, data: &[u8], options: &ReadOptions) -> Result<PointFile, InputError> {
    let source = Source { path, data };
    let chosen = options.columns.is_some() || options.keep_columns;
    let not_a_table = |format| InputError::NotATable { path: path.to_owned(), format };
    if let Some(rows) = options.raw {
        return if chosen { Err(not_a_table("raw")) } else { raw::read(source, rows, options) };
    }
    let Some(format) = options.format.or_else(|| format_of_points(path, data)) else {
        return Err(unknown(path, Role::Points));
    };
    if !format.row().is_table && chosen {
        return Err(not_a_table(format.name()));
    }
    check_weights(path, format, options)?;
    match reader(format).points {
        Some(read) => read(source, options),
        None => Err(without_role(source, format, Role::Points)),
    }
}

/// Returns the error for a file whose format does not have the role.
fn without_role(source: Source<'_>, format: Format, role: Role) -> InputError {
    let what = format!("{} as {}", described(format), role.content());
    let known = || format!("give one of {}", role.known());
    let advice = format.instead(role).map_or_else(known, str::to_owned);
    source.unsupported(Place::Whole, what, advice)
}

pub(super) fn cell_list(path: &Path, data: &[u8], options: &CellOptions) -> Result<CellFile, InputError> {
    let source = Source { path, data };
    let format = options.format.or_else(|| of_file(path, data));
    let cells = match format.and_then(|format| reader(format).cells) {
        Some(read) => read(source, options)?,
        None if is_domain(path, data) => return Err(a_domain(source, "cells")),
        None if format.is_some_and(|format| format == Format::Node || format.row().is_table)
            || columns::is_of_points(data) =>
        {
            let advice = "give the cells of these points, such as an .ele file, or create them with `septet triangulate`";
            return Err(source.unsupported(Place::Whole, "a table of points as cells", advice));
        }
        None => return Err(unknown(path, Role::Cells)),
    };
    match options.dimension {
        Some(dimension) if dimension != cells.dimension => {
            let what = format!("cells of dimension {} for points of dimension {dimension}", cells.dimension);
            Err(source.unsupported(Place::Whole, what, "give the cells that belong to the points"))
        }
        _ => Ok(cells),
    }
}
