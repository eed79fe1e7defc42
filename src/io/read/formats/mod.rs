//! The readers of the formats. [`reader`] has an entry for each format of the table.

pub mod geojson;
mod las;
mod medit;
mod msh;
mod node;
pub mod npy;
mod npz;
mod obj;
mod off;
mod ply;
pub mod raw;
mod stl;
mod vtk;
mod vtu;
pub mod wkt;

use std::path::Path;

use super::cells::{self, CellFile, CellOptions};
use super::domain::{DomainFile, poly, surface};
use super::error::{InputError, Place};
use super::faces::{self, FileFaces};
use super::points::{PointFile, ReadOptions, ReadProgress};
use super::text::Source;
use super::weight_rows::{self, WeightRows};
use super::{columns, signature, size_rows};
use crate::format::{Format, Role};
use septet_core::mesh::field::SizeField;

/// Reads points.
type ReadPoints = fn(Source<'_>, &ReadOptions) -> Result<PointFile, InputError>;

/// Reads cells.
type ReadCells = fn(Source<'_>, &CellOptions) -> Result<CellFile, InputError>;

/// Reads points together with their cells.
type ReadMesh = fn(Source<'_>, &ReadOptions) -> Result<(PointFile, CellFile), InputError>;

/// Reads weights, one number a row.
type ReadWeights = fn(Source<'_>, &mut WeightRows<'_>) -> Result<(), InputError>;

/// Reads a domain.
type ReadDomain = fn(Source<'_>, &mut ReadProgress<'_>) -> Result<DomainFile, InputError>;

/// The functions that read a format, one for each use.
#[derive(Clone, Copy)]
pub struct Reader {
    /// Whether the bytes of a file have the format, whatever its name is.
    signature: fn(&[u8]) -> bool,
    pub points: Option<ReadPoints>,
    pub cells: Option<ReadCells>,
    pub domain: Option<ReadDomain>,
    /// Reads points together with their cells.
    pub mesh: Option<ReadMesh>,
    pub sizes: Option<fn(Source<'_>) -> Result<SizeField, InputError>>,
    pub weights: Option<ReadWeights>,
    /// The rows of points that several processes divide.
    pub rows: Option<Rows>,
}

/// The way to find rows of points in a file without reading the whole file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Each row has the same number of bytes.
    Array,
    /// Each row is a line.
    Lines,
}

/// A format that is not read.
const NONE: Reader = Reader {
    signature: |_| false,
    points: None,
    cells: None,
    domain: None,
    mesh: None,
    sizes: None,
    weights: None,
    rows: None,
};

/// A format of points and cells, read by `parse` of its module.
macro_rules! mesh {
    ($module:ident, $signature:expr) => {
        Reader {
            signature: $signature,
            points: Some(|source, options| $module::parse(source, options)?.into_points(options)),
            cells: Some(|source, options| {
                $module::parse(source, &ReadOptions::default())?.into_cells(options)
            }),
            mesh: Some(|source, options| {
                let points = $module::parse(source, options)?.into_points(options)?;
                let chosen = of_points(&points, options);
                Ok((points, $module::parse(source, &ReadOptions::default())?.into_cells(&chosen)?))
            }),
            ..NONE
        }
    };
}

/// A format of points and of surfaces, which are domains, or cells if they consist of triangles. The corners of faces are
/// numbered from `$first`, and `$place` locates a face.
macro_rules! surface {
    ($module:ident, $first:expr, $place:expr, $signature:expr) => {
        Reader {
            signature: $signature,
            points: Some($module::read),
            cells: Some(|source, options| {
                let points = || $module::read(source, &ReadOptions::default());
                let faces = $module::read_faces(source)?;
                faces::triangles(&FileFaces { source, faces, first: $first, place: $place }, options, points)
            }),
            mesh: Some(|source, options| {
                let points = $module::read(source, options)?;
                let whole = || $module::read(source, &ReadOptions::default());
                let faces = $module::read_faces(source)?;
                let surface = FileFaces { source, faces, first: $first, place: $place };
                Ok((points, faces::triangles(&surface, &CellOptions::default(), whole)?))
            }),
            domain: Some(|source, _| {
                let file = $module::read(source, &ReadOptions::default())?;
                surface::of(source, file, $module::read_faces(source)?, $first)
            }),
            ..NONE
        }
    };
}

/// Returns the functions that read a format.
pub const fn reader(format: Format) -> Reader {
    match format {
        Format::Node => Reader { signature: is_node, points: Some(node::read), ..NONE },
        Format::Xyz | Format::Csv => Reader {
            points: Some(columns::read),
            sizes: Some(size_rows::read),
            weights: Some(weight_rows::read_text),
            rows: Some(Rows::Lines),
            ..NONE
        },
        Format::Npy => NPY,
        Format::Npz => {
            Reader { signature: |data| data.starts_with(b"PK\x03\x04"), points: Some(npz::read), ..NONE }
        }
        Format::Las => {
            Reader { signature: |data| data.starts_with(b"LASF"), points: Some(las::read), ..NONE }
        }
        Format::Off => Reader {
            cells: Some(|source, _| off::read_cells(source)),
            mesh: Some(|source, options| Ok((off::read(source, options)?, off::read_cells(source)?))),
            ..surface!(off, 0, |_, _| Place::Whole, |data| signature::is_off(word(data)))
        },
        Format::Ply => surface!(ply, 0, |_, _| Place::Whole, is_ply),
        Format::Stl => STL,
        Format::Obj => surface!(obj, 1, obj::place_of_face, |_| false),
        Format::Vtu => Reader {
            sizes: Some(vtu::read_sizes),
            ..mesh!(vtu, |data| vtu::is_of_type(data, |kind| kind != "PolyData"))
        },
        Format::Vtp => mesh!(vtu, |data| vtu::is_of_type(data, |kind| kind == "PolyData")),
        Format::Vtk => mesh!(vtk, |data| data.starts_with(b"# vtk DataFile")),
        Format::Msh => {
            Reader { sizes: Some(msh::read_sizes), ..mesh!(msh, |data| word(data) == b"$MeshFormat") }
        }
        // Their content is that of a `.msh` file.
        Format::Msh22 | Format::Msh41 => Reader { sizes: Some(msh::read_sizes), ..mesh!(msh, |_| false) },
        Format::Medit => mesh!(medit, |data| word(data) == b"MeshVersionFormatted"),
        Format::Ele => Reader { signature: is_ele, cells: Some(cells::read_ele), ..NONE },
        Format::Poly => Reader { domain: Some(poly::read_polygons), ..NONE },
        Format::Smesh => Reader { domain: Some(poly::read_simple), ..NONE },
        Format::GeoJson => Reader { signature: is_geojson, domain: Some(geojson::read_domain), ..NONE },
        Format::Wkt => Reader { signature: is_wkt, domain: Some(wkt::read_domain), ..NONE },
        Format::Pvtu => Reader { cells: Some(vtu::read_cells_of_pieces), mesh: Some(vtu::read_both), ..NONE },
        Format::Faces
        | Format::Svg
        | Format::Xdmf
        | Format::Inp
        | Format::Su2
        | Format::Bdf
        | Format::Exo
        | Format::PolyMesh => NONE,
    }
}

/// The arrays of `NumPy`.
const NPY: Reader = Reader {
    signature: |data| data.starts_with(b"\x93NUMPY"),
    points: Some(npy::read),
    cells: Some(npy::read_cells),
    sizes: Some(npy::read_sizes),
    weights: Some(npy::read_weights),
    rows: Some(Rows::Array),
    ..NONE
};

/// Facets, whose solids are kept.
const STL: Reader = Reader {
    signature: |data| signature::is_binary(data) || word(data) == b"solid",
    points: Some(stl::read),
    domain: Some(|source, _| {
        let (file, faces, solids) = stl::read_faces(source, &ReadOptions::default())?;
        Ok(surface::with_solids(surface::of(source, file, faces, 0)?, solids))
    }),
    ..NONE
};

fn is_node(data: &[u8]) -> bool {
    signature::is_node(text(data))
}

fn is_geojson(data: &[u8]) -> bool {
    geojson::is_geojson(text(data))
}

fn is_wkt(data: &[u8]) -> bool {
    wkt::is_wkt(text(data))
}

fn is_ply(data: &[u8]) -> bool {
    data.starts_with(b"ply\n") || data.starts_with(b"ply\r")
}

fn is_ele(data: &[u8]) -> bool {
    signature::is_ele(text(data))
}

/// Returns the options to read the cells of the file with these points.
fn of_points(file: &PointFile, options: &ReadOptions) -> CellOptions {
    let is_plane = options.terrain || file.points.dimension() == 2;
    CellOptions { dimension: is_plane.then_some(2), ..CellOptions::default() }
}

/// The table and the readers agree.
const _: () = {
    let mut at = 0;
    while at < Format::ALL.len() {
        let format = Format::ALL[at];
        let reader = reader(format);
        assert!(format.has(Role::Points) == reader.points.is_some());
        assert!(format.has(Role::Cells) == reader.cells.is_some());
        assert!(format.has(Role::Domain) == reader.domain.is_some());
        assert!(format.holds_mesh() == reader.mesh.is_some());
        assert!(format.has(Role::Sizes) == reader.sizes.is_some());
        assert!(format.has(Role::Weights) == reader.weights.is_some());
        assert!(format.row().is_divided(Role::Points) == reader.rows.is_some());
        at += 1;
    }
};

/// Returns the format that the first bytes or lines identify.
pub fn of_content(data: &[u8]) -> Option<Format> {
    Format::ALL.iter().copied().find(|format| (reader(*format).signature)(data))
}

/// Returns the format that the first bytes or lines of a file show, although its name is that of a table of points.
pub fn by_content(path: &Path, data: &[u8]) -> Option<Format> {
    let named = read_by_name(path)?;
    of_content(data)
        .filter(|content| named.row().is_table && !content.row().is_table && *content != Format::Ele)
}

/// Returns the format of a file that is read, given by its name, or by its content if the name does not determine it.
pub fn of_file(path: &Path, data: &[u8]) -> Option<Format> {
    read_by_name(path).or_else(|| of_content(data))
}

/// Returns the format given by the name of a file of points or cells.
pub fn read_by_name(path: &Path) -> Option<Format> {
    Format::of_path(path).filter(|format| format.has(Role::Points) || format.has(Role::Cells))
}

/// Describes a file of a format in messages.
pub fn described(format: Format) -> String {
    match format {
        Format::Ele => "a list of cells (.ele)".to_owned(),
        other => format!("a .{} file", other.name()),
    }
}

/// Returns the text without a byte order mark and blanks at its beginning.
fn text(data: &[u8]) -> &[u8] {
    data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(data).trim_ascii_start()
}

/// Returns the first word of a text.
fn word(data: &[u8]) -> &[u8] {
    text(data).split(u8::is_ascii_whitespace).next().unwrap_or_default()
}
