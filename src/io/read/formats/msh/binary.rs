//! Gmsh `.msh`, versions 2.2 and 4.1, binary. Numbers have the byte order that the header shows.

use super::parts::{ADVICE, Tags, Version, kind};
use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::mesh::{CellKind, FileMesh};
use crate::read::points::{CoordinateType, ReadOptions};
use crate::read::scalar::{Endian, Scalar};
use crate::read::text::{Source, excerpt, integer};

/// The numbers of nodes of the types of elements, from type 1.
const NODES: [u8; 31] = [
    2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5, 6, 20, 35,
    56,
];

/// A position in the file.
struct Cursor<'a> {
    source: Source<'a>,
    at: usize,
    endian: Endian,
    version: Version,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, bytes: u64, what: &'static str, expected: u64) -> Result<&'a [u8], InputError> {
        let rest = &self.source.data[self.at..];
        let taken = usize::try_from(bytes).ok().and_then(|bytes| rest.get(..bytes));
        let found = (rest.len() as u64).saturating_mul(expected) / bytes.max(1);
        let place = Place::Byte(self.at as u64);
        let taken = taken.ok_or_else(|| self.source.truncated(place, what, expected, found))?;
        self.at += taken.len();
        Ok(taken)
    }

    /// Returns the next 32-bit number.
    fn int(&mut self) -> Result<i64, InputError> {
        let bytes = self.take(4, "numbers of a section", 1)?;
        Ok(Scalar::I32.integer(bytes, self.endian) as i64)
    }

    /// Returns the next number of 64 bits that is a count.
    fn size(&mut self) -> Result<u64, InputError> {
        let at = self.at;
        let bytes = self.take(8, "numbers of a section", 1)?;
        let count = Scalar::I64.integer(bytes, self.endian);
        let wrong = |_| self.source.malformed(at, count.to_string(), "a count");
        u64::try_from(count).map_err(wrong)
    }

    /// Returns the next line, without blanks at its ends.
    fn line(&mut self) -> &'a [u8] {
        let rest = &self.source.data[self.at..];
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += (end + 1).min(rest.len());
        rest[..end].trim_ascii()
    }

    /// Returns the name of the next section, which a line with `$` begins.
    fn section(&mut self) -> Option<&'a [u8]> {
        while self.at < self.source.data.len() {
            if let Some(name) = self.line().strip_prefix(b"$") {
                return Some(name);
            }
        }
        None
    }

    /// Goes to the end of a section of which all entries were read. Only blanks may precede its last line.
    fn close(&mut self, name: &[u8]) -> Result<(), InputError> {
        let before = self.at;
        let rest = self.skip(name)?;
        if let Some(more) = rest.iter().position(|b| !b.is_ascii_whitespace()) {
            let found = format!("more bytes in ${}", excerpt(name));
            let expected = "the end of the section after the announced number";
            return Err(self.source.malformed(before + more, found, expected));
        }
        Ok(())
    }

    /// Goes to the end of a section. Returns the bytes before its last line.
    fn skip(&mut self, name: &[u8]) -> Result<&'a [u8], InputError> {
        let mark = [b"$End", name].concat();
        let rest = &self.source.data[self.at..];
        let found = rest.windows(mark.len()).position(|w| w.eq_ignore_ascii_case(&mark));
        let place = Place::Byte(self.at as u64);
        let found = found.ok_or_else(|| self.source.truncated(place, "lines closing a section", 1, 0))?;
        let before = &rest[..found];
        self.at += found;
        self.line();
        Ok(before)
    }

    /// Returns the number of nodes or elements of version 2.2, which is text.
    fn count(&mut self) -> Result<u64, InputError> {
        let at = self.at;
        let line = self.line();
        let count = integer(line).and_then(|count| u64::try_from(count).ok());
        count.ok_or_else(|| self.source.malformed(at, format!("\"{}\"", excerpt(line)), "a count"))
    }
}

