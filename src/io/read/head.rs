//! The rows of a text table, as its first row and the lines before it determine them.

use super::collect::Collector;
use super::error::{InputError, Place};
use super::header::{Kept, Selection};
use super::ids::{self, Counting};
use super::points::{PointFile, ReadOptions};
use super::reading::{FileReading, OtherLines};
use super::row::{Row, Style, refuse_decimal_commas};
use super::text::{Line, Lines, Source};

/// The number of points that a line before the first row gives.
#[derive(Clone, Copy)]
pub(super) struct Announced {
    /// The line that gives the number.
    pub line: u64,
    /// The number.
    pub count: u64,
    /// The dimension that the lines state, if they do.
    pub dimension: Option<u64>,
}

/// The first row of a table, and the columns that this row and the lines before it select.
#[derive(Clone)]
pub(super) struct Head {
    selection: Selection,
    style: Style,
    pub announced: Option<Announced>,
    /// The lines before the first row.
    pub other: OtherLines,
    /// The line number of the first row.
    pub line: u64,
    /// The number of bytes of its line.
    length: usize,
    /// The number of its fields that can be coordinates.
    found: usize,
    /// The number of the first row, if the first column may count the rows.
    pub counts_from: Option<i64>,
    /// The columns to advise, if they are sure.
    sure: Option<String>,
}

/// The rows of a part of a table, and its other lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct RowCount {
    /// The number of rows.
    pub rows: u64,
    /// Comments and blank lines.
    pub other: OtherLines,
}

