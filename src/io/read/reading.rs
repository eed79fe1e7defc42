//! The record of a reading: the rows, the columns, and the other lines of a file.

use glam::{DVec2, DVec3};
use septet_core::model::{HigherPoints, Points};

use super::text::Line;

/// The record of reading a file, or the files of a list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileReading {
    /// The number of rows, including dropped ones.
    pub rows: u64,
    /// The columns of the coordinates of a table, by name, or by 1-based number. Empty for other formats, and for a list of
    /// tables with different columns.
    pub columns: Vec<String>,
    /// The columns of a table that are not read as coordinates.
    pub ignored: Vec<String>,
    /// The lines of a table besides its rows.
    pub lines: OtherLines,
}

/// The numbers of lines of a table besides its rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OtherLines {
    /// Lines with the names of columns.
    pub header: u64,
    /// Lines with the number of points or the dimension.
    pub counts: u64,
    /// Comments.
    pub comments: u64,
    /// Blank lines.
    pub blank: u64,
}

/// The least and the largest coordinate on each axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// The least coordinates.
    pub low: Vec<f64>,
    /// The largest coordinates.
    pub high: Vec<f64>,
}

impl OtherLines {
    /// Returns the numbers in the order of the fields.
    pub fn counts(self) -> [u64; 4] {
        [self.header, self.counts, self.comments, self.blank]
    }

    /// Returns the lines of these numbers.
    pub fn of_counts([header, counts, comments, blank]: [u64; 4]) -> Self {
        OtherLines { header, counts, comments, blank }
    }

    /// Returns the count of a line that is a comment or blank.
    pub(super) fn of_line(line: Line<'_>) -> Self {
        let is_blank = line.text.trim_ascii().is_empty();
        OtherLines { comments: u64::from(!is_blank), blank: u64::from(is_blank), ..OtherLines::default() }
    }

    /// Adds the numbers of other lines.
    pub(super) fn add(&mut self, more: OtherLines) {
        self.header += more.header;
        self.counts += more.counts;
        self.comments += more.comments;
        self.blank += more.blank;
    }
}

impl FileReading {
    /// Returns the reading of a file that is no table.
    pub(super) fn of_rows(rows: u64) -> Self {
        FileReading { rows, ..FileReading::default() }
    }

    /// Adds the reading of the next file of a list. Columns stay if both files have the same.
    pub(super) fn add(&mut self, next: &FileReading) {
        if self.rows == 0 && next.rows > 0 {
            (self.columns, self.ignored) = (next.columns.clone(), next.ignored.clone());
        } else if next.rows > 0 && (&self.columns, &self.ignored) != (&next.columns, &next.ignored) {
            (self.columns, self.ignored) = (Vec::new(), Vec::new());
        }
        self.rows += next.rows;
        self.lines.add(next.lines);
    }
}

impl Extent {
    /// Returns the extent of points, or `None` if there are none.
    pub fn of(points: &Points) -> Option<Self> {
        match points {
            Points::Plane(points) => Extent::of_rows(points.iter().map(DVec2::to_array)),
            Points::Space(points) => Extent::of_rows(points.iter().map(DVec3::to_array)),
            Points::Higher(HigherPoints::Four(points)) => Extent::of_rows(points.iter().map(|p| p.0)),
            Points::Higher(HigherPoints::Five(points)) => Extent::of_rows(points.iter().map(|p| p.0)),
            Points::Higher(HigherPoints::Six(points)) => Extent::of_rows(points.iter().map(|p| p.0)),
        }
    }

    fn of_rows<const D: usize>(mut rows: impl Iterator<Item = [f64; D]>) -> Option<Self> {
        let first = rows.next()?;
        let (mut low, mut high) = (first, first);
        for row in rows {
            low = std::array::from_fn(|axis| low[axis].min(row[axis]));
            high = std::array::from_fn(|axis| high[axis].max(row[axis]));
        }
        Some(Extent { low: low.to_vec(), high: high.to_vec() })
    }

    /// Returns the extent with a further axis of these values, such as heights.
    #[must_use]
    pub fn with_axis(mut self, values: &[f64]) -> Self {
        self.low.push(values.iter().copied().fold(f64::INFINITY, f64::min));
        self.high.push(values.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        self
    }

    /// Returns the extent of both.
    #[must_use]
    pub fn and(mut self, other: &Extent) -> Self {
        self.low.iter_mut().zip(&other.low).for_each(|(low, other)| *low = low.min(*other));
        self.high.iter_mut().zip(&other.high).for_each(|(high, other)| *high = high.max(*other));
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extents_are_joined() {
        let points = Points::Plane(vec![DVec2::new(9.8, 47.0), DVec2::new(9.1, 47.6)]);
        let more = Points::Plane(vec![DVec2::new(9.2, 48.0)]);
        let extent = Extent::of(&points).unwrap().and(&Extent::of(&more).unwrap());
        assert_eq!((&extent.low, &extent.high), (&vec![9.1, 47.0], &vec![9.8, 48.0]));
        assert_eq!(extent.with_axis(&[3.0, -1.0]).low[2], -1.0);
        assert_eq!(Extent::of(&Points::Space(Vec::new())), None);
    }

    #[test]
    fn files_of_a_list_keep_common_columns() {
        let of = |names: [&str; 2], rows| FileReading {
            rows,
            columns: names.map(str::to_owned).to_vec(),
            ..FileReading::default()
        };
        let mut all = FileReading::default();
        for one in [of(["lon", "lat"], 0), of(["x", "y"], 2), of(["x", "y"], 3)] {
            all.add(&one);
        }
        assert_eq!((all.rows, all.columns.join(" ")), (5, "x y".to_owned()));
        all.add(&of(["x", "z"], 1));
        assert!(all.columns.is_empty());
    }
}
