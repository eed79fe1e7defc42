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

/// The faces of a file, and the way in which the file numbers points and has faces.
pub(super) struct FileFaces<'a> {
    pub source: Source<'a>,
    pub faces: Faces,
    /// The id of the first point in the file.
    pub first: u64,
    /// Returns the location of a face, given by its position.
    pub place: fn(Source<'_>, usize) -> Place,
}

/// Returns the faces of a surface as cells, which must be triangles. `points` reads the points of the file, which bound the
/// indices if the options do not.
pub(super) fn triangles(
    file: &FileFaces<'_>,
    options: &CellOptions,
    points: impl Fn() -> Result<PointFile, InputError>,
) -> Result<CellFile, InputError> {
    let (source, first) = (file.source, file.first);
    let limit = match options.point_count {
        Some(count) => count,
        None => points()?.points.len() as u64,
    };
    let mut cells = Indices::new(source, 3, first, Some(limit));
    for (at, face) in file.faces.iter().enumerate() {
        if face.len() != 3 {
            let what = format!("a face with {} corners as a cell", face.len());
            let advice = "export the surface as triangles";
            return Err(source.unsupported((file.place)(source, at), what, advice));
        }
        for corner in face {
            let pushed = cells.push(Place::Whole, i128::from(*corner) + i128::from(first));
            pushed.map_err(|error| error.at((file.place)(source, at)))?;
        }
    }
    Ok(cells.finish(Vec::new()))
}