/// Reads the mesh of a file whose format line has the number 1.
pub(super) fn parse<'a>(source: Source<'a>, options: &ReadOptions) -> Result<FileMesh<'a>, InputError> {
    let mut cursor = Cursor { source, at: 0, endian: Endian::Little, version: Version::FourOne };
    let mut nodes: Option<(FileMesh<'a>, Tags)> = None;
    while let Some(name) = cursor.section() {
        match (name.to_ascii_lowercase().as_slice(), &mut nodes) {
            (b"meshformat", _) => cursor.format()?,
            (b"nodes", None) => {
                nodes = Some(cursor.nodes(options)?);
                cursor.close(name)?;
                continue;
            }
            (b"elements", Some((mesh, tags))) => {
                cursor.elements(mesh, tags)?;
                cursor.close(name)?;
                continue;
            }
            (b"nodes" | b"elements", _) => {
                let found = format!("a section ${}", excerpt(name));
                return Err(source.malformed(cursor.at, found, "one section $Nodes before the $Elements"));
            }
            _ => {}
        }
        cursor.skip(name)?;
    }
    let missing = || source.truncated(Place::Byte(source.data.len() as u64), "section $Nodes", 1, 0);
    nodes.map(|(mesh, _)| mesh).ok_or_else(missing)
}

impl<'a> Cursor<'a> {
    /// Reads the version and the number 1, which shows the byte order.
    fn format(&mut self) -> Result<(), InputError> {
        let (source, at) = (self.source, self.at);
        let line = self.line();
        let words: Vec<&[u8]> = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
        self.version = match words[..] {
            [b"4.1", _, b"8"] => Version::FourOne,
            [version, _, b"8"] if version == b"2" || version.starts_with(b"2.") => Version::Two,
            _ => {
                let what = format!("a binary .msh file of the version {}", excerpt(line));
                return Err(source.unsupported(Place::Byte(at as u64), what, ADVICE));
            }
        };
        let one = self.take(4, "bytes of the byte order", 4)?;
        self.endian = match one {
            [1, 0, 0, 0] => Endian::Little,
            [0, 0, 0, 1] => Endian::Big,
            _ => return Err(source.malformed(at, format!("{one:?}"), "the number 1 in 32 bits")),
        };
        Ok(())
    }

    fn nodes(&mut self, options: &ReadOptions) -> Result<(FileMesh<'a>, Tags), InputError> {
        let (source, start) = (self.source, self.at);
        let (blocks, announced) = match self.version {
            Version::Two => (1, self.count()?),
            Version::FourOne => {
                let counts = (self.size()?, self.size()?);
                self.take(16, "numbers of a section", 2)?;
                counts
            }
        };
        let bytes = source.data.len() - self.at;
        let place = Place::Byte(start as u64);
        let mut points = Collector::new(source, options, (place, 3), (announced, bytes, 28))?;
        points.coordinate_type = Some(CoordinateType::Float64);
        let mut tags = Vec::new();
        for _ in 0..blocks {
            self.block_of_nodes(announced, &mut tags, &mut points)?;
        }
        if points.met > announced {
            return Err(source.surplus(place, "nodes", announced));
        }
        points.complete(place, announced)?;
        let tags = Tags::new(&tags);
        if tags.doubled() {
            return Err(source.malformed(start, "a tag that occurs twice", "nodes with distinct tags"));
        }
        let base = u64::try_from(tags.first).unwrap_or(0);
        Ok((FileMesh::new(source, points, base), tags))
    }

    fn block_of_nodes(
        &mut self,
        announced: u64,
        tags: &mut Vec<i64>,
        points: &mut Collector<'_>,
    ) -> Result<(), InputError> {
        let endian = self.endian;
        if self.version == Version::Two {
            let start = self.at;
            let rows = self.take(announced.saturating_mul(28), "nodes", announced)?;
            for (i, row) in rows.chunks_exact(28).enumerate() {
                tags.push(Scalar::I32.integer(row, endian) as i64);
                push(points, start + 28 * i + 4, &row[4..], endian)?;
            }
            return Ok(());
        }
        let (dimension, _, parametric) = (self.int()?, self.int()?, self.int()?);
        let count = self.size()?;
        let of_tags = self.take(count.saturating_mul(8), "nodes", count)?;
        tags.extend(of_tags.chunks_exact(8).map(|tag| Scalar::I64.integer(tag, endian) as i64));
        let more = if parametric == 0 { 0 } else { dimension.clamp(0, 3) as usize };
        let width = 24 + 8 * more;
        let start = self.at;
        let rows = self.take(count.saturating_mul(width as u64), "nodes", count)?;
        for (i, row) in rows.chunks_exact(width).enumerate() {
            push(points, start + width * i, row, endian)?;
        }
        Ok(())
    }

