//! Legacy VTK files, `.vtk`, ASCII and binary, versions up to 5.1: polygonal data and unstructured grids.
//!
//! The keywords are text lines. Binary arrays are big-endian and begin right after the line of their keyword. The cells
//! of version 5.1 are an array of offsets and an array of point ids. In older versions, each row has a count and ids.
//! The reader stops at the point data and cell data, which follow the geometry.

use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::mesh::{CellKind, FileMesh};
use crate::read::points::ReadOptions;
use crate::read::scalar::{Endian, Scalar};
use crate::read::text::{Source, excerpt, expected, integer, is_blank, line_feeds, number};

/// A position in the file.
struct Cursor<'a> {
    source: Source<'a>,
    at: usize,
    is_binary: bool,
    /// An offset up to which lines are counted, and the number of line feeds before it.
    counted: (usize, u64),
}

/// The values of one array, and their locations in the file.
struct Values<T> {
    items: Vec<T>,
    /// The offset of the array in the file. Binary values have `size` bytes each.
    start: usize,
    size: usize,
}

/// The ids of the points of cells, one list per cell.
struct CellArrays {
    /// The end of each cell in `ids`.
    ends: Vec<u64>,
    ids: Vec<i64>,
    place: Place,
}

/// Reads the points and the cells.
pub fn parse<'a>(source: Source<'a>, options: &ReadOptions) -> Result<FileMesh<'a>, InputError> {
    let options = &ReadOptions { dimension: None, ..options.clone() };
    let mut cursor = open(source)?;
    let mut mesh: Option<FileMesh<'a>> = None;
    let mut pending: Option<CellArrays> = None;
    while let Some((offset, words)) = cursor.keyword() {
        let keyword = String::from_utf8_lossy(words[0]).to_ascii_uppercase();
        match (keyword.as_str(), &mut mesh) {
            ("POINTS", None) => {
                mesh = Some(FileMesh::new(source, cursor.points(offset, &words, options)?, 0));
            }
            ("FIELD", _) => cursor.skip_fields(offset, &words)?,
            ("METADATA", _) => cursor.skip_paragraph(),
            ("CELLS", Some(_)) => pending = Some(cursor.cells(offset, &words)?),
            ("CELL_TYPES", Some(mesh)) => {
                let count = cursor.count(offset, words.get(1))?;
                let types = cursor.values(count, Scalar::I32, |s, b, e| s.integer(b, e) as i64, integer)?;
                let cells = pending.take().filter(|cells| cells.ends.len() == types.items.len());
                let cells =
                    cells.ok_or_else(|| source.bad_at(offset, "CELL_TYPES", "as many types as CELLS"))?;
                push(mesh, &cells, |i, nodes| kind_of_type(types.items[i], nodes))?;
            }
            ("POLYGONS", Some(mesh)) => {
                let cells = cursor.cells(offset, &words)?;
                push(mesh, &cells, |_, nodes| if nodes == 3 { CellKind::Triangle } else { CellKind::Other })?;
            }
            ("VERTICES" | "LINES", Some(_)) => drop(cursor.cells(offset, &words)?),
            ("TRIANGLE_STRIPS", Some(mesh)) => {
                let place = cursor.place(offset);
                mesh.other.get_or_insert((place, "a triangle strip".to_owned()));
                cursor.cells(offset, &words)?;
            }
            ("POINT_DATA" | "CELL_DATA", _) => break,
            _ => return Err(source.bad_at(offset, excerpt(words[0]), "a keyword such as POINTS or CELLS")),
        }
    }
    if let Some(cells) = pending {
        return Err(source.truncated(cells.place, "sections CELL_TYPES", 1, 0));
    }
    mesh.ok_or_else(|| source.truncated(Place::Line(source.line_at(cursor.at)), "sections POINTS", 1, 0))
}

