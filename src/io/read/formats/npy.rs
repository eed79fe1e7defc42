//! `NumPy` arrays of points and of cells.
//!
//! The header is a Python dictionary of three known keys, and this module parses only such a dictionary. A general
//! parser of Python literals would recurse on nested brackets and would not check the shape, so a small malicious
//! file could exhaust the stack or memory.

use crate::read::array::{Array, Field, Fields, Layout, shape_advice};
use crate::read::axes;
use crate::read::cells::{CellFile, CellOptions, Indices};
use crate::read::error::{InputError, Place, WeightError};
use crate::read::points::{PointFile, ReadOptions};
use crate::read::scalar::{Endian, Scalar};
use crate::read::size_rows;
use crate::read::text::{Source, excerpt, integer};
use crate::read::weight_rows::WeightRows;
use crate::read::weights::numbered;
use septet_core::mesh::field::SizeField;

/// What an array is read as.
#[derive(Clone, Copy)]
pub enum Content<'a> {
    /// Points, with the name or number of the column of their weights.
    Points(Option<&'a str>),
    /// Rows of numbers.
    Rows,
    /// One number a row.
    Numbers,
    /// Vectors of a number of coordinates, at each of one vertex more, in a row of three sides.
    Vectors(usize),
}

impl<'a> Content<'a> {
    /// Returns the content of an array of points that is read with these options.
    pub fn of_points(options: &'a ReadOptions) -> Self {
        Content::Points(options.weight_column().map(|(name, _)| name))
    }

    /// Whether the content has three sides, of which these are the last two.
    fn has_sides(self, sides: [u64; 2]) -> bool {
        matches!(self, Content::Vectors(d) if sides == [d as u64 + 1, d as u64])
    }

    /// Returns `true` if a row has vectors.
    fn is_vectors(self) -> bool {
        matches!(self, Content::Vectors(_))
    }

    /// Returns the column of the weights.
    fn weight(self) -> Option<&'a str> {
        match self {
            Content::Points(weight) => weight,
            Content::Rows | Content::Numbers | Content::Vectors(_) => None,
        }
    }
}

fn open<'a>(source: Source<'a>, content: Content<'_>) -> Result<Array<'a>, InputError> {
    Ok(Array::of(source, layout(source, source.data.len() as u64, content)?))
}

