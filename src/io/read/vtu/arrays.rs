//! The arrays of a `.vtu` file and their numbers.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::super::error::{InputError, Place};
use super::super::scalar::{Endian, Scalar};
use super::super::text::{NUMBER, Source, excerpt};
use super::base64;
use super::xml::{Tag, next_tag};

/// How the numbers of an array are stored.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Storage {
    Ascii,
    Base64,
    Appended(u64),
}

/// One array, not yet decoded.
pub(super) struct DataArray<'a> {
    scalar: Scalar,
    /// Numbers per row.
    pub components: u64,
    storage: Storage,
    /// What stands between its tags.
    text: &'a [u8],
    /// Where it is declared.
    pub offset: usize,
}

/// The appended data: after the underscore.
struct Appended<'a> {
    raw: bool,
    data: &'a [u8],
    offset: usize,
}

/// The file's arrays that matter.
pub(super) struct Arrays<'a> {
    pub source: Source<'a>,
    endian: Endian,
    wide_header: bool,
    zlib: bool,
    pub point_count: u64,
    pub cell_count: u64,
    pub points: Option<DataArray<'a>>,
    pub connectivity: Option<DataArray<'a>>,
    pub offsets: Option<DataArray<'a>>,
    pub types: Option<DataArray<'a>>,
    appended: Option<Appended<'a>>,
}

/// Finds the arrays.
pub(super) fn open(source: Source<'_>) -> Result<Arrays<'_>, InputError> {
    let data = source.data;
    let root = loop_to(data, b"VTKFile")
        .ok_or_else(|| source.malformed(0, "no tag VTKFile", "a VTK XML file"))?;
    let mut grid = root_of(source, &root)?;
    let mut at = root.end;
    let mut section: &[u8] = b"";
    let mut pieces = 0;
    while let Some(tag) = next_tag(data, at) {
        at = tag.end;
        match (tag.name, tag.closing) {
            (b"Piece", false) => {
                pieces += 1;
                grid.point_count = attribute_count(source, &tag, "NumberOfPoints")?;
                grid.cell_count = attribute_count(source, &tag, "NumberOfCells")?;
            }
            (b"Points" | b"Cells" | b"PointData" | b"CellData" | b"FieldData", closing) => {
                section = if closing { b"" } else { tag.name };
            }
            (b"DataArray", false) => {
                let (text, end) = if tag.empty {
                    (b"".as_slice(), at)
                } else {
                    content(source, &tag)?
                };
                at = end;
                let name = tag.attribute("Name").unwrap_or_default();
                let slot = match (section, name) {
                    (b"Points", _) => &mut grid.points,
                    (b"Cells", "connectivity") => &mut grid.connectivity,
                    (b"Cells", "offsets") => &mut grid.offsets,
                    (b"Cells", "types") => &mut grid.types,
                    _ => continue,
                };
                *slot = Some(declared(source, &tag, text)?);
            }
            (b"AppendedData", false) => {
                grid.appended = Some(appended(source, &tag)?);
                break;
            }
            (b"VTKFile", true) => break,
            _ => {}
        }
    }
    match pieces {
        1 => Ok(grid),
        0 => Err(source.truncated(Place::Byte(data.len() as u64), "pieces", 1, 0)),
        _ => Err(source.unsupported(
            Place::Byte(at as u64),
            format!("a .vtu file of {pieces} pieces"),
            "merge the pieces",
        )),
    }
}

/// The first tag of this name.
fn loop_to<'a>(data: &'a [u8], name: &[u8]) -> Option<Tag<'a>> {
    let mut tag = next_tag(data, 0)?;
    while tag.name != name {
        tag = next_tag(data, tag.end)?;
    }
    Some(tag)
}

fn root_of<'a>(source: Source<'a>, root: &Tag<'_>) -> Result<Arrays<'a>, InputError> {
    let place = Place::Byte(root.start as u64);
    if root.attribute("type") != Some("UnstructuredGrid") {
        let what = format!(
            "VTK data of type {:?}",
            root.attribute("type").unwrap_or_default()
        );
        return Err(source.unsupported(place, what, "save an unstructured grid (.vtu)"));
    }
    let compressor = root.attribute("compressor");
    if compressor.is_some_and(|c| c != "vtkZLibDataCompressor" && !c.is_empty()) {
        let what = format!("compression by {:?}", compressor.unwrap_or_default());
        return Err(source.unsupported(place, what, "save it uncompressed or with zlib"));
    }
    Ok(Arrays {
        source,
        endian: if root.attribute("byte_order") == Some("BigEndian") {
            Endian::Big
        } else {
            Endian::Little
        },
        wide_header: root.attribute("header_type") == Some("UInt64"),
        zlib: compressor.is_some_and(|c| !c.is_empty()),
        point_count: 0,
        cell_count: 0,
        points: None,
        connectivity: None,
        offsets: None,
        types: None,
        appended: None,
    })
}

