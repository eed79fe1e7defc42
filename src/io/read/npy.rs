//! `NumPy` arrays of points and of cells.
//!
//! The header is a Python dictionary of three known keys, and this module parses only such a dictionary. A general
//! parser of Python literals would recurse on nested brackets and would not check the shape, so a small malicious
//! file could exhaust the stack or memory.

use super::cells::{CellFile, CellOptions, Indices};
use super::collect::Collector;
use super::error::{InputError, Place};
use super::points::{CoordinateType, PointFile, ReadOptions};
use super::scalar::{Endian, Scalar};
use super::sizes;
use super::text::{Source, excerpt, integer};
use septet_core::mesh::field::SizeField;

/// The header of a two-dimensional array.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    scalar: Scalar,
    /// The number of rows.
    pub rows: u64,
    /// The number of columns.
    pub columns: usize,
    /// Whether columns are contiguous (Fortran order).
    pub fortran: bool,
    /// The offset of the data in the file.
    pub start: u64,
    /// The number of bytes after the data.
    surplus: u64,
}

/// Rows of an array, which borrow their bytes.
struct Array<'a> {
    layout: Layout,
    /// The number of rows.
    rows: usize,
    /// The offset of the bytes in the file.
    start: u64,
    /// The bytes of the rows.
    data: &'a [u8],
}

impl Layout {
    /// Parses a header. `source` contains the first bytes of a file of `size` bytes, with the whole header.
    pub fn of(source: Source<'_>, size: u64) -> Result<Self, InputError> {
        let (from, start) = header_range(source, size)?;
        let text = usize::try_from(start).ok().and_then(|start| source.data.get(from..start));
        let text = text.ok_or_else(|| {
            source.truncated(Place::Byte(8), "header bytes", start, source.data.len() as u64)
        })?;
        let layout = header(source, text, from)?;
        let cells = u128::from(layout.rows) * layout.columns as u128;
        let bytes = cells * layout.scalar.size() as u128;
        let rest = size - start;
        if bytes > u128::from(rest) {
            let found = rest / layout.scalar.size() as u64;
            let expected = u64::try_from(cells).unwrap_or(u64::MAX);
            return Err(source.truncated(Place::Byte(start), "array elements", expected, found));
        }
        Ok(Layout { start, surplus: rest - bytes as u64, ..layout })
    }

    /// Returns the type of the coordinates.
    pub fn coordinate_type(&self) -> CoordinateType {
        self.scalar.coordinate_type()
    }

    /// Returns the number of bytes of a row.
    pub fn row_size(&self) -> u64 {
        (self.columns * self.scalar.size()) as u64
    }

    /// Creates a collector for `rows` points, or refuses an array of other than two or three columns.
    pub fn collector<'a>(
        &self,
        source: Source<'a>,
        options: &ReadOptions,
        rows: u64,
    ) -> Result<Collector<'a>, InputError> {
        let place = Place::Byte(self.start);
        if !(2..=3).contains(&self.columns) {
            let (path, found) = (source.path.to_owned(), self.columns as u64);
            return Err(InputError::UnsupportedDimension { path, place, found });
        }
        // No header announces more rows than the file has.
        let bytes = usize::try_from(rows.saturating_mul(self.row_size())).unwrap_or(usize::MAX);
        let size = (rows, bytes, self.row_size() as usize);
        let mut points = Collector::new(source, options, (place, self.columns), size)?;
        points.coordinate_type = Some(self.coordinate_type());
        Ok(points)
    }

    /// Adds the points of whole rows in C order, which begin at offset `start` of the file. Returns the number of
    /// integers that were rounded.
    pub fn rows_at(&self, start: u64, data: &[u8], points: &mut Collector<'_>) -> Result<u64, InputError> {
        let rows = data.len() / (self.row_size() as usize).max(1);
        Array { layout: *self, rows, start, data }.add_to(points)
    }

    /// Returns the notes on an array with this number of rounded integers.
    pub fn notes(&self, rounded: u64) -> Vec<String> {
        let mut notes = Vec::new();
        if rounded > 0 {
            notes.push(format!("{rounded} integers are too large for a double and were rounded"));
        }
        if self.surplus > 0 {
            notes.push(format!("{} bytes after the array are ignored", self.surplus));
        }
        notes
    }
}

