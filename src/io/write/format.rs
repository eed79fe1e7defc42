//! Output formats, and how they follow from a file name.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::error::OutputError;
use super::names::{pieces_path, siblings};
use crate::ending::extension;
use crate::read::UnknownFormatName;

/// The version of a Gmsh file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MshVersion {
    /// 4.1, the default of current versions of Gmsh.
    #[default]
    V41,
    /// 2.2, which more programs read.
    V22,
}

/// A format of triangulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum OutputFormat {
    /// `.vtu`, an unstructured grid of VTK.
    Vtu,
    /// `.pvtu`, a parallel unstructured grid of VTK: one `.vtu` file for each worker, in the folder `NAME.pieces`.
    Pvtu,
    /// `.vtk`, an unstructured grid in a legacy file of VTK, binary.
    Vtk,
    /// `.node`, `.ele`, `.face`, `.edge` and `.neigh`, the set of `TetGen` and Triangle.
    TetGen,
    /// `.msh` of Gmsh. The version is given if the name determines it (`.msh22`, `.msh2`, `.msh41`).
    Msh(Option<MshVersion>),
    /// `.mesh` of Medit.
    Medit,
    /// `.npy`, the cells alone.
    Npy,
    /// `.off`, a surface.
    Off,
    /// `.stl`, a surface, as text.
    Stl,
}

/// The extensions of [`OutputFormat`] without dots.
const MESHES: &str = "vtu pvtu vtk node ele face edge neigh msh msh22 msh2 msh41 mesh npy off stl";

/// The extensions of [`PointFormat`] without dots.
const POINTS: &str = "node xyz txt csv npy off ply vtu vtk obj";

/// Extensions of formats that are not written, and the nearest format that is.
const NEAREST: [(&[&str], &str); 5] = [
    (&["vtp", "pvd", "xdmf", "xmf", "vti", "vtr", "vts", "ex2", "exo", "cgns"], "write .vtu for ParaView"),
    (&["npz", "h5", "hdf5", "parquet", "mat", "pkl"], "write .npy for NumPy"),
    (&["obj", "ply", "3mf", "gltf", "glb", "dae"], "write .stl or .off for a surface"),
    (&["bdf", "inp", "unv", "med", "cas"], "write .msh for meshio and Gmsh"),
    (&["dat", "asc", "pts", "tsv"], "write .xyz or .csv for text"),
];

impl OutputFormat {
    /// Returns the format for the extension of a path, in upper or lower case. A final `.gz` is ignored.
    ///
    /// # Errors
    /// Returns [`OutputError::UnknownFormat`] if the extension is missing or unknown.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        extension(path).parse().map_err(|_| unknown(path, MESHES))
    }

    /// Returns the files that this format writes under a path, without the faces of a mesh of a domain. A `.pvtu` file is
    /// followed by the folder of its pieces.
    pub fn files(self, path: &Path) -> Vec<PathBuf> {
        match self {
            Self::TetGen => siblings(path).collect(),
            Self::Pvtu => vec![path.to_owned(), pieces_path(path)],
            _ => vec![path.to_owned()],
        }
    }
}

impl FromStr for OutputFormat {
    type Err = UnknownFormatName;

    /// Parses an extension without its dot, in either case.
    fn from_str(name: &str) -> Result<Self, UnknownFormatName> {
        match name.to_ascii_lowercase().as_str() {
            "vtu" => Ok(Self::Vtu),
            "pvtu" => Ok(Self::Pvtu),
            "vtk" => Ok(Self::Vtk),
            "node" | "ele" | "face" | "edge" | "neigh" => Ok(Self::TetGen),
            "msh" => Ok(Self::Msh(None)),
            "msh22" | "msh2" => Ok(Self::Msh(Some(MshVersion::V22))),
            "msh41" => Ok(Self::Msh(Some(MshVersion::V41))),
            "mesh" => Ok(Self::Medit),
            "npy" => Ok(Self::Npy),
            "off" => Ok(Self::Off),
            "stl" => Ok(Self::Stl),
            _ => Err(UnknownFormatName { known: MESHES }),
        }
    }
}

/// A format of point sets. `Off`, `Ply`, `Vtu`, `Vtk` and `Obj` store three coordinates: points in the plane get z =
/// 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PointFormat {
    /// `.node` of `TetGen` and Triangle.
    Node,
    /// `.xyz` and `.txt`: one point per line, coordinates separated by spaces.
    Xyz,
    /// `.csv`: one point per line, coordinates separated by commas, without a header row.
    Csv,
    /// `.npy`: an array of doubles, one row per point.
    Npy,
    /// `.off` without faces.
    Off,
    /// `.ply`, binary, little-endian, doubles.
    Ply,
    /// `.vtu`, one vertex cell per point.
    Vtu,
    /// `.vtk`, binary, one vertex cell per point.
    Vtk,
    /// `.obj`, `v` lines only.
    Obj,
}

