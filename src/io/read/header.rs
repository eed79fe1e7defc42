//! The header row of a text table, and the selection of the columns that hold the coordinates.
//!
//! **Selection.** Names are compared without regard to case, quotes or units in brackets. The first rule that applies
//! selects the columns:
//! 1. `--columns` gives two to six columns by name or by 1-based number.
//! 2. The header row names the axes ([`super::axes`]). No other names are coordinates.
//! 3. If there is no header row and no more than three numbers in the first row, the first columns are used. The first
//!    columns are also used if the options give the dimension, or if the file begins with the number of its points,
//!    because further columns of such files hold intensities and colours.
//!
//! Otherwise the columns are ambiguous, and the reader returns an error that lists the names.
//!
//! **Weights.** A column of weights is chosen by name or number. It is no coordinate: a table without a header row has its
//! coordinates in the first of the other columns. A column that the options or its name make a coordinate is refused as weights.
//!
//! **Row names.** A header that is one name short in every row, as R writes it, belongs to the columns after the first.

use super::axes;
use super::collect::MOST_COORDINATES;
use super::error::{InputError, Place, WeightError};
use super::ids;
use super::points::{Column, ReadOptions};
use super::row::Row;
use super::text::{Source, excerpt, number, unquoted};
use super::weights::numbered;

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

    /// Returns the positions of the columns that mean x, y and z, or x and y if none means z.
    pub fn axes(&self) -> Option<Vec<usize>> {
        axes::axes(&self.plain_names())
    }

    /// Returns the positions of the columns that mean x and y, and of the only one that means a height, if there is one.
    fn axes_of_terrain(&self) -> Option<Vec<usize>> {
        let mut axes = self.axes()?;
        if axes.len() == 2 {
            axes.extend(axes::height(&self.plain_names()));
        }
        Some(axes)
    }

    fn plain_names(&self) -> Vec<String> {
        self.names.iter().map(|name| plain(name)).collect()
    }

    /// Adds a column without a name before the others, if the first fields of all rows are names of rows.
    pub fn shift(&mut self, rows: &[Row<'_>]) -> bool {
        let shifts = ids::are_row_names(rows, self.names.len() + 1);
        if shifts {
            self.names.insert(0, String::new());
        }
        shifts
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
    /// The 0-based position of the weights, if they are in a column.
    pub weight: Option<usize>,
    /// The number of fields of each row.
    pub width: usize,
    /// The names of the coordinates, or their 1-based numbers.
    pub names: Vec<String>,
    /// The names or numbers of the columns that are not read.
    pub ignored: Vec<String>,
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

/// The number of points at the beginning of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum StatedCount {
    /// The file does not state it.
    None,
    /// The file states it alone.
    Alone,
    /// The file states it with this dimension.
    WithDimension(u64),
}

/// The statements of the lines before the first row.
#[derive(Clone, Copy)]
pub(super) struct Stated<'a> {
    pub header: Option<&'a Header>,
    pub count: StatedCount,
}

