//! The points of a file, and the options for reading them.

use std::borrow::Cow;

use septet_core::model::Points;

use super::raw_rows::RawRows;
use super::reading::FileReading;
pub use super::scalar::CoordinateType;
use super::weights::WeightOption;
use crate::format::Format;

/// Receives the number of bytes read so far, before decompression, and the size of the file if it is known.
///
/// The readers call it about once per mebibyte, before and after decompression.
pub type ReadProgress<'a> = dyn FnMut(u64, Option<u64>) + 'a;

/// The options for reading a file of points.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The number of coordinates per point: 2 keeps the first two, 3 to 6 require as many. By default, the file determines
    /// the dimension.
    pub dimension: Option<usize>,
    /// The format. By default, the file name determines it, or the content if the name does not.
    pub format: Option<Format>,
    /// The rows of a file of coordinates in binary without a header. No name and no content has this format, so that it is
    /// always stated. [`ReadOptions::format`] is then not used.
    pub raw: Option<RawRows>,
    /// Whether to drop and count points with infinite, NaN or unreadable coordinates. By default they are errors.
    pub skip_invalid: bool,
    /// The columns of the coordinates in a text table: two to six names or 1-based numbers.
    ///
    /// Names require a header row and are compared without regard to case, quotes or units in brackets. By default,
    /// the reader uses the columns `x`, `y` and `z`, or the first columns if there is no header row. Tables of more than
    /// three columns without a header row need this option or [`ReadOptions::dimension`].
    pub columns: Option<Vec<String>>,
    /// Whether to keep the other numeric columns of a text table as [`PointFile::columns`].
    pub keep_columns: bool,
    /// Whether the points are a terrain: x and y are the coordinates of [`PointFile::points`], and z goes to
    /// [`PointFile::heights`]. [`ReadOptions::dimension`] must not be 3.
    ///
    /// The points have three coordinates. A `.node` file in the plane may have z as its first attribute. The points of a grid
    /// of heights (ESRI ASCII raster) are the centres of its cells with data, row by row from the top; without this option, a
    /// grid is refused.
    pub terrain: bool,
    /// Where the weights of the points are. By default, points have no weights. A terrain has none.
    ///
    /// A point whose weight is NaN, infinite or unreadable is invalid, and so is one with a negative radius.
    pub weights: Option<WeightOption>,
}

impl ReadOptions {
    /// Returns the column of the weights, and whether they are radii, if the weights are in a column.
    pub(super) fn weight_column(&self) -> Option<(&str, bool)> {
        let option = self.weights.as_ref()?;
        Some((option.column()?, option.are_radii))
    }

    /// Whether the weights are in a file of their own.
    pub(super) fn has_weight_file(&self) -> bool {
        self.weights.as_ref().is_some_and(|option| option.file().is_some())
    }

    /// Whether rows of the file of weights decide which points are dropped.
    pub(super) fn drops_by_weight_file(&self) -> bool {
        self.skip_invalid && self.has_weight_file()
    }

    /// Returns the options for one file of several, or for points without the file of their weights.
    pub(super) fn without_weight_file(&self) -> Cow<'_, Self> {
        if self.has_weight_file() {
            Cow::Owned(ReadOptions { weights: None, ..self.clone() })
        } else {
            Cow::Borrowed(self)
        }
    }
}

/// A numeric column of a text table that is not a coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The name in the header row, or `column_4` for the fourth column of a file without one.
    pub name: String,
    /// One value per point that was kept. An empty field is NaN.
    pub values: Vec<f64>,
}

/// The points of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PointFile {
    /// The points in file order. Coordinates are finite and never -0.0.
    pub points: Points,
    /// The height of each point of a terrain. `None` without [`ReadOptions::terrain`].
    pub heights: Option<Vec<f64>>,
    /// The weight of each point, a squared length. Weights are finite and never -0.0. `None` without
    /// [`ReadOptions::weights`].
    pub weights: Option<Vec<f64>>,
    /// Notes for the user, one line each, for example on ignored columns, a header row or merged vertices.
    pub notes: Vec<String>,
    /// The number of integers of a binary file that no double holds, so that they were rounded.
    pub rounded: u64,
    /// The number of invalid points that were dropped.
    pub skipped: usize,
    /// The zero-based index in the file of each point, or `None` if no point was dropped.
    pub source_index: Option<Vec<u64>>,
    /// The id of the first point in a `.node` file, 0 for other formats.
    pub first_id: u64,
    /// The columns kept because of [`ReadOptions::keep_columns`].
    pub columns: Vec<Column>,
    /// The type of the coordinates in a binary file, or `None` for text.
    pub coordinate_type: Option<CoordinateType>,
    /// The record of the reading: rows, columns and other lines.
    pub reading: FileReading,
}

impl PointFile {
    /// Creates a file of these points and nothing else.
    pub(super) fn of_points(points: Points) -> Self {
        let reading = FileReading::of_rows(points.len() as u64);
        PointFile {
            reading,
            points,
            heights: None,
            weights: None,
            notes: Vec::new(),
            rounded: 0,
            skipped: 0,
            source_index: None,
            first_id: 0,
            columns: Vec::new(),
            coordinate_type: None,
        }
    }
}
