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
use super::text::{Line, Lines, NUMBER, Source, Words, integer, number, unquoted};

/// The fields of one line.
struct Row<'a> {
    line: Line<'a>,
    /// The line without its comment.
    text: &'a [u8],
    separator: u8,
    /// The fields without surrounding whitespace and quotes, at most as many as were requested.
    fields: Vec<&'a [u8]>,
    /// The number of fields up to the last nonempty one.
    filled: usize,
}

/// The result of [`scan`] for a line.
struct Scan<'a> {
    text: &'a [u8],
    separator: u8,
    quoted: bool,
}

/// A reader of one table.
struct Table<'a, 'o> {
    source: Source<'a>,
    options: &'o ReadOptions,
    header: Option<Header>,
    /// The line that gives the number of points before the first row, and that number.
    announced: Option<(Row<'a>, u64)>,
    /// The first line with more fields than the coordinates need.
    extra: Option<u64>,
}

/// Reads the points of a table.
pub(super) fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    if source.data.starts_with(b"\xff\xfe") || source.data.starts_with(b"\xfe\xff") {
        return Err(source.unsupported(Place::Line(1), "UTF-16 text", "save the file as UTF-8 or ASCII"));
    }
    if options.columns.is_none()
        && let Some(count) = chemistry(source)
    {
        return read_chemistry(source, options, count);
    }
    Table { source, options, header: None, announced: None, extra: None }.read()
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

impl<'a> Table<'a, '_> {
    fn read(mut self) -> Result<PointFile, InputError> {
        let mut reading: Option<(Collector<'a>, Selection)> = None;
        let mut width = usize::MAX;
        let mut row = Row::of(Line { number: 0, text: b"" }, width);
        for line in Lines::new(self.source.data) {
            row.split(line, width);
            if row.fields.is_empty() {
                continue;
            }
            let (points, selection) = match &mut reading {
                Some(reading) => (&mut reading.0, &mut reading.1),
                None if self.is_before_points(&row) => continue,
                None => {
                    let selection = self.select(&row)?;
                    let points = self.begin(&row, &selection)?;
                    width = selection.width() + 1;
                    let reading = reading.insert((points, selection));
                    (&mut reading.0, &mut reading.1)
                }
            };
            if let Some((_, count)) = self.announced
                && points.met == count
            {
                return Err(self.source.surplus(line.place(), "points", count));
            }
            self.note_extra(&row, selection)?;
            let at = points.met;
            push(self.source, points, selection, &row, self.options).map_err(|error| error.in_row(at))?;
        }
        match reading {
            Some((points, selection)) => self.finish(points, selection),
            None => self.without_rows(),
        }
    }

    /// Returns `true` and stores the row if it is a header row or a count.
    fn is_before_points(&mut self, row: &Row<'a>) -> bool {
        if self.header.is_none() && self.announced.is_none() && is_header(&row.fields) {
            self.header = Some(Header::of(row.line.number, &row.fields, row.separator == b' '));
            return true;
        }
        if self.header.is_some() || self.announced.is_some() || row.fields.len() > 1 {
            return false;
        }
        let count = integer(row.fields[0]).and_then(|n| u64::try_from(n).ok());
        self.announced = count.map(|n| (Row::of(row.line, 1), n));
        count.is_some()
    }

    /// Selects the columns from the header row, the options and the first row of numbers.
    fn select(&self, row: &Row<'a>) -> Result<Selection, InputError> {
        if let Some((count, _)) = &self.announced
            && row.filled < 2
        {
            let (path, place) = (self.source.path.to_owned(), count.line.place());
            return Err(InputError::UnsupportedDimension { path, place, found: 1 });
        }
        let is_text = row.fields.iter().all(|field| number(field).is_none());
        let lacks_names = self.header.as_ref().is_some_and(|header| header.axes().is_none());
        if is_text && lacks_names && self.options.columns.is_none() {
            return Err(self.source.bad_line(&row.line, "a row of numbers"));
        }
        let (place, header, has_count) = (row.line.place(), self.header.as_ref(), self.announced.is_some());
        let fields = &row.fields[..row.filled];
        Selection::of(self.source, place, header, fields, has_count, self.options).or_else(|error| {
            refuse_decimal_commas(self.source, row)?;
            Err(error)
        })
    }

    fn begin(&self, row: &Row<'_>, selection: &Selection) -> Result<Collector<'a>, InputError> {
        // An estimate: later rows are about as long as the first.
        let rows = self.source.data.len() / (row.line.text.len() + 1) + 1;
        let size = (rows as u64, self.source.data.len(), 4);
        let found = if selection.is_positional() { row.filled } else { selection.axes.len() };
        let points = Collector::new(self.source, self.options, (row.line.place(), found), size);
        let mut points = points.map_err(|error| error.in_row(0))?;
        points.notes.extend(selection.note.clone());
        Ok(points)
    }

    /// Records the first row with more fields than expected, and refuses it if its commas look like decimal commas.
    fn note_extra(&mut self, row: &Row<'a>, selection: &Selection) -> Result<(), InputError> {
        if self.extra.is_none() && row.filled > selection.expected {
            self.extra = Some(row.line.number);
            refuse_decimal_commas(self.source, row)?;
        }
        Ok(())
    }

    fn finish(self, mut points: Collector<'a>, selection: Selection) -> Result<PointFile, InputError> {
        if let Some((_, count)) = self.announced {
            points.complete(Place::Line(self.source.line_at(self.source.data.len())), count)?;
            points.notes.push("line 1 is taken as the number of points".to_owned());
        }
        let used = selection.axes.len();
        let used = if selection.is_positional() { used } else { selection.expected };
        if let Some(line) = self.extra
            && !(selection.is_positional() && self.options.keep_columns)
        {
            points.notes.push(format!("columns after the first {used} are ignored (from line {line} on)"));
        }
        let Kept { columns, notes } = selection.into_kept();
        points.notes.extend(notes);
        let mut file = points.finish();
        file.columns = columns;
        Ok(file)
    }

    /// Returns an empty set for an empty file. A file that contains only a count or a header row is an error.
    fn without_rows(self) -> Result<PointFile, InputError> {
        if let Some((row, _)) = &self.announced {
            let (path, place) = (self.source.path.to_owned(), row.line.place());
            return Err(InputError::UnsupportedDimension { path, place, found: 1 });
        }
        if let Some(header) = &self.header {
            if header.axes().is_some() {
                let (path, place) = (self.source.path.to_owned(), Place::Line(header.line));
                return Err(InputError::NoRows { path, place });
            }
            let line = Lines::new(self.source.data).nth(header.line as usize - 1);
            let line = line.unwrap_or(Line { number: header.line, text: b"" });
            return Err(self.source.bad_line(&line, "rows of numbers"));
        }
        let points = Collector::new(self.source, self.options, (Place::Whole, 3), (0, 0, 1))?;
        Ok(points.finish())
    }
}

/// Adds the point of a row, and the values of the columns that are kept.
fn push<'a>(
    source: Source<'a>,
    points: &mut Collector<'a>,
    selection: &mut Selection,
    row: &Row<'a>,
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
            return Err(source.bad_word(line, word, advised(row, dimension)));
        }
        points.push_words(line, &mut selection.axes[..dimension].iter().map(|&i| row.fields[i]))?;
    }
    if points.len() > before {
        selection.keep(&row.fields);
    }
    Ok(())
}