impl Array<'_> {
    /// Returns the position of an element in the data.
    fn position(&self, row: usize, column: usize) -> usize {
        if self.layout.fortran { column * self.rows + row } else { row * self.layout.columns + column }
    }

    fn element(&self, row: usize, column: usize) -> &[u8] {
        let size = self.layout.scalar.size();
        let at = self.position(row, column) * size;
        &self.data[at..at + size]
    }

    /// Returns the byte offset of an element in the file.
    fn offset(&self, row: usize, column: usize) -> u64 {
        self.start + (self.position(row, column) * self.layout.scalar.size()) as u64
    }

    fn place(&self, row: usize, column: usize) -> Place {
        Place::Byte(self.offset(row, column))
    }

    /// Adds all rows as points. Returns the number of integers that were rounded.
    fn add_to(&self, points: &mut Collector<'_>) -> Result<u64, InputError> {
        let scalar = self.layout.scalar;
        let mut rounded = 0_u64;
        for row in 0..self.rows {
            let mut at = [0.0; 3];
            let mut place = self.place(row, 0);
            for (column, slot) in at[..points.dimension()].iter_mut().enumerate() {
                let element = self.element(row, column);
                *slot = scalar.float(element, Endian::Little);
                rounded += u64::from(scalar.rounds(element, Endian::Little));
                if !slot.is_finite() {
                    place = self.place(row, column);
                }
            }
            points.push(place, &at)?;
        }
        Ok(rounded)
    }
}

fn open(source: Source<'_>) -> Result<Array<'_>, InputError> {
    let layout = Layout::of(source, source.data.len() as u64)?;
    let data = &source.data[layout.start as usize..source.data.len() - layout.surplus as usize];
    Ok(Array { rows: layout.rows as usize, start: layout.start, data, layout })
}

/// Returns the offsets of the header dictionary and of the data. `source` contains the first twelve bytes of a file of
/// `size` bytes, or all of it.
pub(super) fn header_range(source: Source<'_>, size: u64) -> Result<(usize, u64), InputError> {
    let data = source.data;
    if !data.starts_with(b"\x93NUMPY") {
        return Err(source.malformed(
            0,
            format!("\"{}\"", excerpt(&data[..data.len().min(6)])),
            "the magic string \\x93NUMPY",
        ));
    }
    let (length, from) = match (data.get(6), data.get(8..12)) {
        (Some(1), Some(b)) => (u64::from(u16::from_le_bytes([b[0], b[1]])), 10),
        (Some(2 | 3), Some(b)) => (u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), 12),
        (Some(version), Some(_)) => {
            let what = format!("npy format version {version}");
            return Err(source.unsupported(Place::Byte(6), what, "save it with numpy.save"));
        }
        _ => return Err(source.truncated(Place::Byte(size), "header bytes", 12, size)),
    };
    let start = length + from as u64;
    if start > size {
        return Err(source.truncated(Place::Byte(8), "header bytes", length, size - from as u64));
    }
    Ok((from, start))
}

/// Parses the header dictionary: `{'descr': '<f8', 'fortran_order': False, 'shape': (10, 3), }`.
fn header(source: Source<'_>, text: &[u8], offset: usize) -> Result<Layout, InputError> {
    let wrong =
        |what: &'static str| source.malformed(offset, format!("\"{}\"", excerpt(text.trim_ascii())), what);
    let descr = value(text, b"descr").ok_or_else(|| wrong("a header with the key 'descr'"))?;
    let name = match descr.first() {
        Some(quote @ (b'\'' | b'"')) => descr[1..].split(|b| b == quote).next().unwrap_or_default(),
        _ => return Err(unsupported_type(source, offset, "a structured type")),
    };
    let scalar = scalar(source, offset, name)?;
    let order =
        value(text, b"fortran_order").ok_or_else(|| wrong("a header with the key 'fortran_order'"))?;
    let fortran = order.starts_with(b"True");
    if !fortran && !order.starts_with(b"False") {
        return Err(wrong("'fortran_order' True or False"));
    }
    let shape = value(text, b"shape").and_then(|s| s.strip_prefix(b"("));
    let shape = shape.ok_or_else(|| wrong("a header with the key 'shape'"))?;
    let end = shape.iter().position(|b| *b == b')').ok_or_else(|| wrong("a shape in brackets"))?;
    let mut sides = Vec::new();
    for side in shape[..end].split(|b| *b == b',').map(<[u8]>::trim_ascii).filter(|s| !s.is_empty()) {
        let side = integer(side).and_then(|n| u64::try_from(n).ok());
        sides.push(side.ok_or_else(|| wrong("a shape of whole numbers"))?);
    }
    let [rows, columns @ 0..=64] = sides[..] else {
        let what = format!("an array of shape ({})", excerpt(&shape[..end]));
        return Err(source.unsupported(
            Place::Byte(offset as u64),
            what,
            "save rows of points, or rows of cells",
        ));
    };
    Ok(Layout { scalar, rows, columns: columns as usize, fortran, start: 0, surplus: 0 })
}