/// Parses a header. `source` contains the first bytes of a file of `size` bytes, with the whole header.
pub fn layout(source: Source<'_>, size: u64, content: Content<'_>) -> Result<Layout, InputError> {
    let (from, start) = header_range(source, size)?;
    let text = usize::try_from(start).ok().and_then(|start| source.data.get(from..start));
    let text = text
        .ok_or_else(|| source.truncated(Place::Byte(8), "header bytes", start, source.data.len() as u64))?;
    let layout = header(source, text, (from, content))?;
    let cells = u128::from(layout.rows) * layout.columns as u128;
    let bytes = u128::from(layout.rows) * u128::from(layout.row_size());
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
fn header(
    source: Source<'_>,
    text: &[u8],
    (offset, content): (usize, Content<'_>),
) -> Result<Layout, InputError> {
    let wrong =
        |what: &'static str| source.malformed(offset, format!("\"{}\"", excerpt(text.trim_ascii())), what);
    let descr = value(text, b"descr").ok_or_else(|| wrong("a header with the key 'descr'"))?;
    let structured =
        descr.starts_with(b"[").then(|| structured(source, descr, (offset, content))).transpose()?;
    let (scalar, endian) = match (&structured, descr.first()) {
        (Some((fields, _)), _) => (fields.of[0].scalar, fields.of[0].endian),
        (None, Some(quote @ (b'\'' | b'"'))) => {
            let name = descr[1..].split(|b| b == quote).next().unwrap_or_default();
            scalar(source, offset, name)?
        }
        _ => return Err(wrong("a type in quotes, or a list of fields")),
    };
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
    let (rows, columns) = match (&sides[..], &structured) {
        ([rows, corners, axes], None) if content.has_sides([*corners, *axes]) => {
            (*rows, (*corners * *axes) as usize)
        }
        ([rows] | [rows, 1], Some((_, columns))) if !content.is_vectors() => (*rows, *columns),
        ([rows, columns @ 0..=64], None) if !content.is_vectors() => (*rows, *columns as usize),
        ([rows], None) if matches!(content, Content::Numbers) => (*rows, 1),
        (sides, _) => {
            let what = format!("an array of shape ({})", excerpt(shape[..end].trim_ascii()));
            let rows = if sides.len() == 2 { sides[0] } else { 0 };
            let place = Place::Byte(offset as u64);
            let advice = match content {
                Content::Numbers => "save one number a row: an array of shape (n,)",
                Content::Vectors(2) => "save an array of shape (cells, 3, 2)",
                Content::Vectors(_) => "save an array of shape (cells, 4, 3)",
                Content::Points(_) | Content::Rows => shape_advice(rows),
            };
            return Err(source.unsupported(place, what, advice));
        }
    };
    let weight = match (content.weight(), &structured) {
        (Some(name), None) => Some(numbered(name, columns).ok_or_else(|| {
            let problem = format!("column {} is not one of 1 to {columns}", excerpt(name.as_bytes()));
            weight_error(source, offset, (problem, &[]))
        })?),
        (Some(_), Some(_)) => Some(columns - 1),
        (None, _) => None,
    };
    let fields = structured.map(|(fields, _)| fields);
    let fortran = fortran && fields.is_none();
    Ok(Layout { scalar, endian, rows, columns, weight, fortran, start: 0, surplus: 0, fields })
}

/// Returns the error for the column of weights of an array with these fields.
fn weight_error(source: Source<'_>, offset: usize, (problem, names): (String, &[String])) -> InputError {
    let (path, place) = (source.path.to_owned(), Place::Byte(offset as u64));
    WeightError::Column { path, place, problem: problem.into(), names: names.to_vec() }.into()
}

/// Parses the fields of a structured array: `[('x', '<f8'), ('id', '<i4')]`. Returns the coordinates, then the weights, and
/// their number.
fn structured(
    source: Source<'_>,
    descr: &[u8],
    (offset, content): (usize, Content<'_>),
) -> Result<(Fields, usize), InputError> {
    let mut names: Vec<String> = Vec::new();
    let mut all: Vec<Field> = Vec::new();
    let (mut stride, mut count) = (0_usize, 0);
    let place = Place::Byte(offset as u64);
    let refused = |what: String| {
        let advice =
            "save an array of two or three columns: numpy.save(name, numpy.stack([x, y, z], axis=1))";
        Err(source.unsupported(place, what, advice))
    };
    let text = String::from_utf8_lossy(descr);
    let mut rest = text.strip_prefix('[').unwrap_or(&text).trim_start();
    while let Some(inner) = rest.strip_prefix('(') {
        let (name, after) = quoted(inner).unwrap_or_default();
        let kind = after.trim_start().strip_prefix(',').and_then(|after| quoted(after.trim_start()));
        let Some((kind, after)) = kind else {
            return refused("a structured array of nested fields".to_owned());
        };
        let Some(after) = after.trim_start().trim_start_matches(',').trim_start().strip_prefix(')') else {
            return refused(format!("the field {name}, which is an array itself,"));
        };
        let Some(size) = size_of(kind) else { return refused(format!("a field of the type '{kind}'")) };
        if let Ok((scalar, endian)) = scalar(source, offset, kind.as_bytes()) {
            names.push(name.to_lowercase());
            all.push(Field { offset: stride, scalar, endian });
        }
        stride = stride.saturating_add(size);
        count += 1;
        rest = after.trim_start().trim_start_matches(',').trim_start();
    }
    if !rest.starts_with(']') {
        let found = format!("\"{}\"", excerpt(rest.as_bytes()));
        return Err(source.malformed(offset, found, "the next field or the end of the list of fields"));
    }
    let Some(axes) = axes::axes(&names) else {
        return refused(format!(
            "a structured array whose fields ({}) do not name x and y",
            names.join(", ")
        ));
    };
    let weight = content.weight().map(|name| field_of_weights(name, &names, &axes)).transpose();
    let weight = weight.map_err(|problem| weight_error(source, offset, (problem, &names)))?;
    let mut of = [all[axes[0]]; 4];
    let chosen = axes.iter().copied().chain(weight);
    of.iter_mut().zip(chosen).for_each(|(field, axis)| *field = all[axis]);
    let columns = axes.len() + usize::from(weight.is_some());
    Ok((Fields { stride, of, ignored: count - columns }, columns))
}

/// Returns the position of the field of weights among numeric fields with these names in lower case, or the problem.
fn field_of_weights(name: &str, names: &[String], axes: &[usize]) -> Result<usize, String> {
    let shown = excerpt(name.as_bytes());
    let plain = name.trim().to_lowercase();
    let Some(position) = names.iter().position(|own| *own == plain) else {
        return Err(format!("there is no field {shown} of numbers"));
    };
    if axes.contains(&position) {
        return Err(format!("the field {shown} is a coordinate, and cannot be the weights"));
    }
    Ok(position)
}

/// Returns a text in quotes, and the text after it.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

/// Returns the number of bytes of a `NumPy` type, such as `<f8`, `<U10` or `<M8[ns]`.
fn size_of(kind: &str) -> Option<usize> {
    let kind = kind.trim_start_matches(['<', '>', '=', '|']);
    let letter = kind.chars().next().filter(char::is_ascii)?;
    let digits = kind[1..].split('[').next().unwrap_or_default();
    let size: usize = digits.parse().ok().filter(|size| *size < 1 << 24)?;
    match letter {
        'U' => Some(4 * size),
        'b' | 'i' | 'u' | 'f' | 'c' | 'S' | 'a' | 'V' | 'M' | 'm' => Some(size),
        _ => None,
    }
}

/// Returns the text after a quoted key and its colon.
fn value<'a>(text: &'a [u8], key: &[u8]) -> Option<&'a [u8]> {
    let is_key = |i: &usize| {
        let quote = text[*i];
        matches!(quote, b'\'' | b'"')
            && text[i + 1..].starts_with(key)
            && text.get(i + 1 + key.len()) == Some(&quote)
            && text[i + 2 + key.len()..].trim_ascii_start().starts_with(b":")
    };
    let at = (0..text.len()).find(is_key)?;
    let rest = text[at + key.len() + 2..].trim_ascii_start();
    rest.strip_prefix(b":").map(<[u8]>::trim_ascii_start)
}

fn scalar(source: Source<'_>, offset: usize, name: &[u8]) -> Result<(Scalar, Endian), InputError> {
    let (order, kind) = name.split_at(name.len().min(1));
    match (order, Scalar::of_numpy(kind)) {
        (b">", Some(scalar)) => Ok((scalar, Endian::Big)),
        (b"<" | b"=" | b"|", Some(scalar)) => Ok((scalar, Endian::Little)),
        _ => Err(unsupported_type(source, offset, &format!("the type '{}'", excerpt(name)))),
    }
}

fn unsupported_type(source: Source<'_>, offset: usize, what: &str) -> InputError {
    let advice = "save doubles (<f8) for points, integers (<i8) for cells";
    source.unsupported(Place::Byte(offset as u64), what, advice)
}

/// Reads points: shape (n, 2) or (n, 3), and one column more with a column of weights.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    layout(source, source.data.len() as u64, Content::of_points(options))?.points(source, options)
}

