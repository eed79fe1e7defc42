//! Text tables of points: `.xyz`, `.txt`, `.csv`, standard input, and files that are recognised by their content.
//!
//! **Rows.** A line is a point. A line is split at semicolons if it has any, otherwise at commas if it has any,
//! otherwise at whitespace. A field may be quoted. A `#`, `%` or `//` at the start of a field begins a comment. Blank
//! lines are skipped.
//!
//! **Columns.** A header row selects the columns of the coordinates ([`super::header`]). Without one, the first three
//! columns are the coordinates, or the first two if there are only two. A table with more columns of numbers is refused.
//!
//! **Counts.** If the first line is a single integer, it is the number of points (`.pts`). In a chemical `.xyz` file,
//! a count and a comment line come first, and each further row has an element and three numbers.

use super::collect::Collector;
use super::error::{InputError, Place};
use super::header::{Header, Kept, Selection, is_header};
use super::points::{PointFile, ReadOptions};
use super::row::{Row, refuse_decimal_commas};
use super::text::{Line, Lines, NUMBER, Source, Words, integer, number};

/// The number of points that a line before the first row gives.
#[derive(Clone, Copy)]
pub(super) struct Announced {
    /// The line that gives the number.
    pub line: u64,
    /// The number.
    pub count: u64,
}

/// The lines of a table before its first row.
#[derive(Default)]
struct Before {
    header: Option<Header>,
    announced: Option<Announced>,
}

/// The first row of a table, and the columns that this row and the lines before it select.
#[derive(Clone)]
pub(super) struct Head {
    selection: Selection,
    pub announced: Option<Announced>,
    /// The line number of the first row.
    pub line: u64,
    /// The number of bytes of its line.
    length: usize,
    /// The number of its fields that can be coordinates.
    found: usize,
}

/// The first row with more fields than the coordinates need.
#[derive(Clone, Copy)]
pub(super) enum Extra {
    /// The rows so far have no more fields.
    Sought,
    /// The line number of this row, which was found while reading.
    Met(u64),
    /// The line number of this row in the whole file, if there is one.
    Known(Option<u64>),
}

/// The rows of a part of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct RowCount {
    /// The number of rows.
    pub rows: u64,
    /// The line number of the first row with more fields than the coordinates need.
    pub extra: Option<u64>,
}

/// The result of reading the first bytes of a table.
pub(super) enum Opening {
    /// The first row, the offset of its line, and the number of lines before it.
    Rows(Box<Head>, usize, u64),
    /// There is no row in these bytes.
    NoRow,
    /// A chemical file.
    Chemistry,
}

/// Reads the points of a table.
pub(super) fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    refuse_utf16(source)?;
    if let Some(count) = chemistry(source, options) {
        return read_chemistry(source, options, count);
    }
    let (mut lines, mut before) = (Lines::new(source.data), Before::default());
    match before.first_row(source, options, &mut lines)? {
        Some(mut head) => head.read(source, options, lines),
        None => before.without_rows(source, options),
    }
}

/// Finds the first row of a table in its first bytes, which end at the end of a line.
pub(super) fn opening(source: Source<'_>, options: &ReadOptions) -> Result<Opening, InputError> {
    refuse_utf16(source)?;
    if chemistry(source, options).is_some() {
        return Ok(Opening::Chemistry);
    }
    let mut lines = Lines::new(source.data);
    let head = Before::default().first_row(source, options, &mut lines)?;
    let at = source.data.len() - lines.rest().len();
    Ok(head.map_or(Opening::NoRow, |head| Opening::Rows(Box::new(head), at, lines.number())))
}

fn refuse_utf16(source: Source<'_>) -> Result<(), InputError> {
    if source.data.starts_with(b"\xff\xfe") || source.data.starts_with(b"\xfe\xff") {
        return Err(source.unsupported(Place::Line(1), "UTF-16 text", "save the file as UTF-8 or ASCII"));
    }
    Ok(())
}

