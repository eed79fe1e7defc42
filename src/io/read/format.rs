//! The formats, and how one is recognised by name or content.

use std::path::Path;
use std::str::FromStr;

/// A file format of points, of cells, or of both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// TetGen and Triangle points.
    Node,
    /// Columns of numbers: `.xyz`, `.txt`, `.csv`.
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
    /// Gmsh 2.2 or 4.1 ASCII: points and cells.
    Msh,
    /// Medit ASCII `.mesh`: points and cells.
    Medit,
    /// TetGen and Triangle cells.
    Ele,
}

/// Format names and their file endings; the first ending is the name.
const ENDINGS: [(Format, &[&str]); 11] = [
    (Format::Node, &["node"]),
    (Format::Text, &["xyz", "txt", "csv"]),
    (Format::Npy, &["npy"]),
    (Format::Off, &["off"]),
    (Format::Ply, &["ply"]),
    (Format::Stl, &["stl"]),
    (Format::Obj, &["obj"]),
    (Format::Vtu, &["vtu"]),
    (Format::Msh, &["msh"]),
    (Format::Medit, &["mesh"]),
    (Format::Ele, &["ele"]),
];

impl Format {
    /// The formats `read` accepts, for messages.
    pub const POINTS: &'static str = "node xyz txt csv npy off ply stl obj vtu msh mesh, each also with .gz";
    /// The formats `read_cells` accepts, for messages.
    pub const CELLS: &'static str = "ele vtu msh mesh npy off, each also with .gz";

    /// The format's name: its usual file ending without the dot.
    pub fn name(self) -> &'static str {
        ENDINGS.iter().find(|(format, _)| *format == self).map_or("", |(_, endings)| endings[0])
    }

    /// The format a file's name tells, and whether it ends in `.gz`.
    pub(super) fn of_path(path: &Path) -> (Option<Format>, bool) {
        let name = path.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        let (stem, zipped) = match name.strip_suffix(".gz") {
            Some(stem) => (stem, true),
            None => (name.as_str(), false),
        };
        let ending = stem.rsplit_once('.').map(|(_, ending)| ending);
        (ending.and_then(|ending| ending.parse().ok()), zipped)
    }

    /// The format the first bytes tell beyond doubt.
    pub(super) fn of_content(data: &[u8]) -> Option<Format> {
        if data.starts_with(b"\x93NUMPY") {
            return Some(Format::Npy);
        }
        if data.starts_with(b"ply\n") || data.starts_with(b"ply\r") {
            return Some(Format::Ply);
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
            _ => None,
        }
    }
}

/// The name is not that of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a format; known: node xyz txt csv npy off ply stl obj vtu msh mesh ele")]
pub struct UnknownFormatName;

impl FromStr for Format {
    type Err = UnknownFormatName;

    /// From a file ending without its dot, in either case.
    fn from_str(name: &str) -> Result<Self, UnknownFormatName> {
        let name = name.to_ascii_lowercase();
        ENDINGS
            .iter()
            .find(|(_, endings)| endings.contains(&name.as_str()))
            .map(|(format, _)| *format)
            .ok_or(UnknownFormatName)
    }
}