impl PointFormat {
    /// Returns the format for the extension of a path, in upper or lower case. A final `.gz` is ignored. For the path
    /// `-` (standard output), the format is [`PointFormat::Xyz`].
    ///
    /// # Errors
    /// Returns [`OutputError::UnknownFormat`] if the extension is missing or unknown.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        if path.as_os_str() == "-" {
            return Ok(Self::Xyz);
        }
        extension(path).parse().map_err(|_| unknown(path, POINTS))
    }
}

impl FromStr for PointFormat {
    type Err = UnknownFormatName;

    /// Parses an extension without its dot, in either case.
    fn from_str(name: &str) -> Result<Self, UnknownFormatName> {
        match name.to_ascii_lowercase().as_str() {
            "node" => Ok(Self::Node),
            "xyz" | "txt" => Ok(Self::Xyz),
            "csv" => Ok(Self::Csv),
            "npy" => Ok(Self::Npy),
            "off" => Ok(Self::Off),
            "ply" => Ok(Self::Ply),
            "vtu" => Ok(Self::Vtu),
            "vtk" => Ok(Self::Vtk),
            "obj" => Ok(Self::Obj),
            _ => Err(UnknownFormatName { known: POINTS }),
        }
    }
}

fn unknown(path: &Path, known: &str) -> OutputError {
    let extension = extension(path);
    let listed = known.split(' ').map(|name| format!(".{name}")).collect::<Vec<_>>().join(" ");
    let nearest = NEAREST.iter().find(|(others, _)| others.contains(&extension.as_str()));
    let advice = match nearest {
        _ if path.as_os_str() == "-" => "standard output needs --format".to_owned(),
        Some((_, advice)) => (*advice).to_owned(),
        None => crate::spelling::nearest(&extension, known.split(' ')).map_or_else(
            || "end the name in a known extension".to_owned(),
            |near| format!("the nearest is .{near}"),
        ),
    };
    OutputError::UnknownFormat { path: path.to_path_buf(), advice, known: listed }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_determine_formats() {
        let of = |name: &str| OutputFormat::of(Path::new(name)).unwrap();
        assert_eq!(of("a/b.VTU"), OutputFormat::Vtu);
        assert_eq!(of("a/b.vtk.GZ"), OutputFormat::Vtk);
        assert_eq!(of("b.1.neigh"), OutputFormat::TetGen);
        assert_eq!(of("b.msh"), OutputFormat::Msh(None));
        assert_eq!(of("b.msh2"), OutputFormat::Msh(Some(MshVersion::V22)));
        assert_eq!(of("b.msh22.gz"), OutputFormat::Msh(Some(MshVersion::V22)));
        assert_eq!(of("b.msh41"), OutputFormat::Msh(Some(MshVersion::V41)));
        assert_eq!(PointFormat::of(Path::new("-")).unwrap(), PointFormat::Xyz);
        assert_eq!(PointFormat::of(Path::new("p.txt.gz")).unwrap(), PointFormat::Xyz);
    }

    #[test]
    fn errors_list_the_known_extensions_and_the_nearest() {
        for name in ["mesh", ".vtu", "a.zip.gz", "a.", "-", "a.xyz", ".gz"] {
            let error = OutputFormat::of(Path::new(name)).unwrap_err();
            assert!(error.to_string().contains(".msh22"), "{error}");
        }
        for (name, advice) in [
            ("a.xdmf", "write .vtu for ParaView"),
            ("a.vut", "the nearest is .vtu"),
            ("a.npz", "write .npy"),
            ("a.dat", "write .xyz"),
            ("-", "--format"),
        ] {
            let error = OutputFormat::of(Path::new(name)).unwrap_err();
            assert!(error.to_string().contains(advice), "{error}");
        }
        assert!(PointFormat::of(Path::new("a.mesh")).is_err());
    }

    #[test]
    fn every_listed_extension_is_accepted() {
        for extension in MESHES.split(' ') {
            assert!(OutputFormat::of(Path::new(&format!("a.{extension}"))).is_ok());
        }
        for extension in POINTS.split(' ') {
            assert!(PointFormat::of(Path::new(&format!("a.{extension}.gz"))).is_ok());
        }
    }
}
