//! The table of file formats. Readers, writers, help texts, the guide, refusals and suggestions read it.
//!
//! To add a format, add its row here, its module to `read/formats` or `write/formats`, and its entry to the `mod.rs` there.

mod others;
mod role;
mod row;
#[cfg(test)]
mod tests;
mod uses;

use std::path::Path;
use std::str::FromStr;

pub use role::Role;
pub use row::{Files, Row};

use crate::ending::extension;
use row::{NONE, OF_PARAVIEW, OF_SOLVER};

/// Makes the enumeration of the formats and its table from the rows.
macro_rules! formats {
    ($($(#[doc = $doc:literal])* $name:ident { $($field:ident: $value:expr),* $(,)? })*) => {
        /// A file format. [`Role`] lists the uses that a format can have.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Format { $($(#[doc = $doc])* $name),* }

        impl Format {
            /// All formats, in the order of lists.
            pub const ALL: &'static [Format] = &[$(Format::$name),*];

            /// Returns the row of the table.
            pub const fn row(self) -> &'static Row {
                match self { $(Format::$name => const { &Row { $($field: $value,)* ..NONE } }),* }
            }
        }
    };
}

/// The advice for points that are to be read from cells or from a domain.
const NO_POINTS: &str =
    "give the .node file of its points, or check the cells with `septet verify POINTS CELLS`";

formats! {
    /// Points of `TetGen` and Triangle. A triangulation is written as the whole set.
    Node {
        extensions: &["node"],
        roles: &[
            (Role::Points, ""),
            (Role::Triangulation, "the set; ids from 0 or 1 as in the input"),
            (Role::Mesh, ""),
            (Role::PointSet, ""),
        ],
        files: Files::Set,
    }
    /// A text table of numbers, separated by blanks in outputs.
    Xyz {
        extensions: &["xyz", "txt"],
        ambiguous: &["dat", "pts", "asc", "data", "tsv", "xy"],
        roles: &[
            (Role::Points, ""),
            (Role::Sizes, ""),
            (Role::Weights, "one number a row, or a column"),
            (Role::WeightColumn, ""),
            (Role::PointSet, ""),
            (Role::RowList, ""),
        ],
        divided: &[Role::Points],
        is_table: true,
        instead: &[(Role::Triangulation, "write .npy for the cells alone, or .vtu"), (Role::Mesh, "write .npy for the cells alone, or .vtu")],
    }
    /// A text table of numbers, separated by commas in outputs.
    Csv {
        extensions: &["csv"],
        roles: &[
            (Role::Points, ""),
            (Role::Sizes, ""),
            (Role::Weights, "one number a row, or a column"),
            (Role::WeightColumn, ""),
            (Role::PointSet, ""),
            (Role::RowList, ""),
        ],
        divided: &[Role::Points],
        is_table: true,
        instead: &[(Role::Triangulation, "write .npy for the cells alone, or .vtu"), (Role::Mesh, "write .npy for the cells alone, or .vtu")],
    }
    /// A `NumPy` array.
    Npy {
        extensions: &["npy"],
        roles: &[
            (Role::Points, "numbers (n, 2) to (n, 6), or fields x, y, z"),
            (Role::Cells, "integer (m, 3) or (m, 4)"),
            (Role::Sizes, ""),
            (Role::Weights, "(n,) or (n, 1), or a column"),
            (Role::WeightColumn, ""),
            (Role::Triangulation, "cells, `<i8` (m, d+1), from 0"),
            (Role::Mesh, ""),
            (Role::PointSet, "`<f8` (n, d)"),
            (Role::RowList, ""),
            (Role::Offsets, "`<i1` or `<i4` (m, d+1, d)"),
        ],
        divided: &[Role::Points, Role::Triangulation],
        has_images: true,
        has_input_rows: true,
    }
    /// An archive of `NumPy` arrays.
    Npz {
        extensions: &["npz"],
        roles: &[(Role::Points, "its only array, or `points`"), (Role::WeightColumn, "")],
        instead: &[
            (Role::Weights, "save the array with numpy.save as .npy"),
            (Role::Cells, "save the cells with numpy.save as .npy"),
            (Role::Sizes, "save the array with numpy.save as .npy"),
            (Role::Triangulation, "write .npy for NumPy"),
            (Role::Mesh, "write .npy for NumPy"),
            (Role::PointSet, "write .npy for NumPy"),
        ],
    }
    /// Points of a laser scan, plain or compressed.
    Las {
        extensions: &["las", "laz"],
        roles: &[(Role::Points, "with scale and offset")],
        instead: &[
            (Role::Triangulation, "write .vtu or .ply"),
            (Role::Mesh, "write .vtu or .ply"),
            (Role::PointSet, "write .ply or .xyz for points"),
        ],
    }
    /// Geomview Object File Format.
    Off {
        extensions: &["off"],
        roles: &[
            (Role::Points, ""),
            (Role::Cells, "triangles"),
            (Role::Domain, ""),
            (Role::Triangulation, "2D: the triangles; 3D: the surface"),
            (Role::Mesh, ""),
            (Role::PointSet, ""),
        ],
        is_surface: true,
        labels: Some(["", "the surface, oriented outward", "", ""]),
    }
    /// Stanford polygons.
    Ply {
        extensions: &["ply"],
        roles: &[
            (Role::Points, "ASCII, binary"),
            (Role::Cells, "triangles"),
            (Role::Domain, ""),
            (Role::Triangulation, "binary; 2D: the triangles; 3D: the surface"),
            (Role::Mesh, ""),
            (Role::PointSet, "binary"),
        ],
        is_surface: true,
        labels: Some(["", "the surface, oriented outward", "", ""]),
    }
    /// Stereolithography facets.
    Stl {
        extensions: &["stl"],
        roles: &[
            (Role::Points, "ASCII, binary; equal corners are merged"),
            (Role::Domain, ""),
            (Role::Triangulation, "ASCII; 2D: the triangles; 3D: the surface"),
            (Role::Mesh, ""),
        ],
        is_surface: true,
        labels: Some(["", "the surface, oriented outward", "", ""]),
        instead: &[(Role::PointSet, "write .ply or .off")],
    }
    /// Wavefront object.
    Obj {
        extensions: &["obj"],
        roles: &[
            (Role::Points, ""),
            (Role::Cells, "triangles"),
            (Role::Domain, ""),
            (Role::Triangulation, "2D: the triangles; 3D: the surface"),
            (Role::Mesh, ""),
            (Role::PointSet, ""),
        ],
        is_surface: true,
        labels: Some(["", "the surface, oriented outward", "", ""]),
    }
    /// Scalable Vector Graphics: a picture of a triangulation in the plane.
    Svg {
        extensions: &["svg"],
        roles: &[(Role::Triangulation, "2D only: a picture"), (Role::Mesh, "2D only")],
        is_plane: true,
        labels: Some(["filled by region", "thicker lines", "", ""]),
        instead: &[
            (Role::Points, "give the file of points from which the picture was made"),
            (Role::Cells, "write .npy for the cells, or .vtu"),
            (Role::PointSet, "write .csv, and triangulate the points for a picture"),
        ],
    }
    /// VTK XML unstructured grid.
    Vtu {
        extensions: &["vtu"],
        roles: &[
            (Role::Points, "its points"),
            (Role::Cells, ""),
            (Role::Sizes, "`size` at its points"),
            (Role::Triangulation, "raw appended, radius-edge ratio of each cell"),
            (Role::Mesh, ""),
            (Role::PointSet, ""),
        ],
        divided: &[Role::Triangulation],
        has_data: true,
        has_images: true,
        labels: Some([
            "`region`, `attribute`, `radius_edge_ratio`, `least_angle`",
            "`marker`, `feature`, `inner_region`, `outer_region`",
            "`marker`, `feature`",
            "`size`, `marker`, `carrier_dimension`, `carrier`",
        ]),
        has_order_2: true,
    }
    /// VTK XML polygons.
    Vtp {
        extensions: &["vtp"],
        roles: &[(Role::Points, "its points"), (Role::Cells, "triangles")],
        instead: &[
            (Role::Triangulation, "write .vtu for ParaView"),
            (Role::Mesh, "write .vtu for ParaView"),
            (Role::PointSet, "write .vtu"),
        ],
    }
    /// VTK XML parallel unstructured grid: a `.vtu` file for each worker, in the folder `NAME.pieces`.
    Pvtu {
        extensions: &["pvtu"],
        roles: &[
            (Role::Cells, "those of its pieces, without ghosts"),
            (Role::Triangulation, "a piece for each worker, see [pieces](#pieces-of-workers)"),
        ],
        divided: &[Role::Triangulation],
        files: Files::Pieces,
        is_packable: false,
        has_data: true,
        has_input_rows: true,
        instead: &[
            (Role::Points, "it only lists its pieces; give one of the .vtu files that it names"),
            (Role::Mesh, "write .vtu: a mesh of a domain has no pieces"),
            (Role::PointSet, "write .vtu"),
        ],
    }
    /// Legacy VTK polygonal data or unstructured grid.
    Vtk {
        extensions: &["vtk"],
        roles: &[
            (Role::Points, "legacy; ASCII, binary"),
            (Role::Cells, ""),
            (Role::Triangulation, "binary 3.0"),
            (Role::Mesh, ""),
            (Role::PointSet, ""),
        ],
        has_data: true,
        has_images: true,
        labels: Some([
            "`region`, `attribute`, `radius_edge_ratio`, `least_angle`",
            "",
            "",
            "`size`, `marker`, `carrier_dimension`, `carrier`",
        ]),
        has_order_2: true,
    }
    /// Gmsh text, versions 2.2 and 4.1. An option decides the version of an output.
    Msh {
        extensions: &["msh"],
        roles: &[
            (Role::Points, "ASCII and binary, 2 and 4.1"),
            (Role::Cells, ""),
            (Role::Sizes, "`$NodeData`, ASCII"),
            (Role::Triangulation, "4.1 or 2.2"),
            (Role::Mesh, ""),
        ],
        labels: Some([
            "physical groups `region-N`",
            "physical groups `marker-N`",
            "physical groups `segment-N`",
            "",
        ]),
        has_order_2: true,
        instead: &[(Role::PointSet, "write .vtu or .ply")],
    }
    /// Gmsh text, version 2.2 in outputs.
    Msh22 {
        extensions: &["msh22", "msh2"],
        roles: &[(Role::Points, "as `.msh`"), (Role::Cells, ""), (Role::Sizes, "as `.msh`"), (Role::Triangulation, "2.2"), (Role::Mesh, "")],
        labels: Some(["as `.msh`", "as `.msh`", "as `.msh`", ""]),
        has_order_2: true,
        instead: &[(Role::PointSet, "write .vtu or .ply")],
    }
    /// Gmsh text, version 4.1 in outputs.
    Msh41 {
        extensions: &["msh41"],
        roles: &[(Role::Points, "as `.msh`"), (Role::Cells, ""), (Role::Sizes, "as `.msh`"), (Role::Triangulation, "4.1"), (Role::Mesh, "")],
        labels: Some(["as `.msh`", "as `.msh`", "as `.msh`", ""]),
        has_order_2: true,
        instead: &[(Role::PointSet, "write .vtu or .ply")],
    }
    /// Medit text.
    Medit {
        extensions: &["mesh"],
        roles: &[
            (Role::Points, "Medit, ASCII"),
            (Role::Cells, ""),
            (Role::Triangulation, "ASCII"),
            (Role::Mesh, ""),
        ],
        labels: Some(["name of the region, or number of the component", "marker", "marker", "marker"]),
        instead: &[(Role::PointSet, "write .vtu or .ply")],
    }
    /// XDMF with numbers inline.
    Xdmf {
        extensions: &["xdmf", "xmf"],
        roles: &[(Role::Triangulation, "numbers inline"), (Role::Mesh, "")],
        labels: Some(["`region`", "`marker`", "`marker`", "`size`"]),
        has_order_2: true,
        instead: OF_PARAVIEW,
    }
    /// An input file of Abaqus.
    Inp {
        extensions: &["inp"],
        roles: &[(Role::Triangulation, "Abaqus, `CalculiX`"), (Role::Mesh, "")],
        labels: Some([
            "element sets `region-N`",
            "surfaces of element faces and node sets `marker-N`",
            "node sets `segment-N`",
            "",
        ]),
        has_order_2: true,
        instead: OF_SOLVER,
    }
    /// A mesh of SU2.
    Su2 {
        extensions: &["su2"],
        roles: &[(Role::Triangulation, ""), (Role::Mesh, "")],
        labels: Some(["", "markers `marker-N`", "", ""]),
        instead: OF_SOLVER,
    }
    /// Bulk data of Nastran.
    Bdf {
        extensions: &["bdf", "nas"],
        roles: &[(Role::Triangulation, "Nastran, long fields"), (Role::Mesh, "")],
        labels: Some(["CTETRA (2D: CTRIA3), region as property", "CTRIA3 (2D: CROD), marker as property", "", ""]),
        has_order_2: true,
        instead: OF_SOLVER,
    }
    /// Exodus II in the classic format of netCDF.
    Exo {
        extensions: &["exo", "ex2", "e"],
        roles: &[(Role::Triangulation, "Exodus II, netCDF-3"), (Role::Mesh, "")],
        labels: Some(["element blocks `region-N`", "side sets `marker-N`", "node sets `segment-N`", ""]),
        has_order_2: true,
        instead: OF_PARAVIEW,
    }
    /// A folder of files of `OpenFOAM`.
    PolyMesh {
        extensions: &["polymesh"],
        roles: &[(Role::Triangulation, "3D only: a folder, such as `constant/polyMesh`"), (Role::Mesh, "3D only")],
        files: Files::Folder,
        is_packable: false,
        is_space: true,
        labels: Some(["zones `region-N`", "patches `marker-N`; inside: zones", "", ""]),
        instead: OF_PARAVIEW,
    }
    /// Cells of `TetGen` and Triangle. A triangulation is written as the whole set.
    Ele {
        extensions: &["ele"],
        roles: &[(Role::Cells, ""), (Role::Triangulation, "the set of `.node`"), (Role::Mesh, "")],
        files: Files::Set,
        labels: Some([
            "name of the region (attribute)",
            "`.face`: marker; 2D: `.edge`, all edges, marker",
            "`.edge`: marker",
            "size (attribute), marker",
        ]),
        instead: &[(Role::Points, NO_POINTS), (Role::Domain, "check the cells with `septet verify POINTS CELLS`")],
    }
    /// Faces, edges and neighbours of `TetGen` and Triangle. A triangulation is written as the whole set.
    Faces {
        extensions: &["face", "edge", "neigh"],
        roles: &[(Role::Triangulation, "the set of `.node`"), (Role::Mesh, "")],
        files: Files::Set,
        instead: &[(Role::Points, NO_POINTS), (Role::Cells, "give the .ele file of the set")],
    }
    /// A domain of `TetGen` or Triangle: points, facets with polygons, holes and regions.
    Poly {
        extensions: &["poly"],
        roles: &[(Role::Domain, "")],
        instead: &[(Role::Points, "mesh it with `septet mesh`"), (Role::Cells, "mesh it with `septet mesh`")],
    }
    /// A domain of `TetGen`: points and facets of one polygon.
    Smesh {
        extensions: &["smesh"],
        roles: &[(Role::Domain, "")],
        instead: &[(Role::Points, "mesh it with `septet mesh`"), (Role::Cells, "mesh it with `septet mesh`")],
    }
    /// Polygons, lines and points of a map (RFC 7946).
    GeoJson {
        extensions: &["geojson"],
        roles: &[(Role::Domain, "polygons and lines in the plane; features are regions")],
    }
    /// Polygons, lines and points in well-known text.
    Wkt {
        extensions: &["wkt"],
        roles: &[(Role::Domain, "polygons and lines in the plane; geometries are regions")],
    }
}

impl Format {
    /// Returns the name of the format: its usual extension without the dot.
    pub fn name(self) -> &'static str {
        self.row().extensions[0]
    }

    /// Whether the format has a use.
    pub const fn has(self, role: Role) -> bool {
        let roles = self.row().roles;
        let mut at = 0;
        while at < roles.len() {
            if roles[at].0 as u8 == role as u8 {
                return true;
            }
            at += 1;
        }
        false
    }

    /// Returns the format that the extension of a path determines. A final `.gz` is ignored.
    ///
    /// The folder of a mesh of `OpenFOAM` has the name `polyMesh`, alone or as an extension.
    pub fn of_path(path: &Path) -> Option<Format> {
        let is_folder = path.file_name().is_some_and(|name| name.eq_ignore_ascii_case("polyMesh"));
        if is_folder { Some(Format::PolyMesh) } else { extension(path).parse().ok() }
    }

    /// Returns the format of this name for a use.
    ///
    /// # Errors
    /// Returns [`UnknownFormatName`] if there is no such format, or if it does not have the use.
    pub fn named(name: &str, role: Role) -> Result<Format, UnknownFormatName> {
        let unknown = UnknownFormatName { known: role.names().join(" ") };
        name.parse().ok().filter(|format: &Format| format.has(role)).ok_or(unknown)
    }

    /// Whether a file has points together with their cells. A `.npy` file has one or the other.
    pub const fn holds_mesh(self) -> bool {
        matches!(self, Format::Pvtu)
            || self.has(Role::Points) && self.has(Role::Cells) && !matches!(self, Format::Npy)
    }

    /// Returns what to do instead of a use that the format does not have.
    pub fn instead(self, role: Role) -> Option<&'static str> {
        self.row().instead.iter().find(|(own, _)| *own == role).map(|(_, advice)| *advice)
    }
}

/// Whether the name of a file does not show whether the file is a table: its extension is ambiguous, such as `.dat`, or
/// missing.
pub(crate) fn may_be_table(path: &Path) -> bool {
    let extension = extension(path);
    extension.is_empty()
        || Format::ALL.iter().any(|format| format.row().ambiguous.contains(&extension.as_str()))
}

/// The error for an unknown format name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {known}")]
pub struct UnknownFormatName {
    /// The names of the formats, separated by spaces.
    pub known: String,
}

impl FromStr for Format {
    type Err = UnknownFormatName;

    /// Parses an extension without its dot, in either case.
    fn from_str(name: &str) -> Result<Self, UnknownFormatName> {
        let name = name.to_ascii_lowercase();
        let found = Format::ALL.iter().find(|format| format.row().extensions.contains(&name.as_str()));
        found.copied().ok_or_else(|| {
            let names = Format::ALL.iter().flat_map(|format| format.row().extensions).copied();
            UnknownFormatName { known: names.collect::<Vec<_>>().join(" ") }
        })
    }
}
