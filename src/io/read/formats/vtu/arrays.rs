//! The arrays of a `.vtu` or `.vtp` file: their locations and encodings.

use super::xml::{Tag, next_tag};
use crate::read::error::{InputError, Place};
use crate::read::scalar::{Endian, Scalar};
use crate::read::text::{Source, excerpt};

/// The encoding of the numbers of an array.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    Ascii,
    Base64,
    Appended(u64),
}

/// An array before decoding.
pub struct DataArray<'a> {
    pub scalar: Scalar,
    /// The number of values per row.
    pub components: u64,
    pub storage: Storage,
    /// The text between its tags.
    pub text: &'a [u8],
    /// The byte offset of its opening tag.
    pub offset: usize,
    source: Source<'a>,
}

/// The appended data, after the underscore.
pub struct Appended<'a> {
    pub raw: bool,
    pub data: &'a [u8],
    pub offset: usize,
}

/// The arrays of points and cells.
pub struct Arrays<'a> {
    pub source: Source<'a>,
    pub endian: Endian,
    /// Whether the cells are polygons, which have no types.
    pub has_polygons: bool,
    pub wide_header: bool,
    pub zlib: bool,
    pub point_count: u64,
    pub cell_count: u64,
    /// The location of a piece with triangle strips, which are not read.
    pub strips: Option<Place>,
    pub points: Option<DataArray<'a>>,
    pub connectivity: Option<DataArray<'a>>,
    pub offsets: Option<DataArray<'a>>,
    pub types: Option<DataArray<'a>>,
    /// The global ids of points, if they are numbers.
    pub point_ids: Option<DataArray<'a>>,
    /// The kinds of ghost points, if they are numbers.
    pub point_ghosts: Option<DataArray<'a>>,
    /// The kinds of ghost cells, if they are numbers.
    pub ghosts: Option<DataArray<'a>>,
    /// The global ids of cells, if they are numbers.
    pub cell_ids: Option<DataArray<'a>>,
    /// The workers of cells, if they are numbers.
    pub owners: Option<DataArray<'a>>,
    /// The arrays of floating-point numbers at points, one for each, with their names.
    pub point_values: Vec<(String, DataArray<'a>)>,
    pub appended: Option<Appended<'a>>,
}

/// Finds the arrays.
pub fn open(source: Source<'_>) -> Result<Arrays<'_>, InputError> {
    let data = source.data;
    let root =
        first_tag(data, b"VTKFile").ok_or_else(|| source.bad_at(0, "no tag VTKFile", "a VTK XML file"))?;
    let mut grid = root_of(source, &root)?;
    let mut at = root.end;
    let mut section: &[u8] = b"";
    let mut pieces = 0;
    while let Some(tag) = next_tag(data, at) {
        at = tag.end;
        match (tag.name, tag.closing) {
            (b"Piece", false) => {
                pieces += 1;
                grid.take_counts(&tag)?;
            }
            (
                b"Points" | b"Cells" | b"Polys" | b"Verts" | b"Lines" | b"Strips" | b"PointData"
                | b"CellData" | b"FieldData",
                closing,
            ) => {
                section = if closing { b"" } else { tag.name };
            }
            (b"DataArray", false) => {
                let (text, end) = if tag.empty { (b"".as_slice(), at) } else { content(source, &tag)? };
                at = end;
                grid.take_array(section, &tag, text)?;
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
        0 => Err(source.truncated(Place::Line(source.line_at(data.len())), "pieces", 1, 0)),
        _ => Err(source.unsupported(
            Place::Line(source.line_at(at)),
            format!("a VTK XML file of {pieces} pieces"),
            "merge the pieces",
        )),
    }
}

impl<'a> Arrays<'a> {
    /// Takes an array of a section, if it has a use.
    fn take_array(&mut self, section: &[u8], tag: &Tag<'a>, text: &'a [u8]) -> Result<(), InputError> {
        let name = tag.attribute("Name").unwrap_or_default();
        let source = self.source;
        let array = || declared(source, tag, text);
        match (section, name) {
            (b"Points", _) => self.points = Some(array()?),
            (b"Cells" | b"Polys", "connectivity") => self.connectivity = Some(array()?),
            (b"Cells" | b"Polys", "offsets") => self.offsets = Some(array()?),
            (b"Cells", "types") => self.types = Some(array()?),
            (b"PointData", "GlobalPointIds") => self.point_ids = array().ok(),
            (b"PointData", "vtkGhostType") => self.point_ghosts = array().ok(),
            (b"PointData", name) => {
                let is_value = |array: &DataArray<'_>| {
                    matches!(array.scalar, Scalar::F32 | Scalar::F64) && array.components == 1
                };
                let values = array().ok().filter(is_value);
                self.point_values.extend(values.map(|array| (name.to_owned(), array)));
            }
            (b"CellData", "vtkGhostType") => self.ghosts = array().ok(),
            (b"CellData", "GlobalCellIds") => self.cell_ids = array().ok(),
            (b"CellData", "owner") => self.owners = array().ok(),
            _ => {}
        }
        Ok(())
    }

    /// Takes the numbers of points and cells from the tag of a piece.
    fn take_counts(&mut self, tag: &Tag<'_>) -> Result<(), InputError> {
        let source = self.source;
        self.point_count = attribute_count(source, tag, "NumberOfPoints")?;
        if !self.has_polygons {
            self.cell_count = attribute_count(source, tag, "NumberOfCells")?;
            return Ok(());
        }
        let count = |name| tag.attribute(name).map_or(Ok(0), |_| attribute_count(source, tag, name));
        self.cell_count = count("NumberOfPolys")?;
        self.strips = (count("NumberOfStrips")? > 0).then(|| Place::Line(source.line_at(tag.start)));
        Ok(())
    }
}

/// Shortens the value of an attribute for messages.
fn shown(value: &str) -> String {
    excerpt(value.as_bytes())
}

/// Returns the first tag with this name.
pub fn first_tag<'a>(data: &'a [u8], name: &[u8]) -> Option<Tag<'a>> {
    let mut tag = next_tag(data, 0)?;
    while tag.name != name {
        tag = next_tag(data, tag.end)?;
    }
    Some(tag)
}