impl Selection {
    /// Selects the columns; `rows` are the first rows of numbers.
    pub fn of(
        source: Source<'_>,
        stated: Stated<'_>,
        rows: &[Row<'_>],
        options: &ReadOptions,
    ) -> Result<Self, InputError> {
        let header = stated.header;
        let row = &rows[0].fields[..rows[0].filled];
        let mut chooser = Chooser { source, header, row, rows, options, weight: None };
        chooser.weight = options.weight_column().map(|(name, _)| chooser.weight(name)).transpose()?;
        let (axes, note) = match (&options.columns, header) {
            (Some(wanted), _) => (chooser.wanted(wanted)?, None),
            (None, Some(header)) => {
                let (axes, note) = chooser.named(header)?;
                (axes, Some(note))
            }
            (None, None) => (chooser.first(stated.count)?, None),
        };
        chooser.check_weight(&axes)?;
        let positional = options.columns.is_none() && header.is_none();
        let width = header.map_or(0, |header| header.names.len()).max(row.len());
        let shown = |i: &usize| {
            let name = header.and_then(|h| h.names.get(*i)).map(|name| shown(name));
            name.filter(|name| !name.is_empty()).unwrap_or_else(|| (i + 1).to_string())
        };
        let others: Vec<usize> = (0..width).filter(|i| !axes.contains(i)).collect();
        let is_ignored = |i: &&usize| chooser.weight != Some(**i);
        let (names, ignored) =
            (axes.iter().map(shown).collect(), others.iter().filter(is_ignored).map(shown).collect());
        let name = |i: usize| header.map_or_else(|| format!("column_{}", i + 1), |h| h.name_of_data(i));
        let keeping = |i: usize| Keeping {
            position: i,
            column: Column { name: name(i), values: Vec::new() },
            is_numeric: true,
        };
        let others = others.into_iter().filter(|_| options.keep_columns);
        let (kept, weight) = (others.map(keeping).collect(), chooser.weight);
        Ok(Selection { axes, weight, width, names, ignored, note, positional, kept })
    }

    /// Returns `true` if the coordinates are the first columns of a table without names.
    pub fn is_positional(&self) -> bool {
        self.positional
    }

    /// Returns the largest position of the first `dimension` coordinates and of the weights.
    pub fn last(&self, dimension: usize) -> usize {
        self.axes[..dimension].iter().copied().chain(self.weight).max().unwrap_or(0)
    }

    /// Keeps the values of a row.
    pub fn keep(&mut self, row: &Row<'_>) {
        for Keeping { position, column, is_numeric } in &mut self.kept {
            let field = row.fields.get(*position).copied().unwrap_or_default();
            let value = if field.is_empty() { Some(f64::NAN) } else { row.number(field) };
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
    header: Option<&'a Header>,
    /// The first row.
    row: &'a [&'a [u8]],
    /// The first rows.
    rows: &'a [Row<'a>],
    options: &'a ReadOptions,
    /// The position of the weights.
    weight: Option<usize>,
}

impl Chooser<'_> {
    /// Returns the columns that the options select by name or number.
    fn wanted(&self, wanted: &[String]) -> Result<Vec<usize>, InputError> {
        if !(2..=MOST_COORDINATES).contains(&wanted.len())
            || self.options.dimension.is_some_and(|d| d != wanted.len())
        {
            let expected = self.options.dimension.map_or("two to six".to_owned(), |d| d.to_string());
            let columns = if wanted.len() == 1 { "column" } else { "columns" };
            let problem = format!("{} {columns} instead of {expected}", wanted.len());
            return Err(self.error(problem));
        }
        wanted.iter().map(|name| self.column(name)).collect()
    }

    fn column(&self, name: &str) -> Result<usize, InputError> {
        self.position(name).map_err(|problem| self.error(problem))
    }

    /// Returns the position of the column with this name or number, or the problem.
    fn position(&self, name: &str) -> Result<usize, String> {
        if let Some(position) = numbered(name, self.row.len()) {
            return Ok(position);
        }
        let Some(header) = self.header else {
            let width = self.row.len();
            return Err(format!(
                "column {} is not one of 1 to {width}, and no header row names it",
                shown(name)
            ));
        };
        let exact = header.names.iter().position(|n| n.trim() == name.trim());
        match exact.map_or_else(|| header.position(&plain(name)), |i| Ok(Some(i))) {
            Ok(Some(position)) => Ok(position),
            Ok(None) => Err(format!("there is no column {}", shown(name))),
            Err(()) => Err(format!("more than one column is named {}", shown(name))),
        }
    }

    /// Returns the position of the column of weights.
    fn weight(&self, name: &str) -> Result<usize, InputError> {
        self.position(name).map_err(|problem| self.weight_error(problem))
    }

    /// Refuses a column of weights that is one of the coordinates.
    fn check_weight(&self, axes: &[usize]) -> Result<(), InputError> {
        let Some(weight) = self.weight.filter(|weight| axes.contains(weight)) else { return Ok(()) };
        let name = self.header.and_then(|header| header.names.get(weight)).map(|name| shown(name));
        let name = name.unwrap_or_else(|| (weight + 1).to_string());
        Err(self.weight_error(format!("column {name} is a coordinate, and cannot be the weights")))
    }

    /// Creates the error for the column of weights.
    fn weight_error(&self, problem: String) -> InputError {
        let (path, problem) = (self.source.path.to_owned(), problem.into());
        WeightError::Column { path, place: self.place(), problem, names: self.names() }.into()
    }

