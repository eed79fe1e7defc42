//! The fields of a line of a text table.

use super::error::InputError;
use super::text::{Line, Source, is_blank, number, unquoted};

/// The fields of one line.
pub(super) struct Row<'a> {
    /// The line.
    pub line: Line<'a>,
    /// The line without its comment.
    text: &'a [u8],
    /// The separator of the fields.
    pub separator: u8,
    /// The fields without surrounding whitespace and quotes, at most as many as were requested unless the last of them is
    /// empty.
    pub fields: Vec<&'a [u8]>,
    /// The number of fields up to the last nonempty one.
    pub filled: usize,
    style: Style,
}

/// How the rows of a table are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Style {
    /// Whether only tabs separate fields.
    pub tabs: bool,
    /// Whether numbers have decimal commas, which only tables with semicolons may have.
    pub commas: bool,
}

/// The result of [`scan`] for a line.
#[derive(Clone, Copy)]
struct Scan<'a> {
    text: &'a [u8],
    separator: u8,
    quoted: bool,
}

/// The marks that begin comments, at the start of a field.
const MARKS: [&[u8]; 3] = [b"#", b"%", b"//"];

impl<'a> Row<'a> {
    /// Splits a line into at most `most` fields. An empty line has no fields.
    pub fn of(line: Line<'a>, most: usize) -> Self {
        let mut row = Row::empty(Style::default());
        row.split(line, most);
        row
    }

    /// Creates a row without fields. Lines that follow have this style.
    pub fn empty(style: Style) -> Self {
        let line = Line { number: 0, text: b"" };
        Row { line, text: b"", separator: b' ', fields: Vec::new(), filled: 0, style }
    }

    /// Splits a whole line of this style.
    pub fn styled(line: Line<'a>, style: Style) -> Self {
        let mut row = Row::empty(style);
        row.split(line, usize::MAX);
        row
    }

    /// Replaces the row with the fields of another line.
    pub fn split(&mut self, line: Line<'a>, most: usize) {
        let scanned = scan(line.text, self.style.tabs, true);
        self.take(line, scanned, most);
    }

    /// Replaces the row with the fields of a comment line, if its mark is glued to a first field and `is_row` holds for the
    /// fields. Such a mark belongs to the field: `#7 0.5 0.9`.
    pub fn takes_mark(&mut self, line: Line<'a>, is_row: impl Fn(&Self) -> bool) -> bool {
        let is_glued = comment(line).is_some_and(|rest| rest.text.first().is_some_and(|b| !is_blank(*b)));
        if !is_glued {
            return false;
        }
        let scanned = scan(line.text, self.style.tabs, false);
        self.take(line, scanned, usize::MAX);
        let takes = is_row(self);
        if !takes {
            self.fields.clear();
        }
        takes
    }

    #[inline]
    fn take(&mut self, line: Line<'a>, scanned: Scan<'a>, most: usize) {
        (self.line, self.text, self.separator) = (line, scanned.text, scanned.separator);
        self.fields.clear();
        self.filled = 0;
        if scanned.text.trim_ascii().is_empty() {
            return;
        }
        scanned.fields(most, &mut self.fields);
        // A nonempty field may follow an empty one.
        if self.fields.len() == most && self.fields.last().is_some_and(|field| field.is_empty()) {
            self.fields.clear();
            scanned.fields(usize::MAX, &mut self.fields);
        }
        self.filled = self.fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1);
    }

    /// Returns the style of the row.
    pub fn style(&self) -> Style {
        self.style
    }

    /// Parses a number of this style.
    pub fn number(&self, field: &[u8]) -> Option<f64> {
        if self.style.commas { comma_number(field) } else { number(field) }
    }

    /// Returns the number of fields that are numbers.
    pub fn numbers(&self) -> usize {
        self.fields.iter().filter(|field| self.number(field).is_some()).count()
    }
}