/// Returns `true` if the bytes are text without control characters, and the text is empty or has two numbers in one of
/// its first lines.
pub(super) fn is_table(data: &[u8]) -> bool {
    const LINES: usize = 50;
    let head = &data[..data.len().min(4096)];
    let is_text = head.iter().all(|b| *b >= 0x20 || matches!(b, b'\t' | b'\n' | b'\r' | 0x0b | 0x0c));
    let has_numbers =
        |line| Row::of(line, 16).fields.iter().filter(|field| number(field).is_some()).count() >= 2;
    is_text && (data.trim_ascii().is_empty() || Lines::new(data).take(LINES).any(has_numbers))
}

/// Returns `true` if the first line with data is a row of points: two or more numbers, and one of them is not an
/// integer. Headers of other formats have only integers.
pub(super) fn is_of_points(data: &[u8]) -> bool {
    let Some(first) = Lines::new(data).next_data() else { return false };
    let fields = Row::of(first, 16).fields;
    fields.len() >= 2
        && fields.iter().all(|field| number(field).is_some())
        && fields.iter().any(|field| integer(field).is_none())
}

impl Before {
    /// Finds the first row. The next line of `lines` is then this row.
    fn first_row<'a>(
        &mut self,
        source: Source<'a>,
        options: &ReadOptions,
        lines: &mut Lines<'a>,
    ) -> Result<Option<Head>, InputError> {
        let mut row = Row::of(Line { number: 0, text: b"" }, usize::MAX);
        loop {
            let rest = lines.clone();
            let Some(line) = lines.next() else { return Ok(None) };
            row.split(line, usize::MAX);
            if row.fields.is_empty() || self.takes(&row) {
                continue;
            }
            *lines = rest;
            let selection = self.select(source, options, &row)?;
            let found = if selection.is_positional() { row.filled } else { selection.axes.len() };
            let (announced, length) = (self.announced, line.text.len());
            return Ok(Some(Head { selection, announced, line: line.number, length, found }));
        }
    }

    /// Returns `true` and stores the row if it is a header row or a count.
    fn takes(&mut self, row: &Row<'_>) -> bool {
        if self.header.is_none() && self.announced.is_none() && is_header(&row.fields) {
            self.header = Some(Header::of(row.line.number, &row.fields, row.separator == b' '));
            return true;
        }
        if self.header.is_some() || self.announced.is_some() || row.fields.len() > 1 {
            return false;
        }
        let count = integer(row.fields[0]).and_then(|n| u64::try_from(n).ok());
        self.announced = count.map(|count| Announced { line: row.line.number, count });
        count.is_some()
    }

    /// Selects the columns from the header row, the options and the first row of numbers.
    fn select(
        &self,
        source: Source<'_>,
        options: &ReadOptions,
        row: &Row<'_>,
    ) -> Result<Selection, InputError> {
        if let Some(count) = &self.announced
            && row.filled < 2
        {
            let (path, place) = (source.path.to_owned(), Place::Line(count.line));
            return Err(InputError::UnsupportedDimension { path, place, found: 1 });
        }
        let is_text = row.fields.iter().all(|field| number(field).is_none());
        let lacks_names = self.header.as_ref().is_some_and(|header| header.axes().is_none());
        if is_text && lacks_names && options.columns.is_none() {
            return Err(source.bad_line(&row.line, "a row of numbers"));
        }
        let (place, header, has_count) = (row.line.place(), self.header.as_ref(), self.announced.is_some());
        let fields = &row.fields[..row.filled];
        Selection::of(source, place, header, fields, has_count, options).or_else(|error| {
            refuse_decimal_commas(source, row)?;
            Err(error)
        })
    }

    /// Returns an empty set for an empty file. A file that contains only a count or a header row is an error.
    fn without_rows(self, source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
        if let Some(count) = &self.announced {
            let (path, place) = (source.path.to_owned(), Place::Line(count.line));
            return Err(InputError::UnsupportedDimension { path, place, found: 1 });
        }
        if let Some(header) = &self.header {
            if header.axes().is_some() {
                let (path, place) = (source.path.to_owned(), Place::Line(header.line));
                return Err(InputError::NoRows { path, place });
            }
            let line = Lines::new(source.data).nth(header.line as usize - 1);
            let line = line.unwrap_or(Line { number: header.line, text: b"" });
            return Err(source.bad_line(&line, "rows of numbers"));
        }
        let points = Collector::new(source, options, (Place::Whole, 3), (0, 0, 1))?;
        Ok(points.finish())
    }
}

