//! What files state about the rows of the input that are points.

use std::borrow::Cow;

use super::options::WriteOptions;
use crate::read::Column;

/// The rows of all processes: their numbers in the input, and their values.
#[derive(Clone, Debug, Default)]
pub(super) struct RowTable<'a> {
    /// The number of the first row.
    pub first: u64,
    /// The number of each row in the input, if rows were dropped.
    pub source: Option<Cow<'a, [u64]>>,
    /// The height of each row, if the points are a terrain.
    pub heights: Option<Cow<'a, [f64]>>,
    /// The values, with an entry for each row.
    pub columns: Cow<'a, [Column]>,
}

impl<'a> RowTable<'a> {
    /// Returns the table of one process.
    pub fn of_options(options: &WriteOptions<'a>) -> Self {
        RowTable {
            first: 0,
            source: options.source.map(Cow::Borrowed),
            heights: None,
            columns: Cow::Borrowed(options.point_data),
        }
    }

    /// Returns the number of a row in the input. The row has a number among the rows of all processes.
    pub fn number(&self, row: u64) -> u64 {
        self.source.as_ref().map_or(row, |source| source[self.position(row)])
    }

    /// Returns the position of a row in the columns.
    pub fn position(&self, row: u64) -> usize {
        (row - self.first) as usize
    }
}