impl<'a> Scan<'a> {
    /// Adds at most `most` fields of the line.
    #[inline]
    fn fields(self, most: usize, fields: &mut Vec<&'a [u8]>) {
        let Scan { text, separator, quoted } = self;
        if quoted {
            fields.extend(Quoted { rest: Some(text), separator }.take(most));
        } else if separator == b' ' {
            fields.extend(Line { number: 0, text }.words().take(most));
        } else {
            fields.extend(text.split(|b| *b == separator).map(<[u8]>::trim_ascii).take(most));
        }
    }
}

/// Whether the numbers of these rows have decimal commas: the fields are between semicolons, and some have a comma but
/// none has a point.
pub(super) fn has_decimal_commas(rows: &[Row<'_>]) -> bool {
    let fields = || rows.iter().flat_map(|row| &row.fields);
    let is_plain = |field: &[u8]| number(field).is_some() && field.contains(&b'.');
    rows.iter().all(|row| row.separator == b';')
        && fields().any(|field| field.contains(&b',') && comma_number(field).is_some())
        && !fields().any(|field| is_plain(field))
}

/// Parses a number with a decimal comma, or without one. A number with a point is refused.
fn comma_number(field: &[u8]) -> Option<f64> {
    if field.contains(&b'.') {
        return None;
    }
    let point = |b: &u8| if *b == b',' { b'.' } else { *b };
    number(&field.iter().map(point).collect::<Vec<u8>>())
}

/// Returns the text of a comment line without its mark, or `None` if the line is no comment.
pub(super) fn comment(line: Line<'_>) -> Option<Line<'_>> {
    let text = line.text.trim_ascii_start();
    let mark = MARKS.iter().find(|mark| text.starts_with(mark))?;
    let text = &text[mark.len()..];
    let more = text.iter().take_while(|b| matches!(b, b'#' | b'%' | b'/')).count();
    Some(Line { number: line.number, text: &text[more..] })
}

/// Whether only tabs separate the fields of a table with this first row. A field of several numbers, or an empty first
/// field of a table without a header, shows that tabs are only blanks.
pub(super) fn is_tabbed(line: Line<'_>, has_header: bool) -> bool {
    if !line.text.contains(&b'\t') {
        return false;
    }
    let row = Row::styled(line, Style { tabs: true, commas: false });
    let is_several = |field: &&[u8]| {
        let words = || Line { number: 0, text: field }.words();
        words().nth(1).is_some() && words().all(|word| number(word).is_some())
    };
    let is_indented = !has_header && row.fields.first().is_some_and(|field| field.is_empty());
    let other = scan(line.text, false, true).separator;
    !row.fields.iter().any(is_several) && !is_indented && (other == b' ' || row.numbers() > 1)
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
#[inline]
fn scan(text: &[u8], tabs: bool, has_comments: bool) -> Scan<'_> {
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
            b'#' | b'%' if fresh && has_comments => end = i,
            b'/' if fresh && has_comments && text.get(i + 1) == Some(&b'/') => end = i,
            _ => {}
        }
        if end < text.len() {
            break;
        }
        fresh = matches!(byte, b' ' | b'\t' | b',' | b';');
    }
    let separator = match (semicolon, comma) {
        _ if tabs => b'\t',
        (true, _) => b';',
        (false, true) => b',',
        (false, false) => b' ',
    };
    Scan { text: &text[..end], separator, quoted }
}

/// Refuses a row with spaces after some of its commas but not after all, such as `1,5, 2,5, 3,5`. It would otherwise
/// be read as six columns.
pub(super) fn refuse_decimal_commas(source: Source<'_>, row: &Row<'_>) -> Result<(), InputError> {
    let text = row.text;
    let glued = text.windows(3).any(|w| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit());
    let loose = text.windows(2).any(|w| w[0] == b',' && w[1].is_ascii_whitespace());
    if row.separator == b',' && glued && loose && !text.contains(&b'.') {
        let expected = "one kind of separator and decimal points (these look like decimal commas)";
        return Err(source.bad_line(&row.line, expected));
    }
    Ok(())
}
