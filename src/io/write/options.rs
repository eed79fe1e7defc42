//! The options of the writers.

use std::path::Path;

use super::error::OutputError;
use super::format::{MshVersion, OutputFormat, PointFormat};
use crate::read::Column;

/// The options of the writers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WriteOptions<'a> {
    /// The format of triangulations. By default, the file name extension determines it.
    pub format: Option<OutputFormat>,
    /// The format of point sets. By default, the file name extension determines it.
    pub point_format: Option<PointFormat>,
    /// Whether to write the owner and the owning leaf of each cell, if the mesh contains them (`.vtu` and `.vtk`
    /// only).
    pub with_owner: bool,
    /// The id of the first point and of the first cell in the files of `TetGen`: 0 or 1, as in the `.node` file of the
    /// points.
    pub first_id: u64,
    /// The version of a `.msh` file whose extension does not determine it.
    pub msh: MshVersion,
    /// Values at the points of a triangulation, one column per array (`.vtu` and `.vtk` only).
    pub point_data: &'a [Column],
}

impl WriteOptions<'_> {
    /// Returns the format in which a triangulation is written to this path.
    ///
    /// # Errors
    /// Returns [`OutputError::UnknownFormat`] if neither the options nor the extension determine it.
    pub fn format_of(&self, path: &Path) -> Result<OutputFormat, OutputError> {
        self.format.map_or_else(|| OutputFormat::of(path), Ok)
    }

    /// Returns the format in which a point set is written to this path.
    ///
    /// # Errors
    /// Returns [`OutputError::UnknownFormat`] if neither the options nor the extension determine it.
    pub fn point_format_of(&self, path: &Path) -> Result<PointFormat, OutputError> {
        self.point_format.map_or_else(|| PointFormat::of(path), Ok)
    }
}

pub(super) fn check_first_id(first_id: u64) -> Result<(), OutputError> {
    if first_id > 1 {
        return Err(OutputError::FirstId { first_id });
    }
    Ok(())
}