/// Reads weights: shape (n,) or (n, 1).
pub fn read_weights(source: Source<'_>, rows: &mut WeightRows<'_>) -> Result<(), InputError> {
    let array = Array::of(source, layout_of_weights(source, source.data.len() as u64)?);
    array.layout.numbers_at(array.start, array.bytes_of_rows(), rows)
}

/// Parses the header of an array of weights, as [`layout`] does.
pub fn layout_of_weights(source: Source<'_>, size: u64) -> Result<Layout, InputError> {
    let layout = layout(source, size, Content::Numbers)?;
    if layout.fields.is_some() || layout.columns != 1 {
        let what = format!("an array of weights with rows of {}", layout.columns);
        let advice = "save one number a row: an array of shape (n,)";
        return Err(source.unsupported(Place::Byte(layout.start), what, advice));
    }
    Ok(layout)
}

/// Reads cells: integers of shape (m, 3) to (m, 7).
pub fn read_cells(source: Source<'_>, options: &CellOptions) -> Result<CellFile, InputError> {
    let array = open(source, Content::Rows)?;
    let place = Place::Byte(array.start);
    if array.layout.fields.is_some() {
        return Err(source.unsupported(place, "a structured array as cells", "save integers (<i8)"));
    }
    if !array.layout.scalar.is_integer() {
        return Err(source.unsupported(place, "a cell list of reals", "save integers (<i8)"));
    }
    if !(3..=7).contains(&array.layout.columns) {
        let what = format!("a cell list with rows of {}", array.layout.columns);
        let advice = "save rows of 3 (triangles), 4 (tetrahedra), or 5 to 7 in dimensions 4 to 6";
        return Err(source.unsupported(place, what, advice));
    }
    let mut cells = Indices::new(source, array.layout.columns, 0, options.point_count);
    for row in 0..array.rows {
        for column in 0..array.layout.columns {
            cells.push(array.place(row, column), array.integer(row, column))?;
        }
    }
    Ok(cells.finish(Vec::new()))
}

