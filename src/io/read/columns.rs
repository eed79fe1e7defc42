//! Text tables of points: `.xyz`, `.txt`, `.csv`, standard input, and files that are recognised by their content.
//!
//! **Rows.** A line is a point. If the first row has tabs, lines are split at tabs only. Otherwise a line is split at
//! semicolons if it has any, otherwise at commas if it has any, otherwise at whitespace. A field may be quoted. A `#`, `%`
//! or `//` at the start of a field begins a comment. Blank lines are skipped. Between semicolons, numbers may have
//! decimal commas.
//!
//! **Width.** Every row has as many fields as the header, or the first row. A row with more fields is refused, and so is a row
//! with fewer fields between blanks. Between other separators, a row may lack its last fields.
//!
//! **Columns.** A header row selects the columns of the coordinates ([`super::header`]). Without one, the first three
//! columns are the coordinates, or the first two if there are only two. A table with more columns of numbers is refused, and
//! so is one whose first column counts the rows. A column of weights is no coordinate: these rules concern the other columns.
//!
//! **Counts.** The number of points may come first ([`super::before`]), as in `.pts`. Chemical files are read by
//! [`super::chemistry`].

use super::before::{Before, Doubt};
use super::chemistry::Chemistry;
use super::collect::Collector;
use super::error::{InputError, Place};
use super::foreign;
use super::head::Head;
use super::points::{PointFile, ReadOptions};
use super::row::Row;
use super::text::{Lines, Source, integer, number};

/// The result of reading the first bytes of a table.
pub(super) enum Opening {
    /// The first row, the offset of its line, and the number of lines before it.
    Rows(Box<Head>, usize, u64),
    /// There is no row in these bytes, or too few to decide.
    NoRow,
    /// The whole file is needed: it is a chemical file, or its first line is a count if the number of rows agrees.
    Whole,
}

/// Reads the points of a table.
pub(super) fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    if options.terrain && foreign::is_grid(source.data) {
        return foreign::read_grid(source, options);
    }
    refuse(source)?;
    if let Some(file) = Chemistry::of(source, options) {
        return file.read(source, options);
    }
    let (mut lines, mut before) = (Lines::new(source.data), Before::new(source, options));
    if let Doubt::IfRows(count) = before.counts(source.data.len() as u64) {
        before.take_if_rows(count);
    }
    if let Some(mut head) = before.first_row(&mut lines, true)? {
        return head.read(source, options, lines);
    }
    let other = before.without_rows()?;
    let file =
        Collector::new(source, options, (Place::Whole, options.dimension.unwrap_or(3).max(3)), (0, 0, 1))?;
    let mut file = file.finish();
    file.reading.lines = other;
    Ok(file)
}

/// Finds the first row of a table in its first bytes, which end at the end of a line. The file has `size` bytes.
pub(super) fn opening(source: Source<'_>, options: &ReadOptions, size: u64) -> Result<Opening, InputError> {
    if options.terrain && foreign::is_grid(source.data) {
        return Ok(Opening::Whole);
    }
    refuse(source)?;
    if Chemistry::of(source, options).is_some() {
        return Ok(Opening::Whole);
    }
    let (mut lines, mut before) = (Lines::new(source.data), Before::new(source, options));
    if matches!(before.counts(size), Doubt::IfRows(_)) {
        return Ok(Opening::Whole);
    }
    let head = before.first_row(&mut lines, source.data.len() as u64 == size)?;
    let at = source.data.len() - lines.rest().len();
    Ok(head.map_or(Opening::NoRow, |head| Opening::Rows(Box::new(head), at, lines.number())))
}

/// Refuses a text in another format than a table.
fn refuse(source: Source<'_>) -> Result<(), InputError> {
    if source.data.starts_with(b"\xff\xfe") || source.data.starts_with(b"\xfe\xff") {
        let what = "UTF-16 text with damaged characters";
        return Err(source.unsupported(Place::Line(1), what, "save the file as UTF-8 or ASCII"));
    }
    foreign::refuse(source)
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
