//! The header row of a text table, and the selection of the columns that hold the coordinates.
//!
//! **Selection.** Names are compared without regard to case, quotes or units in brackets. The first rule that applies
//! selects the columns:
//! 1. `--columns` gives two or three columns by name or by 1-based number.
//! 2. The header row names `x`, `y` and `z`, or `x` and `y` alone.
//! 3. The header row contains neither `x`, `y` or `z` nor the name of an id column, and the first row has exactly as
//!    many numbers as the dimension. The columns with numbers are used in order, and a note says so. An unnamed first
//!    column is treated as an index and not counted.
//! 4. If there is no header row and no more than three numbers in the first row, the first columns are used. The first
//!    columns are also used if the options give the dimension, or if the file begins with the number of its points,
//!    because further columns of such files hold intensities and colours.
//!
//! Otherwise the columns are ambiguous, and the reader returns an error that lists the names.

use super::error::{InputError, Place};
use super::points::{Column, ReadOptions};
use super::text::{Source, excerpt, number, unquoted};

/// Names of columns that hold point ids.
const IDS: [&str; 8] = ["id", "ids", "index", "idx", "nr", "no", "number", "label"];

/// The names of the columns of a table.
pub(super) struct Header {
    /// The 1-based line number.
    pub line: u64,
    /// The names as written, without quotes.
    names: Vec<String>,
}

/// Returns `true` if the row is a header: none of its first fields is a number, and the first one begins with a letter,
/// quote or underscore. A damaged number in the first row is therefore not mistaken for a name.
pub(super) fn is_header(fields: &[&[u8]]) -> bool {
    let begins_as_name = |b: &u8| b.is_ascii_alphabetic() || *b >= 0x80 || matches!(b, b'"' | b'_' | b'\'');
    let first = fields.iter().find(|field| !field.is_empty());
    first.is_some_and(|field| field.first().is_some_and(begins_as_name))
        && fields.iter().take(3).all(|field| number(field).is_none())
}

impl Header {
    /// Creates a header from the fields of its row. If the fields are separated by whitespace, a unit in brackets
    /// forms a separate field and is omitted.
    pub fn of(line: u64, fields: &[&[u8]], separated_by_blanks: bool) -> Self {
        let is_unit = |f: &&&[u8]| separated_by_blanks && matches!(f.first(), Some(b'[' | b'(' | b'{'));
        let names = fields.iter().filter(|f| !is_unit(f));
        Header { line, names: names.map(|f| String::from_utf8_lossy(unquoted(f)).into_owned()).collect() }
    }

    /// Returns the position of the column with this name, or `Err` if several columns have it.
    fn position(&self, name: &str) -> Result<Option<usize>, ()> {
        let mut found = (0..self.names.len()).filter(|&i| plain(&self.names[i]) == name);
        match (found.next(), found.next()) {
            (first, None) => Ok(first),
            _ => Err(()),
        }
    }

    /// Returns the positions of `x`, `y` and `z`, or of `x` and `y` if there is no `z`.
    pub fn axes(&self) -> Option<Vec<usize>> {
        let axis = |name| self.position(name).ok();
        let (x, y, z) = (axis("x")??, axis("y")??, axis("z")?);
        Some([Some(x), Some(y), z].into_iter().flatten().collect())
    }

    /// Returns the number of columns.
    pub fn width(&self) -> usize {
        self.names.len()
    }

    /// Returns the positions of the coordinates and of the column `size`.
    pub fn sizes(&self) -> Option<Vec<usize>> {
        let mut positions = self.axes()?;
        positions.push(self.position("size").ok()??);
        Some(positions)
    }

    /// Returns the name of a column for point data. The name is not empty and is unique.
    fn name_of_data(&self, position: usize) -> String {
        let name = self.names.get(position).map_or("", |name| name.trim());
        match self.names.iter().filter(|other| other.trim() == name).count() {
            _ if name.is_empty() => format!("column_{}", position + 1),
            1 => name.to_owned(),
            _ => format!("{name}_{}", position + 1),
        }
    }

    fn names_an_axis(&self) -> bool {
        self.names.iter().any(|name| matches!(plain(name).as_str(), "x" | "y" | "z"))
    }

    fn names_ids(&self) -> bool {
        self.names.iter().any(|name| IDS.contains(&plain(name).as_str()))
    }
}

/// Normalizes a name for comparison: converts it to lower case and removes quotes and a unit in brackets at the end.
fn plain(name: &str) -> String {
    let name = name.trim();
    let opening = match name.chars().last() {
        Some(']') => name.rfind('['),
        Some(')') => name.rfind('('),
        Some('}') => name.rfind('{'),
        _ => None,
    };
    let name = opening.filter(|&at| at > 0).map_or(name, |at| &name[..at]);
    name.trim().trim_matches(['"', '\'']).trim().to_lowercase()
}