/// Reads offsets of the vertices of cells: integers of shape (m, d + 1, d).
pub fn read_offsets(source: Source<'_>, (cells, dimension): (usize, usize)) -> Result<Vec<i32>, InputError> {
    let mut array = open(source, Content::Vectors(dimension))?;
    let place = Place::Byte(array.start);
    if !array.layout.scalar.is_integer() {
        return Err(source.unsupported(place, "an array of offsets of reals", "save integers (<i1)"));
    }
    let rows = array.rows;
    if rows != cells {
        let what = format!("an array of the offsets of {rows} cells");
        return Err(source.unsupported(place, what, format!("give the offsets of the {cells} cells")));
    }
    // In Fortran order, the first side varies first, then the second: a table of as many rows as the first two have.
    let is_transposed = array.layout.fortran;
    if is_transposed {
        (array.rows, array.layout.columns) = (rows * (dimension + 1), dimension);
    }
    let mut offsets = Vec::with_capacity(cells * (dimension + 1) * dimension);
    for cell in 0..cells {
        for corner in 0..=dimension {
            for axis in 0..dimension {
                let (row, column) = if is_transposed {
                    (corner * rows + cell, axis)
                } else {
                    (cell, corner * dimension + axis)
                };
                let steps = array.integer(row, column);
                offsets.push(i32::try_from(steps).map_err(|_| {
                    let at = array.offset(row, column) as usize;
                    source.malformed(at, steps.to_string(), "an offset of 32 bits")
                })?);
            }
        }
    }
    Ok(offsets)
}

/// Reads sizes at points: shape (n, 3) in the plane, (n, 4) in space.
pub fn read_sizes(source: Source<'_>) -> Result<SizeField, InputError> {
    let array = open(source, Content::Rows)?;
    if array.layout.fields.is_some() || !(3..=4).contains(&array.layout.columns) {
        let what = format!("an array of sizes with rows of {}", array.layout.columns);
        let advice = "save rows of `x y size` or `x y z size`";
        return Err(source.unsupported(Place::Byte(array.start), what, advice));
    }
    let mut field = SizeField { dimension: array.layout.columns - 1, rows: Vec::new() };
    for row in 0..array.rows {
        let mut numbers = [0.0; 4];
        for (column, slot) in numbers[..array.layout.columns].iter_mut().enumerate() {
            *slot = array.float(row, column);
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