/// Reads the four header lines.
fn open(source: Source<'_>) -> Result<Cursor<'_>, InputError> {
    if !source.data.starts_with(b"# vtk DataFile") {
        return Err(source.bad_at(
            0,
            excerpt(source.data.split(|b| *b == b'\n').next().unwrap_or_default()),
            "# vtk DataFile Version",
        ));
    }
    let mut cursor = Cursor { source, at: 0, is_binary: false, counted: (0, 0) };
    cursor.line();
    cursor.line();
    let (offset, words) = cursor.keyword().unwrap_or((source.data.len(), vec![b""]));
    cursor.is_binary = match words[0].to_ascii_uppercase().as_slice() {
        b"ASCII" => false,
        b"BINARY" => true,
        other => return Err(source.bad_at(offset, excerpt(other), "ASCII or BINARY")),
    };
    let (offset, words) = cursor.keyword().unwrap_or((source.data.len(), vec![b""]));
    match (words[0].to_ascii_uppercase().as_slice(), words.get(1).map(|w| w.to_ascii_uppercase()).as_deref())
    {
        (b"DATASET", Some(b"POLYDATA" | b"UNSTRUCTURED_GRID")) => Ok(cursor),
        (b"DATASET", Some(kind)) => {
            let what = format!("a VTK dataset of type {}", excerpt(kind));
            let advice = "save an unstructured grid or polygonal data";
            Err(source.unsupported(Place::Line(source.line_at(offset)), what, advice))
        }
        (other, _) => {
            Err(source.bad_at(offset, excerpt(other), "DATASET POLYDATA or DATASET UNSTRUCTURED_GRID"))
        }
    }
}

impl<'a> Cursor<'a> {
    /// Returns the next line without its line ending.
    fn line(&mut self) -> &'a [u8] {
        let rest = &self.source.data[self.at..];
        let end = rest.iter().position(|b| *b == b'\n');
        self.at += end.map_or(rest.len(), |end| end + 1);
        rest[..end.unwrap_or(rest.len())].trim_ascii_end()
    }

    /// Returns the offset and the words of the next line that is not blank, or `None` at the end of the file.
    fn keyword(&mut self) -> Option<(usize, Vec<&'a [u8]>)> {
        while self.at < self.source.data.len() {
            let offset = self.at;
            let line = self.line();
            let words: Vec<&[u8]> = line.split(|b| is_blank(*b)).filter(|w| !w.is_empty()).take(5).collect();
            if !words.is_empty() {
                return Some((offset, words));
            }
        }
        None
    }

    /// Returns the line of an offset that is not before those of earlier calls. All calls together take linear time.
    fn place(&mut self, offset: usize) -> Place {
        let (from, feeds) = self.counted;
        let between = self.source.data.get(from..offset).unwrap_or_default();
        self.counted = (offset, feeds + line_feeds(between));
        Place::Line(self.counted.1 + 1)
    }

    fn count(&self, offset: usize, word: Option<&&[u8]>) -> Result<u64, InputError> {
        let word = word.copied().unwrap_or_default();
        let count = integer(word).and_then(|n| u64::try_from(n).ok());
        count.ok_or_else(|| self.source.bad_at(offset, excerpt(word), "a count"))
    }

    fn scalar(&self, offset: usize, word: Option<&&[u8]>) -> Result<Scalar, InputError> {
        let word = word.copied().unwrap_or_default();
        Scalar::of_legacy_vtk(&word.to_ascii_lowercase())
            .ok_or_else(|| self.source.bad_at(offset, excerpt(word), "a VTK number type such as double"))
    }

    /// Reads an array of numbers.
    fn values<T>(
        &mut self,
        count: u64,
        scalar: Scalar,
        from_bytes: impl Fn(Scalar, &[u8], Endian) -> T,
        from_word: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<Values<T>, InputError> {
        let (source, start) = (self.source, self.at);
        let rest = &source.data[start..];
        let place =
            || if self.is_binary { Place::Byte(start as u64) } else { Place::Line(source.line_at(start)) };
        if self.is_binary {
            let size = scalar.size();
            let bytes =
                usize::try_from(count).ok().and_then(|n| n.checked_mul(size)).and_then(|n| rest.get(..n));
            let bytes = bytes
                .ok_or_else(|| source.truncated(place(), "numbers", count, (rest.len() / size) as u64))?;
            let values = bytes.chunks_exact(size).map(|b| from_bytes(scalar, b, Endian::Big)).collect();
            self.at += bytes.len();
            return Ok(Values { items: values, start, size });
        }
        let mut values = Vec::new();
        let mut at = start;
        while (values.len() as u64) < count {
            let blanks = source.data[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
            at += blanks;
            let word = source.data[at..].split(u8::is_ascii_whitespace).next().unwrap_or_default();
            if word.is_empty() {
                return Err(source.truncated(place(), "numbers", count, values.len() as u64));
            }
            values.push(from_word(word).ok_or_else(|| source.bad_at(at, excerpt(word), expected(word)))?);
            at += word.len();
        }
        self.at = at;
        Ok(Values { items: values, start, size: 0 })
    }

    /// Reads `POINTS count type`, then three coordinates per point.
    fn points(
        &mut self,
        offset: usize,
        words: &[&[u8]],
        options: &ReadOptions,
    ) -> Result<Collector<'a>, InputError> {
        let source = self.source;
        let count = self.count(offset, words.get(1))?;
        let scalar = self.scalar(offset, words.get(2))?;
        let read = self.values(count.saturating_mul(3), scalar, Scalar::float, number)?;
        let line = Place::Line(source.line_at(offset));
        let mut points = Collector::new(source, options, (line, 3), (count, read.items.len(), 3))?;
        points.coordinate_type = self.is_binary.then(|| scalar.coordinate_type());
        for (i, at) in read.items.chunks_exact(3).enumerate() {
            let axis = at.iter().position(|c| !c.is_finite()).unwrap_or(0);
            let byte = (read.start + (3 * i + axis) * read.size) as u64;
            let place = if self.is_binary { Place::Byte(byte) } else { line };
            points.push(place, at)?;
        }
        Ok(points)
    }

    /// Reads the lists of point ids after a keyword: rows of a count and ids, or the two arrays of version
    /// 5.1.
    fn cells(&mut self, offset: usize, words: &[&[u8]]) -> Result<CellArrays, InputError> {
        let source = self.source;
        let place = self.place(offset);
        let first = self.count(offset, words.get(1))?;
        let second = self.count(offset, words.get(2))?;
        let narrow = |scalar: Scalar, bytes: &[u8], endian| {
            i64::try_from(scalar.integer(bytes, endian)).unwrap_or(i64::MAX)
        };
        let before = self.at;
        if let Some((at, next)) = self.keyword()
            && next[0].eq_ignore_ascii_case(b"OFFSETS")
        {
            let scalar = self.scalar(at, next.get(1))?;
            let offsets = self.values(first, scalar, narrow, integer)?.items;
            let Some((at, next)) =
                self.keyword().filter(|(_, next)| next[0].eq_ignore_ascii_case(b"CONNECTIVITY"))
            else {
                return Err(source.truncated(place, "sections CONNECTIVITY", 1, 0));
            };
            let scalar = self.scalar(at, next.get(1))?;
            let ids = self.values(second, scalar, narrow, integer)?.items;
            let ends = offsets.iter().skip(1).map(|&end| u64::try_from(end).unwrap_or(u64::MAX)).collect();
            return Ok(CellArrays { ends, ids, place });
        }
        self.at = before;
        let flat = self.values(second, Scalar::I32, narrow, integer)?.items;
        let (mut ends, mut ids) = (Vec::new(), Vec::new());
        let mut rest = flat.as_slice();
        for found in 0..first {
            let row = rest
                .split_first()
                .and_then(|(count, rest)| rest.split_at_checked(usize::try_from(*count).ok()?));
            let Some((row, tail)) = row else { return Err(source.truncated(place, "cells", first, found)) };
            ids.extend_from_slice(row);
            ends.push(ids.len() as u64);
            rest = tail;
        }
        if !rest.is_empty() {
            return Err(source.surplus(place, "cells", first));
        }
        Ok(CellArrays { ends, ids, place })
    }

    /// Skips `FIELD name count` and its arrays `name components tuples type`.
    fn skip_fields(&mut self, offset: usize, words: &[&[u8]]) -> Result<(), InputError> {
        let source = self.source;
        let arrays = self.count(offset, words.get(2))?;
        for found in 0..arrays {
            let missing =
                || source.truncated(Place::Line(source.line_at(offset)), "arrays of a field", arrays, found);
            let (at, words) = self.keyword().ok_or_else(missing)?;
            let numbers = self.count(at, words.get(1))?.saturating_mul(self.count(at, words.get(2))?);
            if words.get(3).is_some_and(|kind| *kind == b"string") {
                for _ in 0..numbers.min(source.data.len() as u64) {
                    self.line();
                }
                continue;
            }
            let scalar = self.scalar(at, words.get(3))?;
            self.values(numbers, scalar, |_, _, _| (), |_| Some(()))?;
        }
        Ok(())
    }

    /// Skips the lines up to a blank line.
    fn skip_paragraph(&mut self) {
        while self.at < self.source.data.len() && !self.line().is_empty() {}
    }
}

/// Adds cells to the lists of their kinds.
fn push(
    mesh: &mut FileMesh<'_>,
    cells: &CellArrays,
    kind: impl Fn(usize, usize) -> CellKind,
) -> Result<(), InputError> {
    let place = cells.place;
    let mut start = 0;
    for (i, &end) in cells.ends.iter().enumerate() {
        let nodes = usize::try_from(end).ok().and_then(|end| cells.ids.get(start..end));
        let nodes = nodes
            .ok_or_else(|| mesh.source.truncated(place, "point ids of cells", end, cells.ids.len() as u64))?;
        start += nodes.len();
        let kind = kind(i, nodes.len());
        if kind == CellKind::Other {
            mesh.other.get_or_insert_with(|| (place, format!("a cell with {} points", nodes.len())));
        }
        if let Some(list) = mesh.list(kind) {
            for node in nodes {
                list.push(place, i128::from(*node))?;
            }
        }
    }
    Ok(())
}

/// Returns the kind of a cell by its VTK type and its number of points.
pub fn kind_of_type(vtk: i64, nodes: usize) -> CellKind {
    match (vtk, nodes) {
        (1..=4, _) => CellKind::Lower,
        (5, 3) => CellKind::Triangle,
        (10, 4) => CellKind::Tetrahedron,
        _ => CellKind::Other,
    }
}
