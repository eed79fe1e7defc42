//! Columns of numbers: `.xyz`, `.txt`, `.csv`, standard input.

use super::collect::Collector;
use super::error::{InputError, Place};
use super::points::{PointFile, ReadOptions};
use super::text::{Line, Lines, Source, Words, integer, number};

/// The first fields of a row.
struct Row<'a> {
    fields: [&'a [u8]; 3],
    /// Fields, as far as counted (4 stands for more than 3).
    count: usize,
    /// The same without empty ones at the end.
    filled: usize,
}

/// Reads rows of two or three numbers.
pub(super) fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    if source.data.starts_with(b"\xff\xfe") || source.data.starts_with(b"\xfe\xff") {
        return Err(source.unsupported(Place::Line(1), "UTF-16 text", "save the file as UTF-8 or ASCII"));
    }
    if let Some(count) = chemistry(source) {
        return read_chemistry(source, options, count);
    }
    let mut points: Option<Collector<'_>> = None;
    let mut header = None;
    let mut extra = None;
    for line in Lines::new(source.data) {
        let (text, separator) = scan(line.text);
        if text.trim_ascii().is_empty() {
            continue;
        }
        let row = split(text, separator);
        if points.is_none() && header.is_none() && is_header(&row) {
            header = Some(line.number);
            continue;
        }
        let points = match &mut points {
            Some(points) => points,
            None => points.insert(begin(source, options, &line, &row)?),
        };
        let dimension = points.dimension();
        if row.filled > dimension && extra.is_none() {
            extra = Some(line.number);
            refuse_decimal_commas(source, &line, text, separator)?;
        }
        push(points, options, &line, &row)?;
    }
    let mut points = match points {
        Some(points) => points,
        None => Collector::new(source, options, (Place::Whole, 3), (0, 0, 1))?,
    };
    if let Some(line) = header {
        points.notes.push(format!("line {line} is taken as a header row"));
    }
    if let Some(line) = extra {
        let used = points.dimension();
        points.notes.push(format!("columns after the first {used} are ignored (from line {line} on)"));
    }
    Ok(points.finish())
}

/// The collector, its dimension told by the first row.
fn begin<'a>(
    source: Source<'a>,
    options: &ReadOptions,
    line: &Line<'_>,
    row: &Row<'_>,
) -> Result<Collector<'a>, InputError> {
    // A guess: the rows after the first are about as long.
    let announced = source.data.len() / (line.text.len() + 1) + 1;
    let size = (announced as u64, source.data.len(), 4);
    Collector::new(source, options, (line.place(), row.filled), size)
}

fn push(
    points: &mut Collector<'_>,
    options: &ReadOptions,
    line: &Line<'_>,
    row: &Row<'_>,
) -> Result<(), InputError> {
    let dimension = points.dimension();
    if row.filled < dimension {
        // An empty field at the end is a missing number, a missing field is another kind of row.
        return match row.fields[..row.count.min(3)].get(dimension - 1) {
            Some(empty) => points.malformed(line, empty),
            None => Err(points.mixed(line.place(), row.filled)),
        };
    }
    if options.dimension.is_none() && row.filled.min(3) != dimension {
        return Err(points.mixed(line.place(), row.filled));
    }
    points.push_words(line, &mut row.fields.into_iter())
}

/// The line up to a comment, and what separates its fields: a semicolon, a comma, or blanks.
fn scan(text: &[u8]) -> (&[u8], u8) {
    let (mut semicolon, mut comma, mut fresh) = (false, false, true);
    for (i, byte) in text.iter().enumerate() {
        match byte {
            b';' => semicolon = true,
            b',' => comma = true,
            b'#' | b'%' if fresh => return (&text[..i], separator(semicolon, comma)),
            b'/' if fresh && text.get(i + 1) == Some(&b'/') => {
                return (&text[..i], separator(semicolon, comma));
            }
            _ => {}
        }
        fresh = matches!(byte, b' ' | b'\t' | b',' | b';');
    }
    (text, separator(semicolon, comma))
}

fn separator(semicolon: bool, comma: bool) -> u8 {
    match (semicolon, comma) {
        (true, _) => b';',
        (false, true) => b',',
        (false, false) => b' ',
    }
}

fn split(text: &[u8], separator: u8) -> Row<'_> {
    let mut row = Row { fields: [&text[text.len()..]; 3], count: 0, filled: 0 };
    if separator == b' ' {
        row.fill(Line { number: 0, text }.words());
    } else {
        row.fill(text.split(|b| *b == separator).map(<[u8]>::trim_ascii));
    }
    row
}

impl<'a> Row<'a> {
    fn fill(&mut self, fields: impl Iterator<Item = &'a [u8]>) {
        for (i, field) in fields.take(4).enumerate() {
            if let Some(slot) = self.fields.get_mut(i) {
                *slot = field;
            }
            self.count = i + 1;
            if !field.is_empty() {
                self.filled = i + 1;
            }
        }
    }
}

/// Names and not numbers: no field is a number, and the first begins as a name does (so that a
/// damaged number in the first row is not mistaken for a header).
fn is_header(row: &Row<'_>) -> bool {
    let fields = &row.fields[..row.count.min(3)];
    let named = |field: &[u8]| {
        field.first().is_some_and(|b| b.is_ascii_alphabetic() || matches!(b, b'"' | b'_' | b'\''))
    };
    fields.first().is_some_and(|field| named(field)) && fields.iter().all(|field| number(field).is_none())
}

/// A row such as `1,5, 2,5, 3,5` would pass as six columns: refuse commas of two kinds.
fn refuse_decimal_commas(
    source: Source<'_>,
    line: &Line<'_>,
    text: &[u8],
    separator: u8,
) -> Result<(), InputError> {
    let glued = text.windows(3).any(|w| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit());
    let loose = text.windows(2).any(|w| w[0] == b',' && w[1].is_ascii_whitespace());
    if separator == b',' && glued && loose && !text.contains(&b'.') {
        return Err(source
            .bad_line(line, "one kind of separator and decimal points (these look like decimal commas)"));
    }
    Ok(())
}

/// The atom count of a chemist's file: a count, a comment, then rows of an element and three numbers.
fn chemistry(source: Source<'_>) -> Option<u64> {
    let mut lines = Lines::new(source.data);
    let mut words = lines.next()?.words();
    let count = integer(words.next()?).and_then(|n| u64::try_from(n).ok())?;
    if words.next().is_some() {
        return None;
    }
    let _comment = lines.next();
    match lines.find(|line| line.words().next().is_some()) {
        Some(atom) => {
            (atom.words().count() >= 4 && coordinates(&atom).all(|w| number(w).is_some())).then_some(count)
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
    points.notes.push(
        "read as a chemistry file: a count, a comment, then one atom a line; elements are ignored".to_owned(),
    );
    Ok(points.finish())
}