/// A column that is kept as point data.
#[derive(Clone)]
struct Keeping {
    position: usize,
    column: Column,
    /// Whether every field so far is a number or empty.
    is_numeric: bool,
}

/// The columns of a table that are read.
#[derive(Clone)]
pub(super) struct Selection {
    /// The 0-based positions of the coordinates.
    pub axes: Vec<usize>,
    /// The number of fields that a row is expected to have.
    pub expected: usize,
    /// A note on the choice.
    pub note: Option<String>,
    /// Whether the coordinates are the first columns of a table without names.
    positional: bool,
    kept: Vec<Keeping>,
}

/// The columns that were kept, and notes on the others.
pub(super) struct Kept {
    pub columns: Vec<Column>,
    pub notes: Vec<String>,
}

impl Selection {
    /// Selects the columns; `row` is the first row of numbers, and `place` its line. `has_count` is `true` if the file
    /// begins with the number of its points.
    pub fn of(
        source: Source<'_>,
        place: Place,
        header: Option<&Header>,
        row: &[&[u8]],
        has_count: bool,
        options: &ReadOptions,
    ) -> Result<Self, InputError> {
        let chooser = Chooser { source, place, header, row, options };
        let (axes, note, positional) = match (&options.columns, header) {
            (Some(wanted), _) => (chooser.wanted(wanted)?, None, false),
            (None, Some(header)) => {
                let (axes, note) = chooser.named(header)?;
                (axes, Some(note), false)
            }
            (None, None) => {
                let numbers = chooser.numbers().len();
                if numbers > 3 && options.dimension.is_none() && !has_count {
                    let problem = format!("{numbers} columns of numbers without a header row");
                    return Err(chooser.error(problem));
                }
                ((0..options.dimension.unwrap_or(row.len().clamp(2, 3))).collect(), None, true)
            }
        };
        let width = header.map_or(0, |header| header.names.len()).max(row.len());
        let expected = if positional { axes.len() } else { width };
        let others = (0..width).filter(|i| options.keep_columns && !axes.contains(i));
        let name = |i: usize| header.map_or_else(|| format!("column_{}", i + 1), |h| h.name_of_data(i));
        let keeping = |i: usize| Keeping {
            position: i,
            column: Column { name: name(i), values: Vec::new() },
            is_numeric: true,
        };
        Ok(Selection { kept: others.map(keeping).collect(), axes, expected, note, positional })
    }

    /// Returns `true` if the coordinates are the first columns of a table without names.
    pub fn is_positional(&self) -> bool {
        self.positional
    }

    /// Returns the number of leading fields of a row that the reader needs.
    pub fn width(&self) -> usize {
        let last = self.axes.iter().chain(self.kept.iter().map(|k| &k.position)).max();
        (last.map_or(0, |last| last + 1)).max(self.expected).max(3)
    }

    /// Keeps the values of a row.
    pub fn keep(&mut self, fields: &[&[u8]]) {
        for Keeping { position, column, is_numeric } in &mut self.kept {
            let field = fields.get(*position).copied().unwrap_or_default();
            let value = if field.is_empty() { Some(f64::NAN) } else { number(field) };
            *is_numeric &= value.is_some();
            if *is_numeric {
                column.values.push(value.unwrap_or(f64::NAN));
            } else {
                column.values = Vec::new();
            }
        }
    }

    /// Removes and returns the numeric columns that were kept.
    pub fn take_kept(&mut self) -> Kept {
        let kept = std::mem::take(&mut self.kept);
        let (kept, text): (Vec<Keeping>, Vec<Keeping>) = kept.into_iter().partition(|k| k.is_numeric);
        let notes =
            text.into_iter().map(|k| format!("column {} has text and is not kept", shown(&k.column.name)));
        Kept { notes: notes.collect(), columns: kept.into_iter().map(|k| k.column).collect() }
    }
}

/// The inputs to the selection of columns.
struct Chooser<'a> {
    source: Source<'a>,
    place: Place,
    header: Option<&'a Header>,
    row: &'a [&'a [u8]],
    options: &'a ReadOptions,
}