/// Returns the "expected" part of the error for a field of the first row that is not a number. If the row has enough
/// numbers, the text also suggests columns to choose.
fn advised(row: &Row<'_>, dimension: usize) -> String {
    let numbers = row.fields.iter().enumerate().filter(|(_, f)| number(f).is_some());
    let numbers: Vec<String> = numbers.map(|(i, _)| (i + 1).to_string()).collect();
    if numbers.len() < dimension {
        return NUMBER.to_owned();
    }
    format!(
        "{NUMBER}; choose the columns of the coordinates, such as --columns {}",
        numbers[..dimension].join(",")
    )
}

impl<'a> Row<'a> {
    /// Splits a line into at most `most` fields. An empty line has no fields.
    fn of(line: Line<'a>, most: usize) -> Self {
        let mut row = Row { line, text: b"", separator: b' ', fields: Vec::new(), filled: 0 };
        row.split(line, most);
        row
    }

    /// Replaces the row with the fields of another line.
    fn split(&mut self, line: Line<'a>, most: usize) {
        let Scan { text, separator, quoted } = scan(line.text);
        (self.line, self.text, self.separator) = (line, text, separator);
        let fields = &mut self.fields;
        fields.clear();
        self.filled = 0;
        if text.trim_ascii().is_empty() {
            return;
        }
        if quoted {
            fields.extend(Quoted { rest: Some(text), separator }.take(most));
        } else if separator == b' ' {
            fields.extend(Line { number: 0, text }.words().take(most));
        } else {
            fields.extend(text.split(|b| *b == separator).map(<[u8]>::trim_ascii).take(most));
        }
        self.filled = fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1);
    }
}

