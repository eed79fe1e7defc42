//! `NumPy` arrays of points and of cells.
//!
//! The header is a Python dictionary of three known keys, and this module parses only such a dictionary. A general
//! parser of Python literals would recurse on nested brackets and would not check the shape, so a small malicious
//! file could exhaust the stack or memory.

use super::cells::{CellFile, CellOptions, Indices};
use super::collect::Collector;
use super::error::{InputError, Place};
use super::points::{PointFile, ReadOptions};
use super::scalar::{Endian, Scalar};
use super::sizes;
use super::text::{Source, excerpt, integer};
use septet_core::mesh::field::SizeField;

/// A two-dimensional array that borrows the bytes of its file.
struct Array<'a> {
    scalar: Scalar,
    rows: u64,
    columns: usize,
    /// Whether columns are contiguous (Fortran order).
    fortran: bool,
    /// The offset of the data in the file.
    start: usize,
    /// The bytes of the data.
    data: &'a [u8],
    /// The number of bytes after the data.
    surplus: usize,
}

impl Array<'_> {
    /// Returns the position of an element in the data.
    fn position(&self, row: usize, column: usize) -> usize {
        if self.fortran { column * self.rows as usize + row } else { row * self.columns + column }
    }

    fn element(&self, row: usize, column: usize) -> &[u8] {
        let size = self.scalar.size();
        let at = self.position(row, column) * size;
        &self.data[at..at + size]
    }

    /// Returns the byte offset of an element in the file.
    fn offset(&self, row: usize, column: usize) -> usize {
        self.start + self.position(row, column) * self.scalar.size()
    }

    fn place(&self, row: usize, column: usize) -> Place {
        Place::Byte(self.offset(row, column) as u64)
    }
}

fn open(source: Source<'_>) -> Result<Array<'_>, InputError> {
    let data = source.data;
    let size = data.len() as u64;
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
    let start =
        usize::try_from(length).ok().and_then(|n| n.checked_add(from)).filter(|end| *end <= data.len());
    let start =
        start.ok_or_else(|| source.truncated(Place::Byte(8), "header bytes", length, size - from as u64))?;
    let mut array = header(source, &data[from..start], from)?;
    let cells = u128::from(array.rows) * array.columns as u128;
    let bytes = cells * array.scalar.size() as u128;
    let rest = &data[start..];
    if bytes > rest.len() as u128 {
        let found = (rest.len() / array.scalar.size()) as u64;
        let expected = u64::try_from(cells).unwrap_or(u64::MAX);
        return Err(source.truncated(Place::Byte(start as u64), "array elements", expected, found));
    }
    (array.start, array.data, array.surplus) = (start, &rest[..bytes as usize], rest.len() - bytes as usize);
    Ok(array)
}

/// Parses the header dictionary: `{'descr': '<f8', 'fortran_order': False, 'shape': (10, 3), }`.
fn header<'a>(source: Source<'_>, text: &[u8], offset: usize) -> Result<Array<'a>, InputError> {
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
    Ok(Array { scalar, rows, columns: columns as usize, fortran, start: 0, data: &[], surplus: 0 })
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
    let place = Place::Byte(array.start as u64);
    if !(2..=3).contains(&array.columns) {
        let (path, found) = (source.path.to_owned(), array.columns as u64);
        return Err(InputError::UnsupportedDimension { path, place, found });
    }
    let size = (array.rows, array.data.len(), array.columns * array.scalar.size());
    let mut points = Collector::new(source, options, (place, array.columns), size)?;
    points.coordinate_type = Some(array.scalar.coordinate_type());
    let mut rounded = 0_u64;
    for row in 0..array.rows as usize {
        let mut at = [0.0; 3];
        let mut place = array.place(row, 0);
        for (column, slot) in at[..points.dimension()].iter_mut().enumerate() {
            let element = array.element(row, column);
            *slot = array.scalar.float(element, Endian::Little);
            rounded += u64::from(array.scalar.rounds(element, Endian::Little));
            if !slot.is_finite() {
                place = array.place(row, column);
            }
        }
        points.push(place, &at)?;
    }
    if rounded > 0 {
        points.notes.push(format!("{rounded} integers are too large for a double and were rounded"));
    }
    if array.surplus > 0 {
        points.notes.push(format!("{} bytes after the array are ignored", array.surplus));
    }
    Ok(points.finish())
}

/// Reads cells: integers of shape (m, 3) or (m, 4).
pub(super) fn read_cells(source: Source<'_>, options: &CellOptions) -> Result<CellFile, InputError> {
    let array = open(source)?;
    let place = Place::Byte(array.start as u64);
    if !array.scalar.is_integer() {
        return Err(source.unsupported(place, "a cell list of reals", "save integers (<i8)"));
    }
    if !(3..=4).contains(&array.columns) {
        let what = format!("a cell list with rows of {}", array.columns);
        return Err(source.unsupported(place, what, "save rows of 3 (triangles) or 4 (tetrahedra)"));
    }
    let mut cells = Indices::new(source, array.columns, 0, options.point_count);
    for row in 0..array.rows as usize {
        for column in 0..array.columns {
            let value = array.scalar.integer(array.element(row, column), Endian::Little);
            cells.push(array.place(row, column), value)?;
        }
    }
    Ok(cells.finish(Vec::new()))
}

/// Reads sizes at points: shape (n, 3) in the plane, (n, 4) in space.
pub(super) fn read_sizes(source: Source<'_>) -> Result<SizeField, InputError> {
    let array = open(source)?;
    if !(3..=4).contains(&array.columns) {
        let what = format!("an array of sizes with rows of {}", array.columns);
        let advice = "save rows of `x y size` or `x y z size`";
        return Err(source.unsupported(Place::Byte(array.start as u64), what, advice));
    }
    let mut field = SizeField { dimension: array.columns - 1, rows: Vec::new() };
    for row in 0..array.rows as usize {
        let mut numbers = [0.0; 4];
        for (column, slot) in numbers[..array.columns].iter_mut().enumerate() {
            *slot = array.scalar.float(array.element(row, column), Endian::Little);
        }
        sizes::push(&mut field, &numbers[..array.columns], |at, expected| {
            source.malformed(array.offset(row, at), numbers[at].to_string(), expected)
        })?;
    }
    if field.rows.is_empty() {
        return Err(source.truncated(Place::Byte(array.start as u64), "rows of sizes", 1, 0));
    }
    Ok(field)
}