fn attribute_count(
    source: Source<'_>,
    tag: &Tag<'_>,
    name: &'static str,
) -> Result<u64, InputError> {
    let value = tag.attribute(name);
    let shown = || {
        format!(
            "{name} = {:?}",
            excerpt(value.unwrap_or_default().as_bytes())
        )
    };
    value
        .and_then(|v| v.trim().parse().ok())
        .ok_or_else(|| source.malformed(tag.start, shown(), "a count"))
}

/// The longest text directly inside an array, and where the array ends.
fn content<'a>(source: Source<'a>, opening: &Tag<'_>) -> Result<(&'a [u8], usize), InputError> {
    let (mut at, mut depth, mut text) = (opening.end, 0_usize, b"".as_slice());
    loop {
        let missing = || {
            source.truncated(
                Place::Byte(opening.start as u64),
                "tag closing a DataArray",
                1,
                0,
            )
        };
        let tag = next_tag(source.data, at).ok_or_else(missing)?;
        let run = source.data[at..tag.start].trim_ascii();
        if depth == 0 && run.len() > text.len() {
            text = run;
        }
        at = tag.end;
        match (tag.closing, tag.empty) {
            (true, _) if depth == 0 => return Ok((text, at)),
            (true, _) => depth -= 1,
            (false, false) => depth += 1,
            (false, true) => {}
        }
    }
}

fn declared<'a>(
    source: Source<'_>,
    tag: &Tag<'_>,
    text: &'a [u8],
) -> Result<DataArray<'a>, InputError> {
    let kind = tag.attribute("type").unwrap_or_default();
    let scalar = Scalar::of_vtk(kind);
    let scalar = scalar.ok_or_else(|| {
        source.malformed(tag.start, format!("type {kind:?}"), "a VTK number type")
    })?;
    let components = match tag.attribute("NumberOfComponents") {
        Some(_) => attribute_count(source, tag, "NumberOfComponents")?,
        None => 1,
    };
    let storage = match tag.attribute("format").unwrap_or("ascii") {
        "ascii" => Storage::Ascii,
        "binary" => Storage::Base64,
        "appended" => Storage::Appended(attribute_count(source, tag, "offset")?),
        other => {
            return Err(source.malformed(
                tag.start,
                format!("format {other:?}"),
                "ascii, binary or appended",
            ));
        }
    };
    Ok(DataArray {
        scalar,
        components,
        storage,
        text,
        offset: tag.start,
    })
}

fn appended<'a>(source: Source<'a>, tag: &Tag<'_>) -> Result<Appended<'a>, InputError> {
    let raw = match tag.attribute("encoding") {
        Some("raw") => true,
        Some("base64") => false,
        other => {
            let found = format!("encoding {:?}", other.unwrap_or_default());
            return Err(source.malformed(tag.start, found, "raw or base64"));
        }
    };
    let rest = &source.data[tag.end..];
    let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
    if rest.get(blanks) != Some(&b'_') {
        return Err(source.malformed(
            tag.end + blanks,
            "no underscore",
            "an underscore before the appended data",
        ));
    }
    let offset = tag.end + blanks + 1;
    Ok(Appended {
        raw,
        data: &source.data[offset..],
        offset,
    })
}