/// Returns the text after a quoted key and its colon.
fn value<'a>(text: &'a [u8], key: &[u8]) -> Option<&'a [u8]> {
    let quoted = |i: &usize| {
        let quote = text[*i];
        matches!(quote, b'\'' | b'"')
            && text[i + 1..].starts_with(key)
            && text.get(i + 1 + key.len()) == Some(&quote)
    };
    let at = (0..text.len()).find(quoted)?;
    let rest = text[at + key.len() + 2..].trim_ascii_start();
    rest.strip_prefix(b":").map(<[u8]>::trim_ascii_start)
}

fn scalar(source: Source<'_>, offset: usize, name: &[u8]) -> Result<Scalar, InputError> {
    let (order, kind) = name.split_at(name.len().min(1));
    let scalar = Scalar::of_numpy(kind);
    match (order, scalar) {
        (b">", Some(_)) => {
            let what = format!("big-endian type '{}'", excerpt(name));
            let advice = "save it as little-endian: numpy.save(name, a.astype('<f8'))";
            Err(source.unsupported(Place::Byte(offset as u64), what, advice))
        }
        (b"<" | b"=" | b"|", Some(scalar)) => Ok(scalar),
        _ => Err(unsupported_type(source, offset, &format!("the type '{}'", excerpt(name)))),
    }
}

fn unsupported_type(source: Source<'_>, offset: usize, what: &str) -> InputError {
    let advice = "save doubles (<f8) for points, integers (<i8) for cells";
    source.unsupported(Place::Byte(offset as u64), what, advice)
}

/// Reads points: shape (n, 2) or (n, 3).
pub(super) fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let array = open(source)?;
    let mut points = array.layout.collector(source, options, array.layout.rows)?;
    let rounded = array.add_to(&mut points)?;
    points.notes.extend(array.layout.notes(rounded));
    Ok(points.finish())
}

/// Reads cells: integers of shape (m, 3) or (m, 4).
pub(super) fn read_cells(source: Source<'_>, options: &CellOptions) -> Result<CellFile, InputError> {
    let array = open(source)?;
    let place = Place::Byte(array.start);
    if !array.layout.scalar.is_integer() {
        return Err(source.unsupported(place, "a cell list of reals", "save integers (<i8)"));
    }
    if !(3..=4).contains(&array.layout.columns) {
        let what = format!("a cell list with rows of {}", array.layout.columns);
        return Err(source.unsupported(place, what, "save rows of 3 (triangles) or 4 (tetrahedra)"));
    }
    let mut cells = Indices::new(source, array.layout.columns, 0, options.point_count);
    for row in 0..array.rows {
        for column in 0..array.layout.columns {
            let value = array.layout.scalar.integer(array.element(row, column), Endian::Little);
            cells.push(array.place(row, column), value)?;
        }
    }
    Ok(cells.finish(Vec::new()))
}

/// Reads sizes at points: shape (n, 3) in the plane, (n, 4) in space.
pub(super) fn read_sizes(source: Source<'_>) -> Result<SizeField, InputError> {
    let array = open(source)?;
    if !(3..=4).contains(&array.layout.columns) {
        let what = format!("an array of sizes with rows of {}", array.layout.columns);
        let advice = "save rows of `x y size` or `x y z size`";
        return Err(source.unsupported(Place::Byte(array.start), what, advice));
    }
    let mut field = SizeField { dimension: array.layout.columns - 1, rows: Vec::new() };
    for row in 0..array.rows {
        let mut numbers = [0.0; 4];
        for (column, slot) in numbers[..array.layout.columns].iter_mut().enumerate() {
            *slot = array.layout.scalar.float(array.element(row, column), Endian::Little);
        }
        sizes::push(&mut field, &numbers[..array.layout.columns], |at, expected| {
            source.malformed(array.offset(row, at) as usize, numbers[at].to_string(), expected)
        })?;
    }
    if field.rows.is_empty() {
        return Err(source.truncated(Place::Byte(array.start), "rows of sizes", 1, 0));
    }
    Ok(field)
}
