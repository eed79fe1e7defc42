//! Which format a file name stands for.

use std::path::Path;

use super::error::OutputError;

/// The version of a Gmsh file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MshVersion {
    /// 4.1, what Gmsh writes today.
    #[default]
    V41,
    /// 2.2, what most other programs read.
    V22,
}

/// A format for triangulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OutputFormat {
    /// `.vtu`, an unstructured grid of VTK.
    Vtu,
    /// `.node`, `.ele`, `.face`, `.edge` and `.neigh`, the set of `TetGen` and Triangle.
    TetGen,
    /// `.msh` of Gmsh; the version where the name fixes it (`.msh22`, `.msh2`, `.msh41`).
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

/// The extensions of [`OutputFormat`], for messages.
const MESH_EXTENSIONS: &str =
    ".vtu .node .ele .face .edge .neigh .msh .msh22 .msh2 .msh41 .mesh .npy .off .stl";

/// The extensions of [`PointFormat`], for messages.
const POINT_EXTENSIONS: &str = ".node .xyz .txt .csv .npy .off .ply .vtu .obj";

impl OutputFormat {
    /// The format named by the extension of a path, in either case.
    ///
    /// # Errors
    /// [`OutputError::UnknownFormat`] where the extension is missing or unknown.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        match extension(path).as_str() {
            "vtu" => Ok(Self::Vtu),
            "node" | "ele" | "face" | "edge" | "neigh" => Ok(Self::TetGen),
            "msh" => Ok(Self::Msh(None)),
            "msh22" | "msh2" => Ok(Self::Msh(Some(MshVersion::V22))),
            "msh41" => Ok(Self::Msh(Some(MshVersion::V41))),
            "mesh" => Ok(Self::Medit),
            "npy" => Ok(Self::Npy),
            "off" => Ok(Self::Off),
            "stl" => Ok(Self::Stl),
            _ => Err(unknown(path, MESH_EXTENSIONS)),
        }
    }
}

/// A format for point sets. Those that know only space (`Off`, `Ply`, `Vtu`, `Obj`) get z = 0 for
/// points of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PointFormat {
    /// `.node` of `TetGen` and Triangle.
    Node,
    /// `.xyz` and `.txt`: one point per line, coordinates separated by blanks.
    Xyz,
    /// `.csv`: one point per line, coordinates separated by commas, no heading.
    Csv,
    /// `.npy`: an array of doubles, one row per point.
    Npy,
    /// `.off` without faces.
    Off,
    /// `.ply`, binary, little endian, doubles.
    Ply,
    /// `.vtu`, one vertex cell per point.
    Vtu,
    /// `.obj`, `v` lines only.
    Obj,
}

impl PointFormat {
    /// The format named by the extension of a path, in either case. The path `-` (standard output)
    /// stands for [`PointFormat::Xyz`].
    ///
    /// # Errors
    /// [`OutputError::UnknownFormat`] where the extension is missing or unknown.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        if path.as_os_str() == "-" {
            return Ok(Self::Xyz);
        }
        match extension(path).as_str() {
            "node" => Ok(Self::Node),
            "xyz" | "txt" => Ok(Self::Xyz),
            "csv" => Ok(Self::Csv),
            "npy" => Ok(Self::Npy),
            "off" => Ok(Self::Off),
            "ply" => Ok(Self::Ply),
            "vtu" => Ok(Self::Vtu),
            "obj" => Ok(Self::Obj),
            _ => Err(unknown(path, POINT_EXTENSIONS)),
        }
    }
}

/// The extension in lower case, empty where there is none.
fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.unwrap_or_default().to_ascii_lowercase()
}

fn unknown(path: &Path, known: &str) -> OutputError {
    OutputError::UnknownFormat { path: path.to_path_buf(), known: known.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_choose_formats() {
        let of = |name: &str| OutputFormat::of(Path::new(name)).unwrap();
        assert_eq!(of("a/b.VTU"), OutputFormat::Vtu);
        assert_eq!(of("b.1.neigh"), OutputFormat::TetGen);
        assert_eq!(of("b.msh"), OutputFormat::Msh(None));
        assert_eq!(of("b.msh2"), OutputFormat::Msh(Some(MshVersion::V22)));
        assert_eq!(of("b.msh22"), OutputFormat::Msh(Some(MshVersion::V22)));
        assert_eq!(of("b.msh41"), OutputFormat::Msh(Some(MshVersion::V41)));
        assert_eq!(PointFormat::of(Path::new("-")).unwrap(), PointFormat::Xyz);
        assert_eq!(PointFormat::of(Path::new("p.txt")).unwrap(), PointFormat::Xyz);
    }

    #[test]
    fn unknown_extensions_name_the_known_ones() {
        for name in ["mesh", ".vtu", "a.vtu.gz", "a.", "-", "a.xyz"] {
            let error = OutputFormat::of(Path::new(name)).unwrap_err();
            assert!(error.to_string().contains(".msh22"), "{error}");
        }
        assert!(PointFormat::of(Path::new("a.mesh")).is_err());
    }

    #[test]
    fn every_advertised_extension_is_accepted() {
        for extension in MESH_EXTENSIONS.split(' ') {
            assert!(OutputFormat::of(Path::new(&format!("a{extension}"))).is_ok());
        }
        for extension in POINT_EXTENSIONS.split(' ') {
            assert!(PointFormat::of(Path::new(&format!("a{extension}"))).is_ok());
        }
    }
}