impl<'a> Arrays<'a> {
    /// All numbers of an array.
    pub fn values<T>(
        &self,
        array: &DataArray<'a>,
        from_bytes: impl Fn(Scalar, &[u8], Endian) -> T,
        from_word: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<Vec<T>, InputError> {
        let source = self.source;
        if array.storage == Storage::Ascii {
            let words = array
                .text
                .split(u8::is_ascii_whitespace)
                .filter(|w| !w.is_empty());
            let value = |word: &[u8]| {
                let offset = (word.as_ptr() as usize).wrapping_sub(source.data.as_ptr() as usize);
                from_word(word).ok_or_else(|| {
                    source.malformed(offset, format!("\"{}\"", excerpt(word)), NUMBER)
                })
            };
            return words.map(value).collect();
        }
        let (bytes, offset) = self.bytes(array)?;
        let numbers = bytes.chunks_exact(array.scalar.size());
        if !numbers.remainder().is_empty() {
            return Err(source.malformed(
                offset,
                format!("{} bytes", bytes.len()),
                "a whole number of array elements",
            ));
        }
        Ok(numbers
            .map(|b| from_bytes(array.scalar, b, self.endian))
            .collect())
    }

    /// The bytes of an array without their counts, and where they begin.
    fn bytes(&self, array: &DataArray<'a>) -> Result<(Cow<'a, [u8]>, usize), InputError> {
        let source = self.source;
        let text = |text: &[u8], offset: usize| {
            base64::decode(text).ok_or_else(|| {
                source.malformed(offset, "damaged base64", "base64 in groups of four")
            })
        };
        let (stored, offset): (Cow<'a, [u8]>, usize) = match array.storage {
            Storage::Ascii | Storage::Base64 => {
                (text(array.text, array.offset)?.into(), array.offset)
            }
            Storage::Appended(at) => {
                let missing = || {
                    source.truncated(
                        Place::Byte(array.offset as u64),
                        "sections of appended data",
                        1,
                        0,
                    )
                };
                let appended = self.appended.as_ref().ok_or_else(missing)?;
                let length = appended.data.len() as u64;
                let rest = usize::try_from(at)
                    .ok()
                    .and_then(|at| appended.data.get(at..));
                let place = Place::Byte(array.offset as u64);
                let rest = rest
                    .ok_or_else(|| source.truncated(place, "bytes of appended data", at, length))?;
                let offset = appended.offset + at as usize;
                if appended.raw {
                    (rest.into(), offset)
                } else {
                    (text(rest, offset)?.into(), offset)
                }
            }
        };
        let taken = if self.zlib {
            self.inflate(&stored, offset)?.into()
        } else {
            self.plain(stored, offset)?
        };
        Ok((taken, offset))
    }

    /// A count, and what follows it.
    fn count<'s>(&self, stored: &'s [u8], offset: usize) -> Result<(u64, &'s [u8]), InputError> {
        let scalar = if self.wide_header {
            Scalar::U64
        } else {
            Scalar::U32
        };
        let short = || self.short(offset, scalar.size() as u64, stored.len() as u64);
        let (head, rest) = stored.split_at_checked(scalar.size()).ok_or_else(short)?;
        Ok((
            u64::try_from(scalar.integer(head, self.endian)).unwrap_or(u64::MAX),
            rest,
        ))
    }

    fn short(&self, offset: usize, expected: u64, found: u64) -> InputError {
        self.source.truncated(
            Place::Byte(offset as u64),
            "bytes of an array",
            expected,
            found,
        )
    }

    fn plain(&self, stored: Cow<'a, [u8]>, offset: usize) -> Result<Cow<'a, [u8]>, InputError> {
        let (length, rest) = self.count(&stored, offset)?;
        let found = rest.len() as u64;
        if length > found {
            return Err(self.short(offset, length, found));
        }
        let start = stored.len() - rest.len();
        let range = start..start + length as usize;
        Ok(match stored {
            Cow::Borrowed(stored) => Cow::Borrowed(&stored[range]),
            Cow::Owned(stored) => Cow::Owned(stored[range].to_vec()),
        })
    }

    /// Blocks, each preceded in a table by its compressed length.
    fn inflate(&self, stored: &[u8], offset: usize) -> Result<Vec<u8>, InputError> {
        let (blocks, rest) = self.count(stored, offset)?;
        let (block_size, rest) = self.count(rest, offset)?;
        let (_last, mut table) = self.count(rest, offset)?;
        let entry = if self.wide_header { 8 } else { 4 };
        let start = usize::try_from(blocks)
            .ok()
            .and_then(|n| n.checked_mul(entry))
            .filter(|n| *n <= table.len());
        let start =
            start.ok_or_else(|| self.short(offset, blocks, (table.len() / entry) as u64))?;
        let mut data = &table[start..];
        let mut bytes = Vec::new();
        for _ in 0..blocks {
            let length;
            (length, table) = self.count(table, offset)?;
            let short = || self.short(offset, length, data.len() as u64);
            let split = usize::try_from(length)
                .ok()
                .and_then(|n| data.split_at_checked(n));
            let (block, rest) = split.ok_or_else(short)?;
            data = rest;
            let damaged = |_| {
                self.source
                    .malformed(offset, "damaged zlib data", "a zlib block")
            };
            ZlibDecoder::new(block)
                .take(block_size)
                .read_to_end(&mut bytes)
                .map_err(damaged)?;
        }
        Ok(bytes)
    }
}
