//! The fields of a line of a text table.

use super::error::InputError;
use super::text::{Line, Source, unquoted};

/// The fields of one line.
pub(super) struct Row<'a> {
    /// The line.
    pub line: Line<'a>,
    /// The line without its comment.
    text: &'a [u8],
    /// The separator of the fields.
    pub separator: u8,
    /// The fields without surrounding whitespace and quotes, at most as many as were requested.
    pub fields: Vec<&'a [u8]>,
    /// The number of fields up to the last nonempty one.
    pub filled: usize,
}

/// The result of [`scan`] for a line.
struct Scan<'a> {
    text: &'a [u8],
    separator: u8,
    quoted: bool,
}

impl<'a> Row<'a> {
    /// Splits a line into at most `most` fields. An empty line has no fields.
    pub fn of(line: Line<'a>, most: usize) -> Self {
        let mut row = Row { line, text: b"", separator: b' ', fields: Vec::new(), filled: 0 };
        row.split(line, most);
        row
    }

    /// Replaces the row with the fields of another line.
    pub fn split(&mut self, line: Line<'a>, most: usize) {
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
