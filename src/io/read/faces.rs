//! Faces of a surface as lists of point indices.

use super::error::InputError;
use super::text::{Line, Source, integer};

/// Faces as lists of zero-based point indices.
pub(super) type Faces = Vec<Vec<u32>>;

/// Parses a zero-based point index of 32 bits.
pub(super) fn position(source: Source<'_>, line: &Line<'_>, word: Option<&[u8]>) -> Result<u32, InputError> {
    let word = word.ok_or_else(|| source.bad_line(line, "the point ids of a face"))?;
    let id = integer(word).and_then(|id| u32::try_from(id).ok());
    id.ok_or_else(|| source.bad_word(line, word, "a point id"))
}
