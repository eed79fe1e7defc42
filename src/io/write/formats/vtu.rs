//! `.vtu` files: an unstructured grid of VTK with raw appended data.
//!
//! All sizes are known in advance, so the XML header with the offsets is written first, and the arrays are streamed
//! after it. Points in the plane get z = 0, and those of a terrain their heights.

use std::io::{self, Write};
use std::ops::Range;

use super::npy::push_cell;
use crate::read::Column;
use crate::write::error::WriteFault;
use crate::write::options::WriteOptions;
use crate::write::place::Place;
use crate::write::quality::radius_edge_ratio;
use crate::write::records::{WriteProgress, write_range};
use septet_core::model::{MeshView, Points};

/// Cell types of VTK.
pub const VERTEX: u8 = 1;
pub const TRIANGLE: u8 = 5;
pub const TETRAHEDRON: u8 = 10;

pub const POINT_DATA: &str = "PointData GlobalIds=\"GlobalPointIds\"";
pub const CELL_DATA: &str = "CellData GlobalIds=\"GlobalCellIds\" Scalars=\"radius_edge_ratio\"";

/// The opening tags of the data of a triangulation.
pub const GRID_DATA: [&str; 2] = [POINT_DATA, CELL_DATA];

/// The section of the file that has an array.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Section {
    PointData,
    CellData,
    Points,
    Cells,
}

pub type Record<'a> = Box<dyn Fn(&mut Vec<u8>, usize) + Sync + 'a>;

/// An array: its declaration and its records.
pub struct Array<'a> {
    pub section: Section,
    pub name: &'a str,
    /// The name of the type in VTK.
    pub kind: &'static str,
    /// Further XML attributes, with a leading space.
    attributes: &'static str,
    /// The number of records.
    pub count: usize,
    /// The number of bytes per record.
    width: usize,
    /// The number of bytes of all records. Records of an array that is written as a whole may have other widths.
    bytes: usize,
    /// Appends a record in little-endian order.
    pub record: Record<'a>,
}

impl Array<'_> {
    /// Returns an array of `total` records that contains the records of this array from number `first`. Records before
    /// and after them cannot be written.
    pub fn placed(self, first: usize, total: usize) -> Self {
        let record = self.record;
        let bytes = total * self.width;
        Array { count: total, bytes, record: Box::new(move |buffer, i| record(buffer, i - first)), ..self }
    }

    /// Writes the number of bytes of all records, which precedes them.
    fn write_length(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&(self.bytes as u64).to_le_bytes())
    }

    /// Writes the records of a range.
    fn write(
        &self,
        out: &mut dyn Write,
        range: Range<usize>,
        progress: &mut WriteProgress<'_>,
    ) -> io::Result<()> {
        write_range(out, range, progress, &*self.record)
    }

    /// Returns the position of a record in the bytes of the array, which begin with their number.
    fn position(&self, record: usize) -> usize {
        LENGTH + if record == self.count { self.bytes } else { record * self.width }
    }

    /// Returns an array whose records have this number of bytes together. It is written as a whole.
    pub fn of_bytes(self, bytes: usize) -> Self {
        Array { bytes, ..self }
    }

    /// Returns `true` for the global ids of points or cells.
    pub fn has_global_ids(&self) -> bool {
        self.attributes == IDS
    }

    /// Returns the type, the further attributes and the name in XML.
    pub fn declaration(&self) -> String {
        let Array { name, kind, attributes, .. } = self;
        format!("type=\"{kind}\"{attributes} Name=\"{}\"", escaped(name))
    }
}

/// The bytes of the length of an array.
const LENGTH: usize = 8;

/// The end of a file, after the arrays.
const TAIL: &[u8] = b"\n  </AppendedData>\n</VTKFile>\n";

/// The attribute of an array of global ids.
const IDS: &str = " IdType=\"1\"";

/// Returns the number of records that `write` reports, without the records of owners.
pub fn records(points: usize, cells: usize) -> u64 {
    (2 * points + 5 * cells) as u64
}

/// Writes a triangulation without labels.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    Ok(write_grid(out, mesh, data_arrays(mesh, options), progress)?)
}

/// Writes points and cells with these arrays of point data and cell data.
pub fn write_grid<'a>(
    out: &mut dyn Write,
    mesh: &MeshView<'a>,
    arrays: Vec<Array<'a>>,
    progress: &mut WriteProgress<'_>,
) -> io::Result<()> {
    let corners = mesh.dimension + 1;
    let (cells, count) = (mesh.cells, mesh.cell_count());
    let connectivity: Record<'_> =
        Box::new(move |buffer, i| push_cell(buffer, &cells[i * corners..(i + 1) * corners]));
    let points = points(mesh.dimension, (mesh.coordinates, mesh.heights));
    let arrays = grid_arrays(arrays, points, mesh.dimension, (count, connectivity));
    write_whole(out, GRID_DATA, &arrays, progress)
}