    /// Returns the place of the header row, or of the first row of numbers.
    fn place(&self) -> Place {
        self.header.map_or(self.rows[0].line.place(), |header| Place::Line(header.line))
    }

    /// Returns the names of the header row, shortened.
    fn names(&self) -> Vec<String> {
        self.header.map(|header| header.names.iter().map(|n| shown(n)).collect()).unwrap_or_default()
    }

    /// Returns the columns that the header row selects, and a note on the choice.
    fn named(&self, header: &Header) -> Result<(Vec<usize>, String), InputError> {
        let line = header.line;
        let dimension = self.options.dimension;
        if let Some(dimension) = dimension.filter(|&d| d > 3) {
            return self.all_named(header, dimension);
        }
        let axes = if self.options.terrain { header.axes_of_terrain() } else { header.axes() };
        if let Some(mut axes) = axes.clone().filter(|axes| dimension.is_none_or(|d| d <= axes.len())) {
            axes.truncate(dimension.unwrap_or(3));
            let width = header.names.len().max(self.row.len());
            let is_other = |i: &usize| !axes.contains(i) && self.weight != Some(*i);
            let others: Vec<usize> = (0..width).filter(is_other).collect();
            let ignored = if others.is_empty() || self.options.keep_columns {
                String::new()
            } else {
                format!("; {}", ignored(header, &others))
            };
            let taken = list(header, &axes);
            let weights =
                self.weight.map_or_else(String::new, |i| format!(", weights are {}", list(header, &[i])));
            let note =
                format!("line {line} is taken as a header row: coordinates are {taken}{weights}{ignored}");
            return Ok((axes, note));
        }
        let problem = match axes {
            Some(_) if self.options.terrain => "the header row names no z, which a terrain needs",
            Some(_) => "the header row does not name the columns x, y and z",
            None => "the header row does not name the columns x and y",
        };
        Err(self.error(problem.to_owned()))
    }

    /// Returns all columns besides the weights as the coordinates of a dimension above 3, in which no names are usual.
    fn all_named(&self, header: &Header, dimension: usize) -> Result<(Vec<usize>, String), InputError> {
        let axes: Vec<usize> = (0..header.names.len()).filter(|i| self.weight != Some(*i)).collect();
        if axes.len() != dimension {
            return Err(self.error(format!("{} columns for {dimension} coordinates", axes.len())));
        }
        let (line, taken) = (header.line, list(header, &axes));
        Ok((axes, format!("line {line} is taken as a header row: coordinates are {taken}")))
    }

    /// Returns the first columns, which have no names. After a number of points, further columns are values of the points,
    /// unless the dimension beside the number counts them.
    fn first(&self, stated: StatedCount) -> Result<Vec<usize>, InputError> {
        let is_free = |i: &usize| self.weight != Some(*i);
        let is_number = |i: &usize| self.rows[0].number(self.row[*i]).is_some();
        let numbers = (0..self.row.len()).filter(|i| is_free(i) && is_number(i)).count();
        let has_values = match stated {
            StatedCount::None => false,
            StatedCount::Alone => true,
            StatedCount::WithDimension(dimension) => dimension <= 3,
        };
        let is_chosen = self.options.dimension.is_some() && !self.options.terrain;
        if numbers > 3 && !is_chosen && !has_values {
            let besides = if self.weight.is_some() { " besides the weights" } else { "" };
            return Err(self.error(format!("{numbers} columns of numbers{besides} without a header row")));
        }
        let width = self.row.len() - usize::from(self.weight.is_some());
        let dimension = self.options.dimension.unwrap_or(width.clamp(2, 3));
        Ok((0..).filter(is_free).take(dimension).collect())
    }

    /// Creates an error that lists the column names, and gives an example for `--columns` if it is sure.
    fn error(&self, problem: String) -> InputError {
        let unnamed = self.header.is_none() && self.options.columns.is_none();
        let sure = || ids::sure_columns(self.rows, self.options.dimension, self.weight);
        let example = unnamed.then(sure).flatten();
        InputError::Columns {
            path: self.source.path.to_owned(),
            place: self.place(),
            problem: problem.into(),
            names: self.names(),
            example: example.unwrap_or_default(),
        }
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
