//! Stanford `.ply` files, ASCII and binary of both byte orders: the element `vertex`.

use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::faces::{Faces, position};
use crate::read::points::{PointFile, ReadOptions};
use crate::read::scalar::{Endian, Scalar};
use crate::read::text::{Line, Lines, Source, integer};

/// A property of an element: a number, or a list preceded by its length.
struct Property<'a> {
    name: &'a [u8],
    list_length: Option<Scalar>,
    scalar: Scalar,
}

struct Element<'a> {
    name: &'a [u8],
    /// The line number of the declaration in the header.
    line: u64,
    count: u64,
    properties: Vec<Property<'a>>,
}

struct Header<'a> {
    /// The byte order, or `None` for ASCII.
    endian: Option<Endian>,
    elements: Vec<Element<'a>>,
}

/// Reads the properties `x`, `y`, `z` (or `x`, `y`) of all vertices.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let mut lines = Lines::new(source.data);
    let header = header(source, &mut lines)?;
    let Some(at) = header.elements.iter().position(|e| e.name == b"vertex") else {
        return Err(source.unsupported(
            Place::Line(lines.number()),
            "a PLY file without vertices",
            "export the points",
        ));
    };
    let (before, vertex) = (&header.elements[..at], &header.elements[at]);
    let axes = axes(source, vertex)?;
    let least = if header.endian.is_some() { least_bytes(vertex) } else { 2 * axes.len() };
    let size = (vertex.count, lines.rest().len(), least);
    let mut points = Collector::new(source, options, (Place::Line(vertex.line), axes.len()), size)?;
    match header.endian {
        None => {
            read_ascii(source, &mut lines, before, (vertex, &axes), &mut points)?;
            let last = header.elements.len() == at + 1;
            let is_row = |line: &Line<'_>| !matches!(line.keyword().as_str(), "" | "comment" | "obj_info");
            if let Some(line) = lines.find(|line| last && is_row(line)) {
                return Err(source.surplus(line.place(), "points", vertex.count));
            }
        }
        Some(endian) => {
            points.coordinate_type = Some(vertex.properties[axes[0]].scalar.coordinate_type());
            let offset = source.data.len() - lines.rest().len();
            let mut cursor = Cursor { source, offset, endian };
            for element in before {
                cursor.skip_element(element)?;
            }
            read_binary(&mut cursor, (vertex, &axes), &mut points)?;
        }
    }
    points.note_if_flat();
    Ok(points.finish())
}

/// Reads the lists `vertex_indices` (or `vertex_index`) of all faces.
pub fn read_faces(source: Source<'_>) -> Result<Faces, InputError> {
    let mut lines = Lines::new(source.data);
    let header = header(source, &mut lines)?;
    let is_list =
        |p: &Property<'_>| p.list_length.is_some() && matches!(p.name, b"vertex_indices" | b"vertex_index");
    let place = Place::Line(lines.number());
    let face = header.elements.iter().position(|e| e.name == b"face");
    let list = face.and_then(|i| header.elements[i].properties.iter().position(is_list));
    let (Some(at), Some(list)) = (face, list) else {
        return Err(source.unsupported(place, "a PLY file without faces", "export it with faces"));
    };
    let (before, face) = (&header.elements[..at], &header.elements[at]);
    let Some(endian) = header.endian else {
        skip_lines(source, &mut lines, before)?;
        return ascii_faces(source, &mut lines, face, list);
    };
    let offset = source.data.len() - lines.rest().len();
    let mut cursor = Cursor { source, offset, endian };
    for element in before {
        cursor.skip_element(element)?;
    }
    let mut faces = Faces::new();
    for found in 0..face.count {
        let start = cursor.offset;
        let mut corners = Vec::new();
        for (i, property) in face.properties.iter().enumerate() {
            let bytes = cursor.property(property).ok_or_else(|| cursor.cut("faces", face.count, found))?;
            if i == list {
                let ids = bytes.chunks_exact(property.scalar.size());
                corners = ids.map(|b| u32::try_from(property.scalar.integer(b, endian))).collect();
            }
        }
        let corners: Result<Vec<u32>, _> = corners.into_iter().collect();
        faces.push(
            corners.map_err(|_| source.malformed(start, "a negative point id", "a position of a vertex"))?,
        );
    }
    Ok(faces)
}