/// Appends the arrays of points and cells to those of point data and cell data. The number of cells and the vertices of a
/// cell are given.
pub fn grid_arrays<'a>(
    mut arrays: Vec<Array<'a>>,
    points: Array<'a>,
    dimension: usize,
    (count, connectivity): (usize, Record<'a>),
) -> Vec<Array<'a>> {
    let corners = dimension + 1;
    let kind = if dimension == 3 { TETRAHEDRON } else { TRIANGLE };
    let width = 8 * corners;
    arrays.push(points);
    arrays.push(cell_array(Section::Cells, "connectivity", "Int64", (count, width), connectivity));
    arrays.extend(offsets_and_types(count, corners, kind));
    arrays
}

/// Returns the arrays of point data and cell data.
pub fn data_arrays<'a>(mesh: &MeshView<'a>, options: &WriteOptions<'a>) -> Vec<Array<'a>> {
    let corners = mesh.dimension + 1;
    let (dimension, coordinates, cells) = (mesh.dimension, mesh.coordinates, mesh.cells);
    let ratio: Record<'a> = Box::new(move |buffer, i| {
        let cell = &cells[i * corners..(i + 1) * corners];
        let ratio = radius_edge_ratio(dimension, coordinates, cell);
        buffer.extend_from_slice(&ratio.to_le_bytes());
    });
    let counts = (mesh.point_count(), mesh.cell_count());
    let mut arrays = plain_data_arrays(counts, options.point_data, ratio);
    if options.with_owner {
        if let Some(owner) = mesh.owner {
            arrays.push(owners(owner.len(), move |i| owner[i]));
        }
        if let Some(leaf) = mesh.owning_leaf {
            arrays.push(leaves(leaf.len(), move |i| leaf[i]));
        }
    }
    arrays
}

/// Returns the arrays of point data and cell data that every triangulation has, and the columns of point data.
pub fn plain_data_arrays<'a>(
    (points, cells): (usize, usize),
    columns: &'a [Column],
    ratio: Record<'a>,
) -> Vec<Array<'a>> {
    let mut arrays = vec![point_ids(points)];
    arrays.extend(columns.iter().map(|column| {
        let record: Record<'a> = Box::new(|b, i| b.extend_from_slice(&column.values[i].to_le_bytes()));
        cell_array(Section::PointData, &column.name, "Float64", (column.values.len(), 8), record)
    }));
    arrays.push(cell_ids(cells));
    arrays.push(cell_array(Section::CellData, "radius_edge_ratio", "Float64", (cells, 8), ratio));
    arrays
}

/// Writes points, and a vertex cell for each.
pub fn write_points(
    out: &mut dyn Write,
    set: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let count = set.len();
    let index: Record<'_> = Box::new(|buffer, i| buffer.extend_from_slice(&(i as u64).to_le_bytes()));
    let mut arrays = vec![point_ids(count), points(set.dimension(), (set.coordinates(), None))];
    arrays.push(cell_array(Section::Cells, "connectivity", "Int64", (count, 8), index));
    arrays.extend(offsets_and_types(count, 1, VERTEX));
    Ok(write_whole(out, [POINT_DATA, "CellData"], &arrays, progress)?)
}

pub fn cell_array<'a>(
    section: Section,
    name: &'a str,
    kind: &'static str,
    (count, width): (usize, usize),
    record: Record<'a>,
) -> Array<'a> {
    Array { section, name, kind, attributes: "", count, width, bytes: count * width, record }
}

fn ids(section: Section, name: &'static str, count: usize) -> Array<'static> {
    let record: Record<'_> = Box::new(|buffer, i| buffer.extend_from_slice(&(i as u64).to_le_bytes()));
    Array { section, name, kind: "Int64", attributes: IDS, count, width: 8, bytes: 8 * count, record }
}

fn point_ids(count: usize) -> Array<'static> {
    ids(Section::PointData, "GlobalPointIds", count)
}

fn cell_ids(count: usize) -> Array<'static> {
    ids(Section::CellData, "GlobalCellIds", count)
}

/// Returns the array of the workers of cells.
pub fn owners<'a>(count: usize, owner: impl Fn(usize) -> u32 + Sync + 'a) -> Array<'a> {
    let record: Record<'a> = Box::new(move |buffer, i| buffer.extend_from_slice(&owner(i).to_le_bytes()));
    cell_array(Section::CellData, "owner", "UInt32", (count, 4), record)
}

/// Returns the array of the leaves of cells.
pub fn leaves<'a>(count: usize, leaf: impl Fn(usize) -> u64 + Sync + 'a) -> Array<'a> {
    let record: Record<'a> = Box::new(move |buffer, i| buffer.extend_from_slice(&leaf(i).to_le_bytes()));
    cell_array(Section::CellData, "home_leaf", "UInt64", (count, 8), record)
}

/// Returns the array of points. Points in the plane get their heights as z, or 0.
pub fn points<'a>(dimension: usize, (coordinates, heights): (&'a [f64], Option<&'a [f64]>)) -> Array<'a> {
    points_of(coordinates.len() / dimension, move |i| {
        let z = heights.map_or(0.0, |heights| heights[i]);
        std::array::from_fn(|axis| if axis < dimension { coordinates[i * dimension + axis] } else { z })
    })
}