/// An iterator over the fields of a line with quoted fields. Separators within quotes belong to the field.
struct Quoted<'a> {
    /// `None` after the last field.
    rest: Option<&'a [u8]>,
    separator: u8,
}

impl<'a> Iterator for Quoted<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let mut rest = self.rest?;
        if self.separator == b' ' {
            rest = rest.trim_ascii_start();
            if rest.is_empty() {
                return None;
            }
        }
        let blanks = rest.len() - rest.trim_ascii_start().len();
        let closing =
            rest[blanks..].strip_prefix(b"\"").and_then(|inner| inner.iter().position(|b| *b == b'"'));
        let from = closing.map_or(0, |at| blanks + at + 2);
        let ends = |b: &u8| *b == self.separator || (self.separator == b' ' && b.is_ascii_whitespace());
        let end = rest[from..].iter().position(ends).map(|at| from + at);
        self.rest = end.map(|end| &rest[end + 1..]);
        Some(unquoted(rest[..end.unwrap_or(rest.len())].trim_ascii()))
    }
}

/// Finds where the content of a line ends, which separator it uses, and whether any field is quoted.
fn scan(text: &[u8]) -> Scan<'_> {
    let (mut semicolon, mut comma, mut fresh) = (false, false, true);
    let (mut quoted, mut inside) = (false, false);
    let mut end = text.len();
    for (i, byte) in text.iter().enumerate() {
        if inside {
            inside = *byte != b'"';
            fresh = false;
            continue;
        }
        match byte {
            b';' => semicolon = true,
            b',' => comma = true,
            b'"' if fresh && text[i + 1..].contains(&b'"') => (quoted, inside) = (true, true),
            b'#' | b'%' if fresh => end = i,
            b'/' if fresh && text.get(i + 1) == Some(&b'/') => end = i,
            _ => {}
        }
        if end < text.len() {
            break;
        }
        fresh = matches!(byte, b' ' | b'\t' | b',' | b';');
    }
    let separator = match (semicolon, comma) {
        (true, _) => b';',
        (false, true) => b',',
        (false, false) => b' ',
    };
    Scan { text: &text[..end], separator, quoted }
}

/// Refuses a row with spaces after some of its commas but not after all, such as `1,5, 2,5, 3,5`. It would otherwise
/// be read as six columns.
fn refuse_decimal_commas(source: Source<'_>, row: &Row<'_>) -> Result<(), InputError> {
    let text = row.text;
    let glued = text.windows(3).any(|w| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit());
    let loose = text.windows(2).any(|w| w[0] == b',' && w[1].is_ascii_whitespace());
    if row.separator == b',' && glued && loose && !text.contains(&b'.') {
        let expected = "one kind of separator and decimal points (these look like decimal commas)";
        return Err(source.bad_line(&row.line, expected));
    }
    Ok(())
}

/// Returns the number of atoms of a chemical file: a count, a comment, then rows of an element and three numbers.
///
/// If the second line has as many numbers as the third line has words, it is a point, and the file is a table
/// with a count.
fn chemistry(source: Source<'_>) -> Option<u64> {
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
