//! First columns that count the rows or name them, and therefore hold no coordinates.

use septet_core::model::Points;

use super::row::Row;
use super::text::integer;

/// Whether the first fields of rows of `width` fields are names of rows: texts, or whole numbers that rise.
pub(super) fn are_row_names(rows: &[Row<'_>], width: usize) -> bool {
    let mut last = None;
    rows.iter().all(|row| {
        let field = row.fields.first().copied().unwrap_or_default();
        let is_name = match (integer(field), last) {
            (Some(id), Some(before)) => id > before,
            (Some(_), None) => true,
            (None, _) => row.number(field).is_none() && !field.is_empty(),
        };
        last = integer(field).or(last);
        is_name && row.filled == width
    })
}

/// Returns the number in the first field of a first row, if rows may count from it: 0 or 1, also written as `0.0` or `1e0`.
pub(super) fn counts_from(row: &Row<'_>) -> Option<i64> {
    let first = row.number(row.fields.first()?)?;
    [0, 1].into_iter().find(|n| first == *n as f64)
}

/// Returns the number from which the first fields of the rows count, if it is 0 or 1, and the other numbers have fractions.
pub(super) fn counted_from(rows: &[Row<'_>]) -> Option<i64> {
    let first = counts_from(rows.first()?)?;
    let counts =
        |(row, n): (&Row<'_>, i64)| row.fields.first().and_then(|field| row.number(field)) == Some(n as f64);
    let has_fraction =
        |row: &Row<'_>| row.fields.iter().skip(1).any(|field| row.number(field).is_some_and(is_fraction));
    (rows.iter().zip(first..).all(counts) && rows.iter().any(has_fraction)).then_some(first)
}

fn is_fraction(value: f64) -> bool {
    value.fract() != 0.0
}

/// Returns the columns of the coordinates as 1-based numbers, if the first rows leave no doubt: all columns of numbers but
/// a first one that counts the rows, and the one of the weights, if they are as many as the dimension.
pub(super) fn sure_columns(
    rows: &[Row<'_>],
    dimension: Option<usize>,
    weight: Option<usize>,
) -> Option<String> {
    let width = rows.iter().map(|row| row.filled).min()?;
    let is_numeric = |i: &usize| rows.iter().all(|row| row.number(row.fields[*i]).is_some());
    let counts = usize::from(counted_from(rows).is_some());
    let columns: Vec<usize> = (counts..width).filter(|i| weight != Some(*i)).filter(is_numeric).collect();
    let is_sure = match dimension {
        Some(dimension) => columns.len() == dimension,
        None => matches!(columns.len(), 2 | 3),
    };
    let text = |i: &usize| (i + 1).to_string();
    is_sure.then(|| columns.iter().map(text).collect::<Vec<_>>().join(","))
}

/// The state of a first column that may count rows: the first number, and whether it has counted rows so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counting {
    /// Whether the first coordinates are the numbers of the rows.
    pub counts: bool,
    /// Whether another coordinate has a fraction.
    pub has_fraction: bool,
}

impl Counting {
    /// Looks at points. `row` returns the number in the file of each point, and `first` is the number of row 0.
    pub fn of(points: &Points, first: f64, row: impl Fn(usize) -> u64) -> Self {
        let coordinates = points.coordinates();
        let rows = coordinates.chunks_exact(points.dimension());
        // Most columns stop counting at the second row, so this costs no second pass over the points.
        let counts = rows.clone().enumerate().all(|(i, point)| point[0] == first + row(i) as f64);
        let has_fraction = counts && rows.flat_map(|point| &point[1..]).any(|c| is_fraction(*c));
        Counting { counts, has_fraction }
    }

    /// Joins the states of two parts of a file.
    pub fn and(self, other: Counting) -> Self {
        Counting {
            counts: self.counts && other.counts,
            has_fraction: self.has_fraction || other.has_fraction,
        }
    }

    /// Whether the column is an id.
    pub fn is_id(self) -> bool {
        self.counts && self.has_fraction
    }
}
