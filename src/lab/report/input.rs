//! What was read of the input: rows, columns, lines that are no rows, and extent.

use std::fmt::Write;

use septet_io::read::Extent;
use serde::Serialize;

use super::context::RunContext;

/// What was read of the files of the input.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InputReport {
    /// Number of rows of points, including invalid ones.
    pub rows: u64,
    /// The columns of the coordinates of a table, by name, or by number from 1. Empty for other formats, and for files with
    /// different columns.
    pub columns: Vec<String>,
    /// The other columns of a table.
    pub ignored: Vec<String>,
    /// Number of lines with names of columns.
    pub header_lines: u64,
    /// Number of lines with the number of points or the dimension.
    pub count_lines: u64,
    /// Number of comments.
    pub comment_lines: u64,
    /// Number of blank lines.
    pub blank_lines: u64,
    /// Whether the points are a terrain: triangulated by x and y, with z as the height.
    pub terrain: bool,
    /// The largest difference of the heights of coincident points of a terrain. Null if there are none.
    pub height_difference: Option<f64>,
    /// The least and the largest coordinate on each axis, and the heights of a terrain. Empty if there are no points.
    pub extent: Vec<[f64; 2]>,
    /// Number of points that coincide with a point of smaller index.
    pub duplicates: u64,
}

impl InputReport {
    /// Returns the report of what was read, or `None` for a sample.
    pub(super) fn of(context: &RunContext<'_>, duplicates: u64) -> Option<Self> {
        let reading = context.reading?;
        let lines = reading.lines;
        let sides = |extent: &Extent| extent.low.iter().zip(&extent.high).map(|(l, h)| [*l, *h]).collect();
        Some(InputReport {
            rows: reading.rows,
            columns: reading.columns.clone(),
            ignored: reading.ignored.clone(),
            header_lines: lines.header,
            count_lines: lines.counts,
            comment_lines: lines.comments,
            blank_lines: lines.blank,
            terrain: context.is_terrain,
            height_difference: context.height_difference,
            extent: context.extent.map_or_else(Vec::new, sides),
            duplicates,
        })
    }

    /// Returns one line with what was read of an input of this name: `points.csv: 12 rows, columns lon lat (3 ignored), 1
    /// header line, 2 comment lines; x 9.1 to 9.8, y 47.0 to 47.6`.
    pub fn line(&self, name: &str) -> String {
        let plural = |n: u64, noun: &str| format!("{n} {noun}{}", if n == 1 { "" } else { "s" });
        let kind = if self.terrain { "terrain of " } else { "" };
        let mut line = format!("{name}: {kind}{}", plural(self.rows, "row"));
        // Writing to a string cannot fail.
        if !self.columns.is_empty() {
            let _ = write!(line, ", columns {}", self.columns.join(" "));
        }
        if !self.ignored.is_empty() {
            let _ = write!(line, " ({} ignored)", self.ignored.len());
        }
        let counts = [self.header_lines, self.count_lines, self.comment_lines, self.blank_lines];
        let nouns = ["header line", "count line", "comment line", "blank line"];
        for (count, noun) in counts.into_iter().zip(nouns).filter(|(count, _)| *count > 0) {
            let _ = write!(line, ", {}", plural(count, noun));
        }
        let axis = |(axis, [low, high]): (&str, &[f64; 2])| format!("{axis} {low:?} to {high:?}");
        let axes: Vec<String> =
            ["x", "y", "z", "x4", "x5", "x6"].into_iter().zip(&self.extent).map(axis).collect();
        if axes.is_empty() { line } else { format!("{line}; {}", axes.join(", ")) }
    }

    /// Returns a note on the coincident points of a terrain, if there are any.
    pub fn height_note(&self) -> Option<String> {
        let difference = self.height_difference?;
        let (subject, verb, their) = match self.duplicates {
            1 => ("1 point".to_owned(), "has", "its z differs"),
            many => (format!("{many} points"), "have", "their z differ"),
        };
        Some(format!(
            "{subject} {verb} the x and y of an earlier point, whose z is kept; {their} by at most {difference:?}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use septet_io::read::{FileReading, OtherLines};

    use super::*;

    #[test]
    fn a_line_says_what_was_read() {
        let reading = FileReading {
            rows: 12,
            columns: vec!["lon".into(), "lat".into()],
            ignored: vec!["id".into(), "t".into(), "q".into()],
            lines: OtherLines { header: 1, counts: 0, comments: 2, blank: 0 },
        };
        let extent = Extent { low: vec![9.1, 47.0], high: vec![9.8, 47.6] };
        let of = |reading, extent| RunContext { reading: Some(reading), extent, ..RunContext::default() };
        let line = |context: &RunContext<'_>, name| InputReport::of(context, 2).unwrap().line(name);
        let context = of(&reading, Some(&extent));
        assert_eq!(
            line(&context, "points.csv"),
            "points.csv: 12 rows, columns lon lat (3 ignored), 1 header line, 2 comment lines; \
             x 9.1 to 9.8, y 47.0 to 47.6"
        );
        let mesh = FileReading { rows: 1, ..FileReading::default() };
        assert_eq!(line(&of(&mesh, None), "a.vtu"), "a.vtu: 1 row");
        let extent = extent.clone().with_axis(&[400.5]);
        let terrain =
            RunContext { is_terrain: true, height_difference: Some(0.5), ..of(&mesh, Some(&extent)) };
        assert_eq!(
            line(&terrain, "a.las"),
            "a.las: terrain of 1 row; x 9.1 to 9.8, y 47.0 to 47.6, z 400.5 to 400.5"
        );
        assert_eq!(
            InputReport::of(&terrain, 2).unwrap().height_note().unwrap(),
            "2 points have the x and y of an earlier point, whose z is kept; their z differ by at most 0.5"
        );
        assert_eq!(InputReport::of(&context, 2).unwrap().height_note(), None);
    }
}
