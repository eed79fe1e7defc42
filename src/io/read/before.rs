//! The lines of a text table before its first row: comments, counts and the header.
//!
//! **Counts.** A line of one whole number is the number of points. Qhull writes the dimension, with a comment, and then the
//! number of points. A line of several whole numbers is a count if the second is the width of the rows below it, which have
//! fractions, and if its own width is another one, or the first is exactly the number of these rows.
//!
//! **Header.** A header is a line of names. The comment just before the rows is the header if it has as many names as the rows
//! have fields, and x and y are among them.

use super::error::{InputError, Place};
use super::head::{Announced, Head};
use super::header::{Header, Selection, Stated, StatedCount, is_header};
use super::points::ReadOptions;
use super::reading::OtherLines;
use super::row::{Row, Style, comment, has_decimal_commas, is_tabbed, refuse_decimal_commas};
use super::text::{Line, Lines, Source, integer, number};

/// The number of rows that decide how a table is read. Later rows must agree with them.
pub(super) const LOOK: usize = 16;

/// The least number of points that a line of several numbers announces.
const LEAST: u64 = 3;

/// The lines of a table before its first row.
pub(super) struct Before<'a> {
    source: Source<'a>,
    options: &'a ReadOptions,
    header: Option<Line<'a>>,
    announced: Option<Announced>,
    /// The number of the last line of the counts.
    counted: u64,
    /// The last comment.
    comment: Option<Line<'a>>,
    other: OtherLines,
}

/// A line of whole numbers before rows, which may be a count.
pub(super) enum Doubt {
    /// The line is a count, or it is not.
    None,
    /// The number of rows decides: the line is a count if this many rows follow it.
    IfRows(u64),
}

impl<'a> Before<'a> {
    /// Creates the state before the first line.
    pub fn new(source: Source<'a>, options: &'a ReadOptions) -> Self {
        Before {
            source,
            options,
            header: None,
            announced: None,
            counted: 0,
            comment: None,
            other: OtherLines::default(),
        }
    }

    /// Finds the counts at the beginning. `size` is the size of the file, of which `source` contains the first bytes.
    pub fn counts(&mut self, size: u64) -> Doubt {
        let mut lines = DataLines(Lines::new(self.source.data));
        let Some(first) = lines.next() else { return Doubt::None };
        let whole = |line: Line<'_>| whole_numbers(line);
        let (numbers, is_pure) = whole(first);
        match (&numbers[..], is_pure) {
            ([dimension], _) => {
                let Some(second) = lines.next() else { return Doubt::None };
                let Some(third) = lines.next() else { return Doubt::None };
                let [count] = whole(second).0[..] else { return Doubt::None };
                let width = Row::of(third, 8).numbers() as u64;
                let is_row = width > 1 && Row::of(third, 8).filled as u64 == width;
                let announced = match (*dimension == width, count == width && is_pure) {
                    (true, _) => Some((count, second.number)),
                    (false, true) => Some((*dimension, first.number)),
                    (false, false) => None,
                };
                if let Some((count, line)) = announced.filter(|_| is_row) {
                    self.announced = Some(Announced { line, count, dimension: Some(width) });
                    self.counted = second.number;
                }
                Doubt::None
            }
            ([count, rest @ ..], true) if rest.len() < 4 => self.several(*count, rest, (lines, size)),
            _ => Doubt::None,
        }
    }