/// Returns the array of points at these places.
pub fn points_of<'a>(count: usize, place: impl Fn(usize) -> [f64; 3] + Sync + 'a) -> Array<'a> {
    let record: Record<'_> =
        Box::new(move |buffer, i| place(i).iter().for_each(|c| buffer.extend_from_slice(&c.to_le_bytes())));
    let attributes = " NumberOfComponents=\"3\"";
    let (name, kind, width) = ("Points", "Float64", 24);
    let (section, bytes) = (Section::Points, count * width);
    Array { section, name, kind, attributes, count, width, bytes, record }
}

/// Returns the arrays of offsets and types. In VTK, the offset of a cell is the position where it ends.
pub fn offsets_and_types(count: usize, corners: usize, kind: u8) -> [Array<'static>; 2] {
    let end: Record<'_> = Box::new(move |buffer, i| {
        buffer.extend_from_slice(&((i as u64 + 1) * corners as u64).to_le_bytes());
    });
    [
        cell_array(Section::Cells, "offsets", "Int64", (count, 8), end),
        cell_array(Section::Cells, "types", "UInt8", (count, 1), Box::new(move |b, _| b.push(kind))),
    ]
}

/// Writes a file with the given arrays. `data` contains the opening tags of point data and cell data.
pub fn write_whole(
    out: &mut dyn Write,
    data: [&str; 2],
    arrays: &[Array<'_>],
    progress: &mut WriteProgress<'_>,
) -> io::Result<()> {
    let all = |section| 0..count_of(arrays, section);
    let own = &Own { points: all(Section::Points), cells: all(Section::Cells) };
    write_arrays(&mut Place::stream(out), data, arrays, own, progress)
}

/// The records that a process writes.
pub struct Own {
    pub points: Range<usize>,
    pub cells: Range<usize>,
}

/// Writes the records of a process to a file with the given arrays.
pub fn write_arrays(
    place: &mut Place<'_>,
    data: [&str; 2],
    arrays: &[Array<'_>],
    own: &Own,
    progress: &mut WriteProgress<'_>,
) -> io::Result<()> {
    let mut head = Vec::new();
    write_head(&mut head, data, arrays)?;
    let mut starts: Vec<usize> = offsets(arrays).into_iter().map(|offset| head.len() + offset).collect();
    let end = starts.pop().unwrap_or(head.len());
    if place.is_first {
        place.set_len(end + TAIL.len())?;
        place.write_all(&head)?;
    }
    for (array, start) in arrays.iter().zip(starts) {
        let of_points = matches!(array.section, Section::PointData | Section::Points);
        let range = if of_points { &own.points } else { &own.cells };
        if place.is_first {
            place.go_to(start)?;
            array.write_length(place)?;
        }
        place.go_to(start + array.position(range.start))?;
        array.write(place, range.clone(), progress)?;
    }
    if place.is_first {
        place.go_to(end)?;
        place.write_all(TAIL)?;
    }
    Ok(())
}

/// Returns the number of records of a section, whose arrays have equal lengths.
fn count_of(arrays: &[Array<'_>], section: Section) -> usize {
    arrays.iter().find(|array| array.section == section).map_or(0, |array| array.count)
}

/// Returns the position of each array after the header, then the position of the end.
fn offsets(arrays: &[Array<'_>]) -> Vec<usize> {
    let mut offsets = vec![0];
    let mut end = 0;
    for array in arrays {
        end += array.position(array.count);
        offsets.push(end);
    }
    offsets
}

/// Escapes a name for an XML attribute. Control characters, which XML does not allow, become `?`.
pub fn escaped(name: &str) -> String {
    let mut escaped = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() => escaped.push('?'),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Writes the XML header, up to the underscore before the data.
fn write_head(out: &mut dyn Write, data: [&str; 2], arrays: &[Array<'_>]) -> io::Result<()> {
    let [points, cells] = [Section::Points, Section::Cells].map(|section| count_of(arrays, section));
    let sections = [
        (Section::PointData, data[0]),
        (Section::CellData, data[1]),
        (Section::Points, "Points"),
        (Section::Cells, "Cells"),
    ];
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    write!(out, "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" ")?;
    writeln!(out, "byte_order=\"LittleEndian\" header_type=\"UInt64\">")?;
    writeln!(out, "  <UnstructuredGrid>")?;
    writeln!(out, "    <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">")?;
    // The data are stored in the order of the arrays, which may differ from the order of the sections.
    let offsets = offsets(arrays);
    for (section, tag) in sections {
        writeln!(out, "      <{tag}>")?;
        let own = arrays.iter().zip(&offsets).filter(|(array, _)| array.section == section);
        for (array, offset) in own {
            write!(out, "        <DataArray {} ", array.declaration())?;
            writeln!(out, "format=\"appended\" offset=\"{offset}\"/>")?;
        }
        let name = tag.split(' ').next().unwrap_or(tag);
        writeln!(out, "      </{name}>")?;
    }
    write!(out, "    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _")
}
