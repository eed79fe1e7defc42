//! Points as read, and how to read them.

use septet_core::model::Points;

use super::format::Format;

/// Called about once a mebibyte with the bytes read so far (before gunzipping) and, where known,
/// the size of the file.
pub type Progress<'a> = dyn FnMut(u64, Option<u64>) + 'a;

/// How to read a file of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// 2: keep the first two coordinates, 3: insist on three; by default the file tells.
    pub dimension: Option<usize>,
    /// The format; by default the file's name or content tells.
    pub format: Option<Format>,
    /// Drop and count points that are not finite or, in text, not numbers, instead of failing.
    pub skip_invalid: bool,
}

/// The points of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PointFile {
    /// The points in file order, every coordinate finite and none of them -0.0.
    pub points: Points,
    /// Remarks for the user, one line each: ignored columns, a header row, welded vertices.
    pub notes: Vec<String>,
    /// Points dropped because they were invalid and `skip_invalid` was set.
    pub skipped: usize,
    /// If any were dropped: the zero-based index in the file of each point kept.
    pub source_index: Option<Vec<u64>>,
    /// The id the file gave to its first point, if it is a `.node` file, else 0.
    pub first_id: u64,
}
