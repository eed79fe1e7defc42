//! `NumPy` arrays of points and of cells.
//!
//! The header is a Python dictionary of three known keys, and this module parses only such a dictionary. A general
//! parser of Python literals would recurse on nested brackets and would not check the shape, so a small malicious
//! file could exhaust the stack or memory.

use crate::read::array::{Array, Layout};
use crate::read::cells::{CellFile, CellOptions, Indices};
use crate::read::error::{InputError, Place};
use crate::read::points::{PointFile, ReadOptions};
use crate::read::scalar::{Endian, Scalar};
use crate::read::size_rows;
use crate::read::text::{Source, excerpt, integer};
use septet_core::mesh::field::SizeField;

fn open(source: Source<'_>) -> Result<Array<'_>, InputError> {
    Ok(Array::of(source, layout(source, source.data.len() as u64)?))
}

/// Parses a header. `source` contains the first bytes of a file of `size` bytes, with the whole header.
pub fn layout(source: Source<'_>, size: u64) -> Result<Layout, InputError> {
    let (from, start) = header_range(source, size)?;
    let text = usize::try_from(start).ok().and_then(|start| source.data.get(from..start));
    let text = text
        .ok_or_else(|| source.truncated(Place::Byte(8), "header bytes", start, source.data.len() as u64))?;
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

/// Returns the offsets of the header dictionary and of the data. `source` contains the first twelve bytes of a file of
/// `size` bytes, or all of it.
pub fn header_range(source: Source<'_>, size: u64) -> Result<(usize, u64), InputError> {
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
    let endian = Endian::Little;
    Ok(Layout { scalar, endian, rows, columns: columns as usize, fortran, start: 0, surplus: 0 })
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
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    layout(source, source.data.len() as u64)?.points(source, options)
}

/// Reads cells: integers of shape (m, 3) or (m, 4).
pub fn read_cells(source: Source<'_>, options: &CellOptions) -> Result<CellFile, InputError> {
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
pub fn read_sizes(source: Source<'_>) -> Result<SizeField, InputError> {
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
        size_rows::push(&mut field, &numbers[..array.layout.columns], |at, expected| {
            source.malformed(array.offset(row, at) as usize, numbers[at].to_string(), expected)
        })?;
    }
    if field.rows.is_empty() {
        return Err(source.truncated(Place::Byte(array.start), "rows of sizes", 1, 0));
    }
    Ok(field)
}