fn ascii_faces(
    source: Source<'_>,
    lines: &mut Lines<'_>,
    face: &Element<'_>,
    list: usize,
) -> Result<Faces, InputError> {
    let mut faces = Faces::new();
    for found in 0..face.count {
        let Some(line) = lines.find(|line| line.words().next().is_some()) else {
            return Err(source.truncated(Place::Line(lines.number()), "faces", face.count, found));
        };
        let mut words = line.words();
        for (i, property) in face.properties.iter().enumerate().take(list + 1) {
            let short = || source.bad_line(&line, format!("{} properties of a face", face.properties.len()));
            let word = words.next().ok_or_else(short)?;
            if property.list_length.is_none() {
                continue;
            }
            let length = source.count(&line, Some(word), "the length of a list")?;
            let items = (0..length).map(|_| position(source, &line, words.next()));
            let items = items.collect::<Result<Vec<u32>, _>>();
            if i == list {
                faces.push(items?);
            }
        }
    }
    Ok(faces)
}

/// Skips the lines of elements.
fn skip_lines(source: Source<'_>, lines: &mut Lines<'_>, before: &[Element<'_>]) -> Result<(), InputError> {
    for element in before.iter().filter(|e| !e.properties.is_empty()) {
        for found in 0..element.count {
            if !lines.any(|line| line.words().next().is_some()) {
                return Err(source.truncated(
                    Place::Line(lines.number()),
                    "elements before the vertices",
                    element.count,
                    found,
                ));
            }
        }
    }
    Ok(())
}

fn header<'a>(source: Source<'a>, lines: &mut Lines<'a>) -> Result<Header<'a>, InputError> {
    let first = lines.next().ok_or_else(|| source.truncated(Place::Line(1), "header line", 1, 0))?;
    if first.text.trim_ascii() != b"ply" {
        return Err(source.bad_line(&first, "the keyword ply"));
    }
    let mut format = None;
    let mut elements: Vec<Element<'a>> = Vec::new();
    for line in lines.by_ref() {
        let words: Vec<&[u8]> = line.words().take(6).collect();
        match words[..] {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", b"ascii", ..] => format = Some(None),
            [b"format", b"binary_little_endian", ..] => format = Some(Some(Endian::Little)),
            [b"format", b"binary_big_endian", ..] => format = Some(Some(Endian::Big)),
            [b"element", name, count] => {
                let count = source.count(&line, Some(count), "the number of elements")?;
                elements.push(Element { name, line: line.number, count, properties: Vec::new() });
            }
            [b"property", ref words @ ..] => {
                let element =
                    elements.last_mut().ok_or_else(|| source.bad_line(&line, "an element first"))?;
                element.properties.push(property(source, &line, words)?);
            }
            [b"end_header", ..] => {
                let endian =
                    format.ok_or_else(|| source.bad_line(&line, "a format line before the header ends"))?;
                return Ok(Header { endian, elements });
            }
            _ => return Err(source.bad_line(&line, "a line of a PLY header")),
        }
    }
    Err(source.truncated(Place::Line(lines.number()), "line `end_header`", 1, 0))
}

fn property<'a>(source: Source<'_>, line: &Line<'a>, words: &[&'a [u8]]) -> Result<Property<'a>, InputError> {
    let scalar = |word: &[u8]| {
        Scalar::of_ply(word)
            .ok_or_else(|| source.bad_word(line, word, "a PLY number type such as float or double"))
    };
    match *words {
        [b"list", length, kind, name] => {
            let length_type = scalar(length)?;
            if !length_type.is_integer() {
                return Err(source.bad_word(line, length, "a whole-number type for the length of a list"));
            }
            Ok(Property { name, list_length: Some(length_type), scalar: scalar(kind)? })
        }
        [kind, name] => Ok(Property { name, list_length: None, scalar: scalar(kind)? }),
        _ => Err(source.bad_line(line, "`property type name` or `property list type type name`")),
    }
}

/// Returns the positions of `x`, `y` and, if present, `z` among the properties.
fn axes(source: Source<'_>, vertex: &Element<'_>) -> Result<Vec<usize>, InputError> {
    let find = |name: &[u8]| vertex.properties.iter().position(|p| p.name == name && p.list_length.is_none());
    let (Some(x), Some(y)) = (find(b"x"), find(b"y")) else {
        let place = Place::Line(vertex.line);
        return Err(source.unsupported(
            place,
            "a vertex without properties x and y",
            "export the coordinates",
        ));
    };
    Ok([Some(x), Some(y), find(b"z")].into_iter().flatten().collect())
}

