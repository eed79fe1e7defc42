//! The writers of the formats. [`writer`] has an entry for each format of the table.

mod bdf;
mod exo;
mod inp;
mod medit;
mod msh;
mod msh_elements;
pub mod npy;
mod obj;
mod off;
mod ply;
pub mod poly_mesh;
pub mod pvtu;
mod stl;
mod su2;
mod surface;
mod svg;
mod table;
mod tetgen;
mod vtk;
pub mod vtu;
mod vtu_elements;
mod xdmf;

use std::io::Write;
use std::path::Path;

use septet_core::model::{MeshView, Points};

use super::cell_range::CellRange;
use super::error::{OutputError, WriteFault};
use super::options::{MshVersion, WriteOptions};
use super::place::Place;
use super::records::WriteProgress;
use super::row_table::RowTable;
use super::stage::Stage;
use crate::format::{Files, Format, Role};

/// Writes a triangulation as one file.
type WriteFile =
    fn(&mut dyn Write, &MeshView<'_>, &WriteOptions<'_>, &mut WriteProgress<'_>) -> Result<(), WriteFault>;
/// Writes a triangulation as a set of files.
type WriteSet = fn(
    &Path,
    &MeshView<'_>,
    &WriteOptions<'_>,
    &mut Stage,
    &mut WriteProgress<'_>,
) -> Result<(), OutputError>;
/// Writes a set of points.
pub type WritePoints =
    fn(&mut dyn Write, &Points, &WriteOptions<'_>, &mut WriteProgress<'_>) -> Result<(), WriteFault>;

/// How a format stores a triangulation.
#[derive(Clone, Copy)]
pub enum Body {
    /// In one file.
    One(WriteFile),
    /// In a set of files.
    Set(WriteSet),
    /// In a folder of files.
    Folder,
    /// In pieces, which are made from the shares of the workers.
    Pieces,
}

/// How several processes write a triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The first process gathers the triangulation and writes it.
    Whole,
    /// Each process writes a range of the sorted cells.
    Cells,
    /// Each process writes ranges of the points and of the sorted cells.
    Grid,
    /// Each process writes the pieces of its workers.
    Pieces,
}