impl Head {
    /// Creates the head of a table with these first rows. `before` is the count, and the lines before the first row.
    pub fn new(
        selection: Selection,
        rows: &[Row<'_>],
        (announced, other): (Option<Announced>, OtherLines),
        options: &ReadOptions,
    ) -> Self {
        let row = &rows[0];
        let others = row.filled - usize::from(selection.weight.is_some_and(|weight| weight < row.filled));
        let found = if selection.is_positional() { others } else { selection.axes.len() };
        // A table whose only two columns are coordinates has no id.
        let has_others = others > options.dimension.filter(|_| !options.terrain).unwrap_or(2);
        let may_count = selection.is_positional() && has_others && selection.weight != Some(0);
        Head {
            style: row.style(),
            announced,
            other,
            line: row.line.number,
            length: row.line.text.len(),
            found,
            counts_from: ids::counts_from(row).filter(|_| may_count),
            sure: ids::sure_columns(rows, options.dimension, selection.weight),
            selection,
        }
    }

    /// Reads all rows of a file. The first of the lines is the first row.
    pub fn read(
        &mut self,
        source: Source<'_>,
        options: &ReadOptions,
        mut lines: Lines<'_>,
    ) -> Result<PointFile, InputError> {
        // An estimate: later rows are about as long as the first.
        let rows = source.data.len() / (self.length + 1) + 1;
        let mut points = self.collector(source, options, (rows as u64, source.data.len(), 4))?;
        let other = self.rows(source, options, &mut lines, &mut points)?;
        if let Some(Announced { count, .. }) = self.announced {
            points.complete(Place::Line(source.line_at(source.data.len())), count)?;
        }
        points.notes.extend(self.notes(options));
        let Kept { columns, notes } = self.selection.take_kept();
        points.notes.extend(notes);
        let mut file = points.finish();
        if let Some(first) = self.counts_from {
            let row = |i: usize| file.source_index.as_ref().map_or(i as u64, |index| index[i]);
            self.refuse_ids(source, Counting::of(&file.points, first as f64, row), file.reading.rows)?;
        }
        file.columns = columns;
        file.reading = self.reading(file.reading.rows, other);
        Ok(file)
    }

    /// Returns the record of a table of this many rows. `other` counts the lines after the first row besides the rows.
    pub fn reading(&self, rows: u64, other: OtherLines) -> FileReading {
        let mut lines = self.other;
        lines.add(other);
        let (columns, ignored) = (self.selection.names.clone(), self.selection.ignored.clone());
        FileReading { rows, columns, ignored, lines }
    }

    /// Refuses a table of `rows` rows whose first column counts them.
    pub fn refuse_ids(&self, source: Source<'_>, counting: Counting, rows: u64) -> Result<(), InputError> {
        const LEAST: u64 = 3;
        if !counting.is_id() || rows < LEAST {
            return Ok(());
        }
        let first = self.counts_from.unwrap_or(0);
        Err(InputError::Columns {
            path: source.path.to_owned(),
            place: Place::Line(self.line),
            problem: format!("the first column counts the rows from {first}, like an id").into(),
            names: Vec::new(),
            example: self.sure.clone().unwrap_or_default(),
        })
    }

    /// Creates a collector of the points. `size` is as in [`Collector::new`].
    pub fn collector<'a>(
        &self,
        source: Source<'a>,
        options: &ReadOptions,
        size: (u64, usize, usize),
    ) -> Result<Collector<'a>, InputError> {
        // The named columns are the coordinates, whatever their number.
        let chosen = (self.found > 3 && !self.selection.is_positional()).then_some(self.found);
        let options = &ReadOptions { dimension: options.dimension.or(chosen), ..options.clone() };
        Collector::new(source, options, (Place::Line(self.line), self.found), size)
            .map_err(|error| error.in_row(0))
    }

    /// Adds the points of lines, which begin at the first row or after it. Returns the numbers of the other lines.
    pub fn rows(
        &mut self,
        source: Source<'_>,
        options: &ReadOptions,
        lines: &mut Lines<'_>,
        points: &mut Collector<'_>,
    ) -> Result<OtherLines, InputError> {
        let most = self.selection.width + 1;
        let mut row = Row::empty(self.style);
        let mut other = OtherLines::default();
        for line in lines {
            row.split(line, most);
            if row.fields.is_empty() && !self.takes_mark(line, &mut row) {
                other.add(OtherLines::of_line(line));
                continue;
            }
            if let Some(Announced { count, .. }) = self.announced
                && points.met == count
            {
                return Err(source.surplus(line.place(), "points", count));
            }
            let at = points.met;
            self.push(source, points, &row, options).map_err(|error| error.in_row(at))?;
        }
        Ok(other)
    }

    /// Whether a line that looks like a comment is a row: its mark belongs to its first field, and its coordinates are
    /// numbers.
    fn takes_mark<'a>(&self, line: Line<'a>, row: &mut Row<'a>) -> bool {
        let is_number =
            |row: &Row<'_>, at: usize| row.fields.get(at).is_some_and(|f| row.number(f).is_some());
        let axes = &self.selection.axes;
        row.takes_mark(line, |row| {
            row.filled == self.selection.width && axes.iter().all(|at| is_number(row, *at))
        })
    }

    /// Counts the rows of lines, which begin at the first row or after it.
    pub fn count(&self, lines: &mut Lines<'_>) -> RowCount {
        let mut row = Row::empty(self.style);
        let mut found = RowCount::default();
        for line in lines {
            row.split(line, 1);
            if row.fields.is_empty() && !self.takes_mark(line, &mut row) {
                found.other.add(OtherLines::of_line(line));
            } else {
                found.rows += 1;
            }
        }
        found
    }

    /// Returns the notes on the table.
    pub fn notes(&self, options: &ReadOptions) -> Vec<String> {
        let mut notes: Vec<String> = self.selection.note.iter().cloned().collect();
        if let Some(Announced { line, .. }) = self.announced {
            notes.push(format!("line {line} is taken as the number of points"));
        }
        if self.style.commas {
            notes.push("commas are taken as decimal commas".to_owned());
        }
        let (used, ignored) = (self.selection.axes.len(), &self.selection.ignored);
        if self.selection.is_positional() && !ignored.is_empty() && !options.keep_columns {
            notes.push(match self.selection.weight {
                None => format!("columns after the first {used} are ignored"),
                Some(_) => format!("these columns are ignored: {}", ignored.join(", ")),
            });
        }
        notes
    }

    /// Adds the point of a row, and the values of the columns that are kept.
    fn push(
        &mut self,
        source: Source<'_>,
        points: &mut Collector<'_>,
        row: &Row<'_>,
        options: &ReadOptions,
    ) -> Result<(), InputError> {
        let before = points.len();
        let (line, dimension) = (&row.line, points.dimension());
        if row.filled != self.selection.width {
            self.check_width(source, points, row, options)?;
        }
        let axes = &self.selection.axes[..dimension];
        // The advice on columns helps only in the first row.
        let is_first = self.selection.is_positional() && points.met == 0 && !options.skip_invalid;
        if is_first
            && let Some(word) =
                axes.iter().filter_map(|&i| row.fields.get(i)).find(|field| row.number(field).is_none())
        {
            return Err(source.bad_number(line, word).with_columns(self.sure.clone()));
        }
        let last = self.selection.last(dimension);
        if let Some(empty) = row.fields.get(last).filter(|_| row.filled <= last) {
            points.malformed(line, empty)?;
        } else {
            let weight = self.selection.weight.map(|i| row.fields[i]);
            let words = &mut axes.iter().map(|&i| row.fields[i]);
            points.push_parsed(line, (words, weight), |word| row.number(word))?;
        }
        if points.len() > before {
            self.selection.keep(row);
        }
        Ok(())
    }

    /// Checks a row whose number of fields is not that of the table.
    fn check_width(
        &self,
        source: Source<'_>,
        points: &Collector<'_>,
        row: &Row<'_>,
        options: &ReadOptions,
    ) -> Result<(), InputError> {
        let (width, dimension, found) = (self.selection.width, points.dimension(), row.filled);
        let last = self.selection.last(dimension);
        let is_positional = self.selection.is_positional() && self.selection.weight.is_none();
        if found > width {
            refuse_decimal_commas(source, row)?;
            if is_positional && options.dimension.is_none() && found.min(3) != dimension {
                return Err(points.mixed(row.line.place(), found));
            }
            let whole = Row::styled(row.line, self.style).filled;
            let expected = format!(
                "{width} fields, as in the rows before, and not {whole} (a decimal comma, or a separator within a \
                 field, adds a field)"
            );
            return Err(source.bad_line(&row.line, expected));
        }
        if is_positional && row.fields.len() <= last {
            return Err(points.mixed(row.line.place(), found));
        }
        if row.fields.len() <= last {
            return Err(source.bad_line(&row.line, format!("at least {} columns", last + 1)));
        }
        if row.separator == b' ' {
            let expected =
                format!("{width} fields, as in the rows before (a field between blanks may be missing)");
            return Err(source.bad_line(&row.line, expected));
        }
        Ok(())
    }
}