impl Head {
    /// Reads all rows of a file. The first of the lines is the first row.
    fn read(
        &mut self,
        source: Source<'_>,
        options: &ReadOptions,
        mut lines: Lines<'_>,
    ) -> Result<PointFile, InputError> {
        // An estimate: later rows are about as long as the first.
        let rows = source.data.len() / (self.length + 1) + 1;
        let mut points = self.collector(source, options, (rows as u64, source.data.len(), 4))?;
        let mut extra = Extra::Sought;
        self.rows(source, options, &mut lines, &mut points, &mut extra)?;
        if let Some(Announced { count, .. }) = self.announced {
            points.complete(Place::Line(source.line_at(source.data.len())), count)?;
        }
        points.notes.extend(self.notes(extra.line(), options));
        let Kept { columns, notes } = self.selection.take_kept();
        points.notes.extend(notes);
        let mut file = points.finish();
        file.columns = columns;
        Ok(file)
    }

    /// Creates a collector of the points. `size` is as in [`Collector::new`].
    pub fn collector<'a>(
        &self,
        source: Source<'a>,
        options: &ReadOptions,
        size: (u64, usize, usize),
    ) -> Result<Collector<'a>, InputError> {
        Collector::new(source, options, (Place::Line(self.line), self.found), size)
            .map_err(|error| error.in_row(0))
    }

    /// Adds the points of lines, which begin at the first row or after it.
    pub fn rows(
        &mut self,
        source: Source<'_>,
        options: &ReadOptions,
        lines: &mut Lines<'_>,
        points: &mut Collector<'_>,
        extra: &mut Extra,
    ) -> Result<(), InputError> {
        let width = self.selection.width() + 1;
        let mut row = Row::of(Line { number: 0, text: b"" }, width);
        for line in lines {
            row.split(line, if line.number == self.line { usize::MAX } else { width });
            if row.fields.is_empty() {
                continue;
            }
            if let Some(Announced { count, .. }) = self.announced
                && points.met == count
            {
                return Err(source.surplus(line.place(), "points", count));
            }
            if extra.is_at(&row, &self.selection) {
                refuse_decimal_commas(source, &row)?;
            }
            let at = points.met;
            push(source, points, &mut self.selection, &row, options).map_err(|error| error.in_row(at))?;
        }
        Ok(())
    }

    /// Counts the rows of lines, which begin at the first row or after it. If `has_extra`, an earlier row has more fields
    /// than the coordinates need.
    pub fn count(&self, lines: &mut Lines<'_>, has_extra: bool) -> RowCount {
        let width = self.selection.width() + 1;
        let mut row = Row::of(Line { number: 0, text: b"" }, 1);
        let (mut rows, mut extra) = (0, Extra::Sought);
        if has_extra {
            extra = Extra::Known(None);
        }
        for line in lines {
            let is_sought = matches!(extra, Extra::Sought);
            let most = if line.number == self.line { usize::MAX } else { width };
            row.split(line, if is_sought { most } else { 1 });
            if row.fields.is_empty() {
                continue;
            }
            rows += 1;
            extra.is_at(&row, &self.selection);
        }
        RowCount { rows, extra: extra.line() }
    }

    /// Returns the notes on the table. `extra` is the line of the first row with more fields than the coordinates need.
    pub fn notes(&self, extra: Option<u64>, options: &ReadOptions) -> Vec<String> {
        let mut notes: Vec<String> = self.selection.note.iter().cloned().collect();
        if self.announced.is_some() {
            notes.push("line 1 is taken as the number of points".to_owned());
        }
        let is_positional = self.selection.is_positional();
        let used = if is_positional { self.selection.axes.len() } else { self.selection.expected };
        if let Some(line) = extra
            && !(is_positional && options.keep_columns)
        {
            notes.push(format!("columns after the first {used} are ignored (from line {line} on)"));
        }
        notes
    }
}

impl Extra {
    /// Returns `true` if this is the first row with more fields than expected.
    fn is_at(&mut self, row: &Row<'_>, selection: &Selection) -> bool {
        match *self {
            Extra::Sought if row.filled > selection.expected => {
                *self = Extra::Met(row.line.number);
                true
            }
            Extra::Known(line) => line == Some(row.line.number),
            _ => false,
        }
    }

