//! The options of the writers.

use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::names::{pieces_path, siblings};
use crate::format::{Files, Format, Role};
use crate::read::Column;

/// The version of a Gmsh file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MshVersion {
    /// 4.1, the default of current versions of Gmsh.
    #[default]
    V41,
    /// 2.2, which more programs read.
    V22,
}

septet_core::words!(MshVersion {
    V22 "2.2" "Legacy Gmsh files",
    V41 "4.1" "Current Gmsh files",
});

/// The order of the elements in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// Linear: corners only.
    #[default]
    One,
    /// Quadratic and straight: corners, and the midpoints of edges.
    Two,
}

septet_core::words!(Order {
    One "1" "Linear cells, such as tetrahedra of 4 nodes",
    Two "2" "Quadratic cells with straight edges, such as tetrahedra of 10 nodes",
});

/// The options of the writers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WriteOptions<'a> {
    /// The format. By default, the file name extension determines it.
    pub format: Option<Format>,
    /// Whether to write the owner and the owning leaf of each cell, if the mesh contains them (`.vtu` and `.vtk`
    /// only).
    pub with_owner: bool,
    /// The id of the first point and of the first cell in the files of `TetGen`: 0 or 1, as in the `.node` file of the
    /// points.
    pub first_id: u64,
    /// The version of a `.msh` file whose extension does not determine it.
    pub msh: MshVersion,
    /// The order of the elements. Formats without [`has_order_2`](crate::Row::has_order_2) hold linear ones only.
    pub order: Order,
    /// Values at the points of a triangulation, one column per array (`.vtu` and `.vtk` only).
    pub point_data: &'a [Column],
    /// The zero-based row of the input of each point, ascending, if rows were dropped. Formats of
    /// [`has_input_rows`](crate::Row::has_input_rows) number points by them.
    pub source: Option<&'a [u64]>,
}

impl WriteOptions<'_> {
    /// Returns the format in which a triangulation is written to this path.
    ///
    /// # Errors
    /// Returns [`OutputError::UnknownFormat`] if neither the options nor the extension determine it.
    pub fn format_of(&self, path: &Path) -> Result<Format, OutputError> {
        self.of(path, Role::Triangulation)
    }

    /// Returns the format in which a point set is written to this path. For the path `-` (standard output), the format is
    /// [`Format::Xyz`] unless the options state another.
    ///
    /// # Errors
    /// Returns [`OutputError::UnknownFormat`] if neither the options nor the extension determine it.
    pub fn point_format_of(&self, path: &Path) -> Result<Format, OutputError> {
        if path.as_os_str() == "-" && self.format.is_none() {
            return Ok(Format::Xyz);
        }
        self.of(path, Role::PointSet)
    }

    fn of(&self, path: &Path, role: Role) -> Result<Format, OutputError> {
        let format = self.format.or_else(|| Format::of_path(path)).filter(|format| format.has(role));
        format.ok_or_else(|| OutputError::unknown(path, role))
    }
}

impl Format {
    /// Returns the files that an output of this format consists of, as paths. A `.pvtu` file
    /// is followed by the folder of its pieces.
    pub fn files(self, path: &Path) -> Vec<PathBuf> {
        match self.row().files {
            Files::One | Files::Folder => vec![path.to_owned()],
            Files::Set => siblings(path).collect(),
            Files::Pieces => vec![path.to_owned(), pieces_path(path)],
        }
    }
}

pub(super) fn check_first_id(first_id: u64) -> Result<(), OutputError> {
    if first_id > 1 {
        return Err(OutputError::FirstId { first_id });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str) -> Format {
        WriteOptions::default().format_of(Path::new(name)).unwrap()
    }

    #[test]
    fn extensions_determine_formats() {
        for (name, format) in [
            ("a/b.VTU", Format::Vtu),
            ("a/b.vtk.GZ", Format::Vtk),
            ("b.1.neigh", Format::Faces),
            ("b.msh2", Format::Msh22),
        ] {
            assert_eq!(of(name), format);
        }
        let point = |name: &str| WriteOptions::default().point_format_of(Path::new(name));
        assert_eq!(point("-").unwrap(), Format::Xyz);
        assert_eq!(point("p.txt.gz").unwrap(), Format::Xyz);
        let remedy = point("a.mesh").unwrap_err().remedy().unwrap();
        assert!(remedy.to_string().contains("write .vtu or .ply"));
    }

    #[test]
    fn errors_list_the_known_extensions_and_the_nearest() {
        for name in ["mesh", ".vtu", "a.zip.gz", "a.", "-", "a.xyz", ".gz"] {
            let error = WriteOptions::default().format_of(Path::new(name)).unwrap_err();
            assert!(error.remedy().unwrap().to_string().contains(".msh22"), "{error}");
        }
        for (name, advice) in [("a.vut", "the nearest is .vtu"), ("a.dat", "write .npy"), ("-", "`format`")] {
            let error = WriteOptions::default().format_of(Path::new(name)).unwrap_err();
            assert!(error.remedy().unwrap().to_string().contains(advice), "{error}");
        }
        let table = WriteOptions { format: Some(Format::Xyz), ..WriteOptions::default() };
        assert!(table.format_of(Path::new("a.vtu")).is_err());
    }
}