    /// Judges a first line of several whole numbers. The second must be the width of the rows.
    fn several(&mut self, count: u64, rest: &[u64], (lines, size): (DataLines<'a>, u64)) -> Doubt {
        let line = lines.0.number();
        let behind = size.saturating_sub((self.source.data.len() - lines.0.rest().len()) as u64);
        let rows: Vec<Row<'_>> = lines.take(LOOK - 1).map(|line| Row::of(line, 64)).collect();
        let Some(width) = rows.first().map(|row| row.filled) else { return Doubt::None };
        let is_numeric = rows.iter().all(|row| row.filled == width && row.numbers() == width);
        let has_fraction = rows.iter().flat_map(|row| &row.fields).any(|field| integer(field).is_none());
        if width < 2 || rest[0] != width as u64 || !is_numeric || !has_fraction || count < LEAST {
            return Doubt::None;
        }
        if rest.len() + 1 != width {
            self.announced = Some(Announced { line, count, dimension: Some(width as u64) });
            self.counted = line;
            return Doubt::None;
        }
        // The rows are about as long as the first ones, so most rows of points cannot be counts.
        let length = rows.iter().map(|row| row.line.text.len() as u64 + 1).sum::<u64>() / rows.len() as u64;
        let expected = behind / length.max(1);
        if count > 4 * expected + 16 || 4 * count.saturating_add(4) < expected {
            return Doubt::None;
        }
        Doubt::IfRows(count)
    }

    /// Takes the first line as the count of all rows of a whole file, if this many rows follow it.
    pub fn take_if_rows(&mut self, count: u64) {
        let mut lines = DataLines(Lines::new(self.source.data));
        let Some(first) = lines.next() else { return };
        if lines.take(count as usize + 1).count() as u64 == count {
            let dimension = whole_numbers(first).0.get(1).copied();
            self.announced = Some(Announced { line: first.number, count, dimension });
            self.counted = first.number;
        }
    }

    /// Finds the first row. The next line of `lines` is then this row. Returns `None` if there is no row, or, unless the
    /// source `is_whole`, if there are too few rows to decide.
    pub fn first_row(&mut self, lines: &mut Lines<'a>, is_whole: bool) -> Result<Option<Head>, InputError> {
        let mut row = Row::empty(Style::default());
        loop {
            let rest = lines.clone();
            let Some(line) = lines.next() else { return Ok(None) };
            row.split(line, usize::MAX);
            if row.fields.is_empty() && !self.marked(line, &mut row) {
                self.skip(line);
                continue;
            }
            if self.takes(&row) {
                continue;
            }
            *lines = rest.clone();
            let style = Style { tabs: is_tabbed(line, self.header.is_some()), commas: false };
            let mut rows = self.look(rest.clone(), style);
            if rows.len() < LOOK && !is_whole {
                return Ok(None);
            }
            if has_decimal_commas(&rows) {
                rows = self.look(rest, Style { commas: true, ..style });
            }
            return self.head(&rows).map(Some);
        }
    }

    /// Whether a line that looks like a comment is a row of a table with a header: its mark belongs to its first field.
    fn marked(&self, line: Line<'a>, row: &mut Row<'a>) -> bool {
        let Some(header) = self.header else { return false };
        let style = Style { tabs: is_tabbed(line, true), commas: false };
        let names = Row::styled(header, style);
        let header = Header::of(header.number, &names.fields, names.separator == b' ');
        let Some(axes) = header.axes() else { return false };
        let is_number =
            |row: &Row<'_>, at: usize| row.fields.get(at).is_some_and(|f| row.number(f).is_some());
        row.takes_mark(line, |row| row.filled == header.width() && axes.iter().all(|at| is_number(row, *at)))
    }

    /// Counts a line without fields.
    fn skip(&mut self, line: Line<'a>) {
        if comment(line).is_some() {
            self.comment = Some(line);
        }
        self.other.add(OtherLines::of_line(line));
    }

    /// Returns `true` and stores the row if it is a header row or a count.
    fn takes(&mut self, row: &Row<'a>) -> bool {
        let line = row.line;
        if line.number <= self.counted {
            self.other.counts += 1;
            return true;
        }
        if self.header.is_none() && is_header(&Self::names(line).fields) {
            let names = Self::names(line);
            let is_text = self.announced.is_some()
                && Header::of(line.number, &names.fields, names.separator == b' ').axes().is_none();
            // After a count, other words are the comment of a chemical file.
            if is_text && self.announced.is_some_and(|announced| announced.line + 1 == line.number) {
                self.other.comments += 1;
                return true;
            }
            if is_text {
                return false;
            }
            self.header = Some(line);
            self.other.header += 1;
            return true;
        }
        if self.header.is_some() || self.announced.is_some() || row.fields.len() > 1 {
            return false;
        }
        let count = integer(row.fields[0]).and_then(|n| u64::try_from(n).ok());
        self.announced = count.map(|count| Announced { line: line.number, count, dimension: None });
        self.other.counts += u64::from(count.is_some());
        count.is_some()
    }

    /// Splits a line of names.
    fn names(line: Line<'a>) -> Row<'a> {
        Row::styled(line, Style { tabs: is_tabbed(line, true), commas: false })
    }

    /// Returns the first rows.
    fn look(&self, lines: Lines<'a>, style: Style) -> Vec<Row<'a>> {
        let row = |line: Line<'a>| {
            let mut row = Row::styled(line, style);
            if row.fields.is_empty() {
                self.marked(line, &mut row);
            }
            row
        };
        lines.map(row).filter(|row| !row.fields.is_empty()).take(LOOK).collect()
    }

    /// Selects the columns from the header row, the options and the first rows of numbers.
    fn head(&mut self, rows: &[Row<'a>]) -> Result<Head, InputError> {
        let (source, row) = (self.source, &rows[0]);
        if let Some(count) = &self.announced
            && row.filled < 2
        {
            let (path, place) = (source.path.to_owned(), Place::Line(count.line));
            return Err(InputError::UnsupportedDimension { path, place, found: 1 });
        }
        let header = self.header_of(rows)?;
        let is_text = row.numbers() == 0;
        let lacks_names = header.as_ref().is_some_and(|header| header.axes().is_none());
        if is_text && lacks_names && self.options.columns.is_none() {
            return Err(source.bad_line(&row.line, "a row of numbers"));
        }
        let count = match self.announced {
            None => StatedCount::None,
            Some(Announced { dimension: None, .. }) => StatedCount::Alone,
            Some(Announced { dimension: Some(dimension), .. }) => StatedCount::WithDimension(dimension),
        };
        let stated = Stated { header: header.as_ref(), count };
        let selection = Selection::of(source, stated, rows, self.options).or_else(|error| {
            refuse_decimal_commas(source, row)?;
            Err(error)
        })?;
        Ok(Head::new(selection, rows, (self.announced, self.other), self.options))
    }

    /// Returns the header of rows, if there is one.
    fn header_of(&mut self, rows: &[Row<'a>]) -> Result<Option<Header>, InputError> {
        let row = &rows[0];
        let Some(line) = self.header else {
            return Ok(self.comment.and_then(|line| self.commented(line, row)));
        };
        let style = Style { tabs: row.separator == b'\t', commas: false };
        let names = Row::styled(line, style);
        let mut header = Header::of(line.number, &names.fields, names.separator == b' ');
        let by_number =
            |columns: &Vec<String>| columns.iter().all(|name| integer(name.trim().as_bytes()).is_some());
        let is_free = self.options.columns.as_ref().is_some_and(by_number);
        if row.filled > header.width() && !header.shift(rows) && !is_free {
            let (found, names) = (row.filled, header.width());
            let expected = format!(
                "{names} fields, one for each name in line {}, and not {found} (a decimal comma, or a separator \
                 within a field, adds a field)",
                line.number
            );
            return Err(self.source.bad_line(&row.line, expected).in_row(0));
        }
        Ok(Some(header))
    }

    /// Returns the header that a comment before the rows contains.
    fn commented(&mut self, line: Line<'a>, row: &Row<'a>) -> Option<Header> {
        let text = comment(line)?;
        let names = Self::names(text);
        let header = Header::of(line.number, &names.fields, names.separator == b' ');
        let is_header = header.width() == row.filled && row.numbers() > 1 && header.axes().is_some();
        if is_header {
            (self.other.comments, self.other.header) = (self.other.comments - 1, self.other.header + 1);
        }
        is_header.then_some(header)
    }

    /// Returns the error for a file that contains only a count or a header row, and the lines of an empty file.
    pub fn without_rows(self) -> Result<OtherLines, InputError> {
        let source = self.source;
        if let Some(count) = self.announced.filter(|count| count.count > 0) {
            let (path, place) = (source.path.to_owned(), Place::Line(count.line));
            return Err(InputError::UnsupportedDimension { path, place, found: 1 });
        }
        if let Some(line) = self.header {
            let names = Self::names(line);
            let header = Header::of(line.number, &names.fields, names.separator == b' ');
            if header.axes().is_some() {
                let (path, place) = (source.path.to_owned(), Place::Line(header.line));
                return Err(InputError::NoRows { path, place });
            }
            return Err(source.bad_line(&line, "rows of numbers"));
        }
        Ok(self.other)
    }
}

/// The lines of a table, without comments and blank lines.
struct DataLines<'a>(Lines<'a>);

impl<'a> Iterator for DataLines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        self.0.find(|line| !Row::of(*line, 1).fields.is_empty())
    }
}

/// Returns the whole numbers at the beginning of a line, and whether nothing follows them. Qhull writes a comment after a
/// number, which begins with a letter.
fn whole_numbers(line: Line<'_>) -> (Vec<u64>, bool) {
    let fields = Row::of(line, 16).fields;
    let numbers: Vec<u64> =
        fields.iter().map_while(|field| integer(field).and_then(|n| u64::try_from(n).ok())).collect();
    let next = fields.get(numbers.len());
    let is_comment =
        next.is_none_or(|next| number(next).is_none() && next.first().is_some_and(u8::is_ascii_alphabetic));
    if is_comment { (numbers, next.is_none()) } else { (Vec::new(), false) }
}
