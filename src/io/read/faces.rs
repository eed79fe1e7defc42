//! Faces of a surface as lists of point indices.

use super::cells::{CellFile, CellOptions, Indices};
use super::error::{InputError, Place};
use super::points::PointFile;
use super::text::{Line, Source, integer};

/// Faces as lists of zero-based point indices.
pub(super) type Faces = Vec<Vec<u32>>;

/// Parses a zero-based point index of 32 bits.
pub(super) fn position(source: Source<'_>, line: &Line<'_>, word: Option<&[u8]>) -> Result<u32, InputError> {
    let word = word.ok_or_else(|| source.bad_line(line, "the point ids of a face"))?;
    let id = integer(word).and_then(|id| u32::try_from(id).ok());
    id.ok_or_else(|| source.bad_word(line, word, "a point id"))
}

/// Returns the faces of a surface as cells, which must be triangles. `points` reads the points of the file, which bound the
/// indices if the options do not.
pub(super) fn triangles(
    source: Source<'_>,
    faces: &Faces,
    options: &CellOptions,
    points: impl Fn() -> Result<PointFile, InputError>,
) -> Result<CellFile, InputError> {
    let limit = match options.point_count {
        Some(count) => count,
        None => points()?.points.len() as u64,
    };
    let mut cells = Indices::new(source, 3, 0, Some(limit));
    for face in faces {
        if face.len() != 3 {
            let what = format!("a face with {} corners as a cell", face.len());
            return Err(source.unsupported(Place::Whole, what, "export the surface as triangles"));
        }
        face.iter().try_for_each(|corner| cells.push(Place::Whole, i128::from(*corner)))?;
    }
    Ok(cells.finish(Vec::new()))
}