    fn line(self) -> Option<u64> {
        match self {
            Extra::Sought => None,
            Extra::Met(line) => Some(line),
            Extra::Known(line) => line,
        }
    }
}

/// Adds the point of a row, and the values of the columns that are kept.
fn push(
    source: Source<'_>,
    points: &mut Collector<'_>,
    selection: &mut Selection,
    row: &Row<'_>,
    options: &ReadOptions,
) -> Result<(), InputError> {
    let before = points.len();
    let (line, dimension) = (&row.line, points.dimension());
    let found = row.filled;
    let is_positional = selection.is_positional();
    let has_other_width = options.dimension.is_none() && found.min(3) != dimension;
    let last = selection.axes[..dimension].iter().copied().max().unwrap_or(0);
    if found <= last {
        // If the last required field is empty, its number is missing. If there is no such field, the row is
        // too short.
        match row.fields.get(last) {
            Some(empty) => points.malformed(line, empty)?,
            None if is_positional => return Err(points.mixed(line.place(), found)),
            None => return Err(source.bad_line(line, format!("at least {} columns", last + 1))),
        }
    } else if is_positional && has_other_width {
        return Err(points.mixed(line.place(), found));
    } else {
        // The advice on columns helps only in the first row.
        let is_first = is_positional && points.met == 0 && !options.skip_invalid;
        let mut first = row.fields.iter().take(if is_first { dimension } else { 0 });
        if let Some(word) = first.find(|field| number(field).is_none()) {
            return Err(source.bad_word(line, word, NUMBER).with_columns(numbers(row, dimension)));
        }
        points.push_words(line, &mut selection.axes[..dimension].iter().map(|&i| row.fields[i]))?;
    }
    if points.len() > before {
        selection.keep(&row.fields);
    }
    Ok(())
}

/// Returns the first columns of a row that are numbers, if the row has enough of them.
fn numbers(row: &Row<'_>, dimension: usize) -> Option<String> {
    let numbers = row.fields.iter().enumerate().filter(|(_, f)| number(f).is_some());
    let numbers: Vec<String> = numbers.map(|(i, _)| (i + 1).to_string()).collect();
    Some(numbers.get(..dimension)?.join(","))
}

/// Returns the number of atoms of a chemical file: a count, a comment, then rows of an element and three numbers.
///
/// If the second line has as many numbers as the third line has words, it is a point, and the file is a table
/// with a count. A file with chosen columns is a table.
fn chemistry(source: Source<'_>, options: &ReadOptions) -> Option<u64> {
    if options.columns.is_some() {
        return None;
    }
    let mut lines = Lines::new(source.data);
    let mut words = lines.next()?.words();
    let count = integer(words.next()?).and_then(|n| u64::try_from(n).ok())?;
    if words.next().is_some() {
        return None;
    }
    let comment = lines.next();
    match lines.find(|line| line.words().next().is_some()) {
        Some(atom) => {
            let width = atom.words().count();
            let is_point = comment.is_some_and(|line| {
                line.words().count() == width && line.words().all(|word| number(word).is_some())
            });
            let is_atom = width >= 4 && coordinates(&atom).all(|w| number(w).is_some());
            (is_atom && !is_point).then_some(count)
        }
        None => (count == 0).then_some(0),
    }
}

fn coordinates<'a>(atom: &Line<'a>) -> std::iter::Take<std::iter::Skip<Words<'a>>> {
    atom.words().skip(1).take(3)
}

fn read_chemistry(source: Source<'_>, options: &ReadOptions, count: u64) -> Result<PointFile, InputError> {
    let size = (count, source.data.len(), 8);
    let mut points = Collector::new(source, options, (Place::Line(1), 3), size)?;
    let mut lines = Lines::new(source.data);
    for line in lines.by_ref().skip(2).filter(|line| line.words().next().is_some()) {
        if points.met == count {
            return Err(source.surplus(line.place(), "atoms", count));
        }
        points.push_words(&line, &mut coordinates(&line))?;
    }
    if points.met < count {
        return Err(source.truncated(Place::Line(lines.number()), "atoms", count, points.met));
    }
    let note = "read as a chemical file: a count, a comment, then one atom per line; elements are ignored";
    points.notes.push(note.to_owned());
    Ok(points.finish())
}
