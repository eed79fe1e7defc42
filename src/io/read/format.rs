//! Input formats, and how they are detected from the name or content of a file.

use std::path::Path;
use std::str::FromStr;

use super::raw_rows::RawRows;
use crate::ending::extension;

/// An input format of points, of cells, or of both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Points of `TetGen` and Triangle.
    Node,
    /// A text table of numbers: `.xyz`, `.txt`, `.csv`.
    Text,
    /// A `NumPy` array.
    Npy,
    /// Geomview Object File Format.
    Off,
    /// Stanford polygons.
    Ply,
    /// Stereolithography facets.
    Stl,
    /// Wavefront object.
    Obj,
    /// VTK XML unstructured grid: points and cells.
    Vtu,
    /// Legacy VTK polygonal data or unstructured grid: points and cells.
    Vtk,
    /// Gmsh 2.2 or 4.1 ASCII: points and cells.
    Msh,
    /// Medit ASCII `.mesh`: points and cells.
    Medit,
    /// Cells of `TetGen` and Triangle.
    Ele,
    /// Coordinates in binary without a header. Neither a name nor a content has this format, so that it is always stated.
    Raw(RawRows),
}

/// Formats and their file name extensions. The first extension is the name of the format.
const EXTENSIONS: [(Format, &[&str]); 12] = [
    (Format::Node, &["node"]),
    (Format::Text, &["xyz", "txt", "csv"]),
    (Format::Npy, &["npy"]),
    (Format::Off, &["off"]),
    (Format::Ply, &["ply"]),
    (Format::Stl, &["stl"]),
    (Format::Obj, &["obj"]),
    (Format::Vtu, &["vtu"]),
    (Format::Vtk, &["vtk"]),
    (Format::Msh, &["msh"]),
    (Format::Medit, &["mesh"]),
    (Format::Ele, &["ele"]),
];

/// Extensions of formats that are not read, and the nearest format that is.
const CONVERSIONS: [(&[&str], &str); 5] = [
    (
        &["vtp", "vti", "vtr", "vts", "pvd", "xdmf", "xmf", "ex2", "exo"],
        "write .vtu with ParaView or meshio, or ",
    ),
    (&["las", "laz", "pcd", "e57"], "convert the point cloud to .ply, or "),
    (
        &["npz", "h5", "hdf5", "parquet", "feather", "mat", "fits", "pkl"],
        "save the array with numpy.save as .npy, or ",
    ),
    (&["xls", "xlsx", "ods"], "export the sheet as .csv, or "),
    (&["poly", "smesh"], "give a domain to `septet mesh`, or "),
];

impl Format {
    /// The formats that `read` accepts, for messages.
    pub const POINTS: &'static str = ".node .xyz .txt .csv .npy .off .ply .stl .obj .vtu .vtk .msh .mesh (each also with .gz), or state the format with \
         --input-format or --raw";
    /// The formats that `read_cells` accepts, for messages.
    pub const CELLS: &'static str = ".ele .vtu .vtk .msh .mesh .npy .off (each also with .gz)";
    /// The names of all formats.
    const NAMES: &'static str = "node xyz txt csv npy off ply stl obj vtu vtk msh mesh ele";

    /// Returns the name of the format: its usual extension without the dot.
    pub fn name(self) -> &'static str {
        EXTENSIONS.iter().find(|(format, _)| *format == self).map_or("raw", |(_, extensions)| extensions[0])
    }

    /// Returns the format given by the extension of a file name.
    pub(super) fn of_path(path: &Path) -> Option<Format> {
        extension(path).parse().ok()
    }

    /// Returns the format that the first bytes or lines identify.
    pub(super) fn of_content(data: &[u8]) -> Option<Format> {
        if data.starts_with(b"\x93NUMPY") {
            return Some(Format::Npy);
        }
        if data.starts_with(b"ply\n") || data.starts_with(b"ply\r") {
            return Some(Format::Ply);
        }
        if data.starts_with(b"# vtk DataFile") {
            return Some(Format::Vtk);
        }
        if super::signature::is_binary(data) {
            return Some(Format::Stl);
        }
        let data = data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(data).trim_ascii_start();
        let word = data.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        match word {
            b"solid" => Some(Format::Stl),
            b"$MeshFormat" => Some(Format::Msh),
            b"MeshVersionFormatted" => Some(Format::Medit),
            _ if super::signature::is_keyword(word) => Some(Format::Off),
            _ if word.starts_with(b"<?xml") || word.starts_with(b"<VTKFile") => Some(Format::Vtu),
            _ if super::signature::is_ele(data) => Some(Format::Ele),
            _ => super::signature::is_node(data).then_some(Format::Node),
        }
    }
}

/// Returns advice for a file of unknown format: how to convert it, or the extension with the nearest spelling.
pub(super) fn advice(path: &Path) -> String {
    let extension = extension(path);
    let conversion = CONVERSIONS.iter().find(|(extensions, _)| extensions.contains(&extension.as_str()));
    if let Some((_, advice)) = conversion {
        return (*advice).to_owned();
    }
    let known = EXTENSIONS.iter().flat_map(|(_, extensions)| extensions.iter().copied());
    crate::spelling::nearest(&extension, known)
        .map_or_else(String::new, |near| format!("rename it if it is a .{near} file, or "))
}

/// The error for an unknown format name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {known}")]
pub struct UnknownFormatName {
    /// The names of the formats, separated by spaces.
    pub known: &'static str,
}

impl FromStr for Format {
    type Err = UnknownFormatName;

    /// Parses an extension without its dot, in either case.
    fn from_str(name: &str) -> Result<Self, UnknownFormatName> {
        let name = name.to_ascii_lowercase();
        EXTENSIONS
            .iter()
            .find(|(_, extensions)| extensions.contains(&name.as_str()))
            .map(|(format, _)| *format)
            .ok_or(UnknownFormatName { known: Format::NAMES })
    }
}
