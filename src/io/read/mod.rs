//! Readers of point files and of cell files.
//!
//! Every reader takes the whole file as bytes, believes no count it has not checked against what is
//! there, and either returns what the file says or an [`InputError`] that names file, place and
//! remedy. Nothing is printed and nothing is dropped without a note.

mod cells;
mod collect;
mod columns;
mod domain;
mod error;
mod faces;
mod format;
mod load;
mod medit;
mod mesh;
mod msh;
mod node;
mod npy;
mod obj;
mod off;
mod ply;
mod points;
mod scalar;
mod signature;
mod sizes;
mod stl;
#[cfg(test)]
mod tests;
mod text;
mod vtu;

use std::io::Read;
use std::path::Path;

pub use cells::{CellFile, CellOptions};
pub use domain::{AnyInput, DOMAINS, DomainFile, read_domain};
pub use error::{InputError, Place};
pub use format::{Format, UnknownFormatName};
pub use points::{PointFile, Progress, ReadOptions};
pub use sizes::read_sizes;

use text::Source;

/// Reads points from a file, or from standard input if `path` is `-`. Meshes (`.vtu`, `.msh`,
/// `.mesh`) give their vertices.
///
/// # Errors
/// [`InputError`], if the file is missing, of unknown format, damaged, or holds invalid points and
/// `skip_invalid` is not set.
pub fn read(
    path: &Path,
    options: &ReadOptions,
    progress: &mut Progress<'_>,
) -> Result<PointFile, InputError> {
    check_dimension(path, options.dimension)?;
    let (_, zipped) = Format::of_path(path);
    points(path, &load::load(path, zipped, progress)?, options)
}

/// Reads points from any reader. `name` stands for the file in messages, and its ending tells the
/// format (and gzip) as in [`read`]; `total` is the size in bytes, where known.
///
/// # Errors
/// As for [`read`].
pub fn read_from<R: Read>(
    reader: R,
    name: &Path,
    total: Option<u64>,
    options: &ReadOptions,
    progress: &mut Progress<'_>,
) -> Result<PointFile, InputError> {
    check_dimension(name, options.dimension)?;
    let (_, zipped) = Format::of_path(name);
    points(name, &load::load_from(reader, name, total, zipped, progress)?, options)
}

/// Reads cells from a file, or from standard input if `path` is `-`.
///
/// # Errors
/// [`InputError`], if the file is missing, of unknown format, damaged, names points that do not
/// exist, or holds cells other than triangles and tetrahedra.
pub fn read_cells(
    path: &Path,
    options: &CellOptions,
    progress: &mut Progress<'_>,
) -> Result<CellFile, InputError> {
    check_dimension(path, options.dimension)?;
    let (_, zipped) = Format::of_path(path);
    cell_list(path, &load::load(path, zipped, progress)?, options)
}

/// Reads cells from any reader; `name` and `total` as in [`read_from`].
///
/// # Errors
/// As for [`read_cells`].
pub fn read_cells_from<R: Read>(
    reader: R,
    name: &Path,
    total: Option<u64>,
    options: &CellOptions,
    progress: &mut Progress<'_>,
) -> Result<CellFile, InputError> {
    check_dimension(name, options.dimension)?;
    let (_, zipped) = Format::of_path(name);
    cell_list(name, &load::load_from(reader, name, total, zipped, progress)?, options)
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

fn points(path: &Path, data: &[u8], options: &ReadOptions) -> Result<PointFile, InputError> {
    let source = Source { path, data };
    let known = options.format.or(Format::of_path(path).0).or_else(|| Format::of_content(data));
    // Standard input without any mark is columns of numbers.
    let piped = (path.as_os_str() == "-").then_some(Format::Text);
    match known.or(piped) {
        Some(Format::Node) => node::read(source, options),
        Some(Format::Text) => columns::read(source, options),
        Some(Format::Npy) => npy::read(source, options),
        Some(Format::Off) => off::read(source, options),
        Some(Format::Ply) => ply::read(source, options),
        Some(Format::Stl) => stl::read(source, options),
        Some(Format::Obj) => obj::read(source, options),
        Some(Format::Vtu) => vtu::parse(source, options)?.into_points(options),
        Some(Format::Msh) => msh::parse(source, options)?.into_points(options),
        Some(Format::Medit) => medit::parse(source, options)?.into_points(options),
        Some(Format::Ele) => {
            let what = "a file of cells (.ele) as points";
            Err(source.unsupported(Place::Whole, what, "give the .node file that belongs to it"))
        }
        None => Err(InputError::UnknownFormat { path: path.to_owned(), known: Format::POINTS }),
    }
}

fn cell_list(path: &Path, data: &[u8], options: &CellOptions) -> Result<CellFile, InputError> {
    let source = Source { path, data };
    let plain = ReadOptions::default();
    let cells = match options.format.or(Format::of_path(path).0).or_else(|| Format::of_content(data)) {
        Some(Format::Ele) => cells::read_ele(source, options)?,
        Some(Format::Npy) => npy::read_cells(source, options)?,
        Some(Format::Off) => off::read_cells(source)?,
        Some(Format::Vtu) => vtu::parse(source, &plain)?.into_cells(options)?,
        Some(Format::Msh) => msh::parse(source, &plain)?.into_cells(options)?,
        Some(Format::Medit) => medit::parse(source, &plain)?.into_cells(options)?,
        Some(Format::Node) => {
            let what = "a file of points (.node) as cells";
            return Err(source.unsupported(Place::Whole, what, "give the .ele file that belongs to it"));
        }
        _ => {
            return Err(InputError::UnknownFormat { path: path.to_owned(), known: Format::CELLS });
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