/// Returns the smallest size in bytes of an element in a binary file.
fn least_bytes(element: &Element<'_>) -> usize {
    element.properties.iter().map(|p| p.list_length.unwrap_or(p.scalar).size()).sum()
}

fn read_ascii(
    source: Source<'_>,
    lines: &mut Lines<'_>,
    before: &[Element<'_>],
    (vertex, axes): (&Element<'_>, &[usize]),
    points: &mut Collector<'_>,
) -> Result<(), InputError> {
    let filled = |line: &Line<'_>| line.words().next().is_some();
    skip_lines(source, lines, before)?;
    while points.met < vertex.count {
        let Some(line) = lines.find(filled) else {
            return Err(source.truncated(Place::Line(lines.number()), "points", vertex.count, points.met));
        };
        push_line(source, &line, (vertex, axes), points)?;
    }
    Ok(())
}

fn push_line(
    source: Source<'_>,
    line: &Line<'_>,
    (vertex, axes): (&Element<'_>, &[usize]),
    points: &mut Collector<'_>,
) -> Result<(), InputError> {
    let mut words = line.words();
    let mut found = [b"".as_slice(); 3];
    for (i, property) in vertex.properties.iter().enumerate() {
        let short = || source.bad_line(line, format!("{} properties of a vertex", vertex.properties.len()));
        let word = words.next().ok_or_else(short)?;
        if property.list_length.is_some() {
            let length = integer(word).and_then(|n| usize::try_from(n).ok());
            let length = length.ok_or_else(|| source.bad_word(line, word, "the length of a list"))?;
            if length > 0 {
                words.nth(length - 1).ok_or_else(short)?;
            }
        } else if let Some(axis) = axes.iter().position(|at| *at == i) {
            found[axis] = word;
        }
    }
    points.push_words(line, &mut found[..axes.len()].iter().copied())
}

/// A position in binary data.
struct Cursor<'a> {
    source: Source<'a>,
    offset: usize,
    endian: Endian,
}

impl<'a> Cursor<'a> {
    /// Returns the next `bytes` bytes, or `None` if fewer are left.
    fn take(&mut self, bytes: usize) -> Option<&'a [u8]> {
        let end = self.offset.checked_add(bytes)?;
        let taken = self.source.data.get(self.offset..end)?;
        self.offset = end;
        Some(taken)
    }

    /// Returns the bytes of a number, or of the items of a list.
    fn property(&mut self, property: &Property<'_>) -> Option<&'a [u8]> {
        let Some(length) = property.list_length else {
            return self.take(property.scalar.size());
        };
        let items = length.integer(self.take(length.size())?, self.endian);
        let bytes = usize::try_from(items).ok()?.checked_mul(property.scalar.size())?;
        self.take(bytes)
    }

    fn skip_element(&mut self, element: &Element<'_>) -> Result<(), InputError> {
        if element.properties.iter().all(|p| p.list_length.is_none()) {
            let bytes = usize::try_from(element.count).ok().and_then(|n| n.checked_mul(least_bytes(element)));
            if bytes.and_then(|bytes| self.take(bytes)).is_none() {
                return Err(self.cut("elements before the vertices", element.count, 0));
            }
            return Ok(());
        }
        for found in 0..element.count {
            for property in &element.properties {
                if self.property(property).is_none() {
                    return Err(self.cut("elements before the vertices", element.count, found));
                }
            }
        }
        Ok(())
    }

    fn cut(&self, what: &'static str, expected: u64, found: u64) -> InputError {
        self.source.truncated(Place::Byte(self.offset as u64), what, expected, found)
    }
}

fn read_binary(
    cursor: &mut Cursor<'_>,
    (vertex, axes): (&Element<'_>, &[usize]),
    points: &mut Collector<'_>,
) -> Result<(), InputError> {
    while points.met < vertex.count {
        let place = Place::Byte(cursor.offset as u64);
        let mut at = [0.0; 3];
        for (i, property) in vertex.properties.iter().enumerate() {
            let Some(bytes) = cursor.property(property) else {
                return Err(cursor.cut("points", vertex.count, points.met));
            };
            if let Some(axis) = axes.iter().position(|at| *at == i) {
                at[axis] = property.scalar.float(bytes, cursor.endian);
            }
        }
        points.push(place, &at[..axes.len()])?;
    }
    Ok(())
}