    fn elements(&mut self, mesh: &mut FileMesh<'_>, tags: &Tags) -> Result<(), InputError> {
        let place = Place::Byte(self.at as u64);
        let (blocks, announced) = match self.version {
            Version::Two => (u64::MAX, self.count()?),
            Version::FourOne => {
                let counts = (self.size()?, self.size()?);
                self.take(16, "numbers of a section", 2)?;
                counts
            }
        };
        let (mut block, mut found) = (0, 0_u64);
        while block < blocks && (self.version == Version::FourOne || found < announced) {
            block += 1;
            found = found.saturating_add(self.block_of_elements(mesh, tags)?);
        }
        if found > announced {
            return Err(self.source.surplus(place, "elements", announced));
        }
        if found < announced {
            return Err(self.source.truncated(place, "elements", announced, found));
        }
        Ok(())
    }

    /// Reads a block of elements of one type. Returns their number.
    fn block_of_elements(&mut self, mesh: &mut FileMesh<'_>, tags: &Tags) -> Result<u64, InputError> {
        let (source, start, endian) = (self.source, self.at, self.endian);
        // The numbers of an element before its nodes: its own tag, and in version 2.2 the tags of its groups.
        let (element, count, before, scalar) = match self.version {
            Version::Two => {
                let (element, count, tags) = (self.int()?, self.int()?, self.int()?);
                (element, u64::try_from(count).unwrap_or(0), 1 + tags.clamp(0, 1 << 20) as usize, Scalar::I32)
            }
            Version::FourOne => {
                let (_, _, element) = (self.int()?, self.int()?, self.int()?);
                (element, self.size()?, 1, Scalar::I64)
            }
        };
        if count == 0 && self.version == Version::Two {
            return Err(source.malformed(start, "a block of no elements", "a number of elements"));
        }
        let nodes = usize::try_from(element - 1).ok().and_then(|at| NODES.get(at).copied());
        let Some(nodes) = nodes else {
            let what = format!("an element of Gmsh type {element}");
            return Err(source.unsupported(
                Place::Byte(start as u64),
                what,
                "save a mesh of at most third order",
            ));
        };
        let (nodes, size) = (usize::from(nodes), scalar.size());
        let width = (before + nodes) * size;
        let first = self.at;
        let rows = self.take(count.saturating_mul(width as u64), "elements", count)?;
        let kind = kind(element);
        if kind == CellKind::Other && count > 0 && mesh.other.is_none() {
            mesh.other = Some((Place::Byte(start as u64), format!("a cell of Gmsh type {element}")));
        }
        let Some(list) = mesh.list(kind) else { return Ok(count) };
        for (i, row) in rows.chunks_exact(width).enumerate() {
            for (j, node) in row[before * size..].chunks_exact(size).enumerate() {
                let tag = scalar.integer(node, endian);
                let place = Place::Byte((first + i * width + (before + j) * size) as u64);
                let index = i64::try_from(tag).ok().and_then(|tag| tags.index(tag));
                list.flat.push(index.ok_or_else(|| list.out_of_range(place, tag))?);
            }
        }
        Ok(count)
    }
}

/// Adds a point of three doubles at an offset of the file.
fn push(points: &mut Collector<'_>, offset: usize, bytes: &[u8], endian: Endian) -> Result<(), InputError> {
    let mut at = [0.0; 3];
    for (slot, bytes) in at.iter_mut().zip(bytes.chunks_exact(8)) {
        *slot = Scalar::F64.float(bytes, endian);
    }
    points.push(Place::Byte(offset as u64), &at)
}