/// The functions that write a format, one for each use.
#[derive(Clone, Copy)]
pub struct Writer {
    /// The writer of triangulations of points and of meshes of domains.
    pub mesh: Option<Body>,
    /// The number of records of a triangulation.
    pub records: fn(&MeshView<'_>) -> u64,
    /// The writer of points.
    pub points: Option<WritePoints>,
    /// The number of records for each point of a set of points.
    pub records_per_point: u64,
    pub way: Way,
    /// Whether the format holds points and cells of dimensions above 3.
    pub holds_any_dimension: bool,
}

/// A format that is not written.
const NONE: Writer = Writer {
    mesh: None,
    records: points_and_cells,
    points: None,
    records_per_point: 1,
    way: Way::Whole,
    holds_any_dimension: false,
};

/// Refuses a format that has no place for this dimension.
pub fn check_dimension(format: Format, path: &Path, dimension: usize) -> Result<(), OutputError> {
    if dimension > 3 && !writer(format).holds_any_dimension {
        let (path, format) = (path.to_owned(), format.name());
        return Err(OutputError::OnlySpace { path, format, dimension });
    }
    Ok(())
}

/// Returns the functions that write a format.
pub const fn writer(format: Format) -> Writer {
    match format {
        Format::Node => Writer {
            points: Some(|out, points, options, progress| {
                tetgen::write_points(out, points, options.first_id, progress)
            }),
            ..SET
        },
        Format::Ele | Format::Faces => SET,
        Format::Xyz => {
            Writer { points: Some(|out, p, _, progress| table::write(out, p, b' ', progress)), ..TABLE }
        }
        Format::Csv => {
            Writer { points: Some(|out, p, _, progress| table::write(out, p, b',', progress)), ..TABLE }
        }
        Format::Npy => NPY,
        Format::Off => OFF,
        Format::Ply => PLY,
        Format::Stl => STL,
        Format::Obj => OBJ,
        Format::Svg => SVG,
        Format::Vtu => VTU,
        Format::Pvtu => Writer { mesh: Some(Body::Pieces), records: grid_records, way: Way::Pieces, ..NONE },
        Format::Vtk => VTK,
        Format::Msh => {
            one(|out, mesh, options, progress| msh::write(out, mesh, (options.msh, options.order), progress))
        }
        Format::Msh22 => one(|out, mesh, options, progress| {
            msh::write(out, mesh, (MshVersion::V22, options.order), progress)
        }),
        Format::Msh41 => one(|out, mesh, options, progress| {
            msh::write(out, mesh, (MshVersion::V41, options.order), progress)
        }),
        Format::Medit => one(|out, mesh, _, progress| medit::write(out, mesh, progress)),
        Format::Xdmf => one(xdmf::write),
        Format::Inp => one(inp::write),
        Format::Su2 => one(|out, mesh, _, progress| su2::write(out, mesh, progress)),
        Format::Bdf => one(bdf::write),
        Format::Exo => one(exo::write),
        Format::PolyMesh => Writer { mesh: Some(Body::Folder), ..NONE },
        Format::Poly
        | Format::Smesh
        | Format::GeoJson
        | Format::Wkt
        | Format::Vtp
        | Format::Npz
        | Format::Las => NONE,
    }
}

/// Returns the functions of a format that holds meshes in one file, and no sets of points.
const fn one(write: WriteFile) -> Writer {
    Writer { mesh: Some(Body::One(write)), ..NONE }
}

/// Tables of points.
const TABLE: Writer = Writer { holds_any_dimension: true, ..NONE };

/// Geomview.
const OFF: Writer = Writer {
    points: Some(|out, points, _, progress| off::write_points(out, points, progress)),
    ..one(|out, mesh, _, progress| off::write(out, mesh, progress))
};

/// Stanford polygons.
const PLY: Writer = Writer {
    points: Some(|out, points, _, progress| ply::write(out, points, progress)),
    ..one(|out, mesh, _, progress| ply::write_surface(out, mesh, progress))
};

/// Stereolithography.
const STL: Writer = Writer {
    records: |mesh| mesh.cell_count() as u64,
    ..one(|out, mesh, _, progress| stl::write(out, mesh, progress))
};

/// Wavefront.
const OBJ: Writer = Writer {
    points: Some(|out, points, _, progress| table::write_obj(out, points, progress)),
    ..one(|out, mesh, _, progress| obj::write(out, mesh, progress))
};

/// Pictures.
const SVG: Writer =
    Writer { records: svg::records, ..one(|out, mesh, _, progress| svg::write(out, mesh, progress)) };

/// The arrays of `NumPy`.
const NPY: Writer = Writer {
    mesh: Some(Body::One(|out, mesh, options, progress| {
        let (cells, table) = (CellRange::whole(mesh), RowTable::of_options(options));
        Ok(npy::write_cells(&mut Place::stream(out), &cells, &table, progress)?)
    })),
    records: |mesh| mesh.cell_count() as u64,
    points: Some(|out, points, _, progress| npy::write_points(out, points, progress)),
    way: Way::Cells,
    holds_any_dimension: true,
    ..NONE
};

/// The grids of VTK in XML.
const VTU: Writer = Writer {
    mesh: Some(Body::One(vtu_elements::write)),
    records: grid_records,
    points: Some(|out, points, _, progress| vtu::write_points(out, points, progress)),
    records_per_point: 5,
    way: Way::Grid,
    ..NONE
};

/// The legacy grids of VTK.
const VTK: Writer = Writer {
    mesh: Some(Body::One(vtk::write)),
    records: grid_records,
    points: Some(|out, points, _, progress| vtk::write_points(out, points, progress)),
    records_per_point: 3,
    ..NONE
};

/// The set of `TetGen`.
const SET: Writer = Writer { mesh: Some(Body::Set(tetgen::write)), records: tetgen::records, ..NONE };

/// The table and the writers agree.
const _: () = {
    let mut at = 0;
    while at < Format::ALL.len() {
        let format = Format::ALL[at];
        let writer = writer(format);
        assert!(format.has(Role::Triangulation) == writer.mesh.is_some());
        assert!(format.has(Role::PointSet) == writer.points.is_some());
        assert!(matches!(
            (writer.mesh, format.row().files),
            (Some(Body::Set(_)), Files::Set)
                | (Some(Body::Pieces), Files::Pieces)
                | (Some(Body::Folder), Files::Folder)
                | (Some(Body::One(_)) | None, Files::One)
        ));
        assert!(format.row().is_divided(Role::Triangulation) != matches!(writer.way, Way::Whole));
        // A mesh of a domain has no pieces.
        assert!(
            !format.has(Role::Mesh)
                || matches!(writer.mesh, Some(Body::One(_) | Body::Set(_) | Body::Folder))
        );
        at += 1;
    }
};

fn points_and_cells(mesh: &MeshView<'_>) -> u64 {
    (mesh.point_count() + mesh.cell_count()) as u64
}

fn grid_records(mesh: &MeshView<'_>) -> u64 {
    vtu::records(mesh.point_count(), mesh.cell_count())
}
