//! The files that together hold one set of rows.

use std::path::PathBuf;

/// A file of a list, and the rows of points that it contributes. Or a piece of a triangulation, and its cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedFile {
    /// The file.
    pub path: PathBuf,
    /// The zero-based row of its first point in the list, or of its first cell among those of all pieces.
    pub first_row: u64,
    /// The number of its points, including dropped ones, or of its cells.
    pub rows: u64,
}

impl ListedFile {
    /// Returns the file of a row among the files of a list or the pieces of a triangulation. Dropped points count.
    pub fn of_row(files: &[ListedFile], row: u64) -> Option<&ListedFile> {
        files.get(files.partition_point(|file| file.first_row + file.rows <= row))
    }
}