impl Chooser<'_> {
    /// Returns the columns that the options select by name or number.
    fn wanted(&self, wanted: &[String]) -> Result<Vec<usize>, InputError> {
        if !(2..=3).contains(&wanted.len()) || self.options.dimension.is_some_and(|d| d != wanted.len()) {
            let expected = self.options.dimension.map_or("two or three".to_owned(), |d| d.to_string());
            let columns = if wanted.len() == 1 { "column" } else { "columns" };
            let problem = format!("{} {columns} instead of {expected}", wanted.len());
            return Err(self.error(problem));
        }
        wanted.iter().map(|name| self.column(name)).collect()
    }

    fn column(&self, name: &str) -> Result<usize, InputError> {
        if let Some(number) = name.trim().parse::<usize>().ok().filter(|n| (1..=self.row.len()).contains(n)) {
            return Ok(number - 1);
        }
        let Some(header) = self.header else {
            let width = self.row.len();
            let problem =
                format!("column {} is not one of 1 to {width}, and no header row names it", shown(name));
            return Err(self.error(problem));
        };
        let exact = header.names.iter().position(|n| n.trim() == name.trim());
        match exact.map_or_else(|| header.position(&plain(name)), |i| Ok(Some(i))) {
            Ok(Some(position)) => Ok(position),
            Ok(None) => Err(self.error(format!("there is no column {}", shown(name)))),
            Err(()) => Err(self.error(format!("more than one column is named {}", shown(name)))),
        }
    }

    /// Returns the columns that the header row selects, and a note on the choice.
    fn named(&self, header: &Header) -> Result<(Vec<usize>, String), InputError> {
        let line = header.line;
        let dimension = self.options.dimension;
        if let Some(mut axes) = header.axes().filter(|axes| dimension.is_none_or(|d| d <= axes.len())) {
            axes.truncate(dimension.unwrap_or(3));
            let width = header.names.len().max(self.row.len());
            let others: Vec<usize> = (0..width).filter(|i| !axes.contains(i)).collect();
            let ignored = if others.is_empty() || self.options.keep_columns {
                String::new()
            } else {
                format!("; {}", ignored(header, &others))
            };
            let taken = list(header, &axes);
            let note = format!("line {line} is taken as a header row: coordinates are {taken}{ignored}");
            return Ok((axes, note));
        }
        let numbers = self.numbers();
        let fits = dimension.map_or(matches!(numbers.len(), 2 | 3), |d| numbers.len() == d);
        if header.names_an_axis() || header.names_ids() || !fits {
            return Err(self.error("the header row does not name the columns x and y".to_owned()));
        }
        let note = format!(
            "line {line} is taken as a header row without x and y: coordinates are {}, in this order",
            list(header, &numbers)
        );
        Ok((numbers, note))
    }

    /// Returns the positions of the numbers in the first row, without an unnamed index column.
    fn numbers(&self) -> Vec<usize> {
        let is_index = |i: usize| i == 0 && self.header.is_some_and(|h| h.names[0].trim().is_empty());
        let is_number = |i: &usize| number(self.row[*i]).is_some() && !is_index(*i);
        (0..self.row.len()).filter(is_number).collect()
    }

    /// Creates an error that lists the column names and gives an example for `--columns`.
    fn error(&self, problem: String) -> InputError {
        let names = self.header.map(|header| header.names.iter().map(|n| shown(n)).collect::<Vec<_>>());
        let names = names.unwrap_or_default();
        let numbers = self.numbers();
        let is_id = |i: &usize| names.get(*i).is_some_and(|n| IDS.contains(&plain(n).as_str()));
        let (ids, mut others): (Vec<usize>, Vec<usize>) = numbers.into_iter().partition(is_id);
        others.extend(ids);
        let dimension = self.options.dimension.unwrap_or(3).min(others.len());
        let example = others[..dimension].iter().map(|&i| {
            let name = names.get(i).filter(|n| !n.contains([',', ' ']) && !n.is_empty());
            name.cloned().unwrap_or_else(|| (i + 1).to_string())
        });
        let example = example.collect::<Vec<_>>().join(",");
        let place = self.header.map_or(self.place, |header| Place::Line(header.line));
        let example = if example.is_empty() { "1,2,3".to_owned() } else { example };
        InputError::Columns { path: self.source.path.to_owned(), place, problem, names, example }
    }
}

/// Shortens a name and makes it printable.
fn shown(name: &str) -> String {
    excerpt(name.trim().as_bytes())
}

/// Returns the note that these columns are ignored.
fn ignored(header: &Header, positions: &[usize]) -> String {
    let is_named = |i: &usize| header.names.get(*i).is_some_and(|name| !name.trim().is_empty());
    let (named, unnamed): (Vec<usize>, Vec<usize>) = positions.iter().partition(|i| is_named(i));
    let verb = if positions.len() == 1 { "is" } else { "are" };
    let noun = |n: usize| if n == 1 { "column" } else { "columns" };
    let listed = format!("{} {}", noun(named.len()), list(header, &named));
    let counted = format!("{} unnamed {}", unnamed.len(), noun(unnamed.len()));
    match (named.len(), unnamed.len()) {
        (_, 0) => format!("{listed} {verb} ignored"),
        (0, _) => format!("{counted} {verb} ignored"),
        _ => format!("{listed} and {counted} {verb} ignored"),
    }
}

/// Lists columns by name, or by 1-based number.
fn list(header: &Header, positions: &[usize]) -> String {
    let name = |&i: &usize| header.names.get(i).map_or_else(|| (i + 1).to_string(), |n| shown(n));
    positions.iter().map(name).collect::<Vec<_>>().join(", ")
}