fn root_of<'a>(source: Source<'a>, root: &Tag<'_>) -> Result<Arrays<'a>, InputError> {
    let place = Place::Line(source.line_at(root.start));
    if root.attribute("type") == Some("PUnstructuredGrid") {
        let advice = "it only lists its pieces; give one of the .vtu files that it names, or write .vtu instead of .pvtu";
        return Err(source.unsupported(place, "a parallel grid (.pvtu)", advice));
    }
    if !matches!(root.attribute("type"), Some("UnstructuredGrid" | "PolyData")) {
        let what = format!("VTK data of type {}", shown(root.attribute("type").unwrap_or_default()));
        return Err(source.unsupported(place, what, "save an unstructured grid (.vtu) or polygons (.vtp)"));
    }
    let compressor = root.attribute("compressor");
    if compressor.is_some_and(|c| c != "vtkZLibDataCompressor" && !c.is_empty()) {
        let what = format!("compression by {}", shown(compressor.unwrap_or_default()));
        return Err(source.unsupported(place, what, "save it uncompressed or with zlib"));
    }
    Ok(Arrays {
        source,
        endian: if root.attribute("byte_order") == Some("BigEndian") { Endian::Big } else { Endian::Little },
        has_polygons: root.attribute("type") == Some("PolyData"),
        wide_header: root.attribute("header_type") == Some("UInt64"),
        zlib: compressor.is_some_and(|c| !c.is_empty()),
        point_count: 0,
        cell_count: 0,
        strips: None,
        points: None,
        connectivity: None,
        offsets: None,
        types: None,
        point_ids: None,
        point_ghosts: None,
        ghosts: None,
        cell_ids: None,
        owners: None,
        point_values: Vec::new(),
        appended: None,
    })
}

fn attribute_count(source: Source<'_>, tag: &Tag<'_>, name: &'static str) -> Result<u64, InputError> {
    let value = tag.attribute(name);
    let shown = || format!("{name} = {}", excerpt(value.unwrap_or_default().as_bytes()));
    value.and_then(|v| v.trim().parse().ok()).ok_or_else(|| source.bad_at(tag.start, shown(), "a count"))
}

/// Returns the longest run of text between the tags of an array, and the end of the array.
fn content<'a>(source: Source<'a>, opening: &Tag<'_>) -> Result<(&'a [u8], usize), InputError> {
    let (mut at, mut depth, mut text) = (opening.end, 0_usize, b"".as_slice());
    loop {
        let missing =
            || source.truncated(Place::Line(source.line_at(opening.start)), "tag closing a DataArray", 1, 0);
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

fn declared<'a>(source: Source<'a>, tag: &Tag<'_>, text: &'a [u8]) -> Result<DataArray<'a>, InputError> {
    let kind = tag.attribute("type").unwrap_or_default();
    let scalar = Scalar::of_vtk(kind);
    let scalar = scalar
        .ok_or_else(|| source.bad_at(tag.start, format!("type {}", shown(kind)), "a VTK number type"))?;
    let components = match tag.attribute("NumberOfComponents") {
        Some(_) => attribute_count(source, tag, "NumberOfComponents")?,
        None => 1,
    };
    let storage = match tag.attribute("format").unwrap_or("ascii") {
        "ascii" => Storage::Ascii,
        "binary" => Storage::Base64,
        "appended" => Storage::Appended(attribute_count(source, tag, "offset")?),
        other => {
            return Err(source.bad_at(
                tag.start,
                format!("format {}", shown(other)),
                "ascii, binary or appended",
            ));
        }
    };
    Ok(DataArray { scalar, components, storage, text, offset: tag.start, source })
}

fn appended<'a>(source: Source<'a>, tag: &Tag<'_>) -> Result<Appended<'a>, InputError> {
    let raw = match tag.attribute("encoding") {
        Some("raw") => true,
        Some("base64") => false,
        other => {
            let found = format!("encoding {}", shown(other.unwrap_or_default()));
            return Err(source.bad_at(tag.start, found, "raw or base64"));
        }
    };
    let rest = &source.data[tag.end..];
    let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
    if rest.get(blanks) != Some(&b'_') {
        return Err(source.bad_at(
            tag.end + blanks,
            "no underscore",
            "an underscore before the appended data",
        ));
    }
    let offset = tag.end + blanks + 1;
    Ok(Appended { raw, data: &source.data[offset..], offset })
}

impl DataArray<'_> {
    /// Returns `true` if the values are not text.
    pub fn is_binary(&self) -> bool {
        !matches!(self.storage, Storage::Ascii)
    }

    /// Returns the line of its opening tag.
    pub fn place(&self) -> Place {
        Place::Line(self.source.line_at(self.offset))
    }
}
