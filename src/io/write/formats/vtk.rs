//! `.vtk`: a legacy file of VTK, version 3.0, binary, an unstructured grid.
//!
//! All programs that read VTK read this version. Its arrays are big-endian, and cells have 32-bit indices. Point data
//! and cell data are as in a `.vtu` file, without the global ids.

use std::io::{self, Write};

use super::vtu::{Array, Section, VERTEX, data_arrays, points};
use super::vtu_elements::{self, cell_type};
use crate::write::elements::Elements;
use crate::write::error::WriteFault;
use crate::write::options::{Order, WriteOptions};
use crate::write::records::{WriteProgress, write_records};
use septet_core::model::{MeshView, Points};

/// Cells of one type.
struct Cells<'a> {
    count: usize,
    corners: usize,
    vtk_type: u8,
    /// Returns the vertex indices of a cell.
    vertices: &'a (dyn Fn(usize) -> &'a [u64] + Sync),
}

/// Writes a triangulation.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let corners = mesh.dimension + 1;
    let cells = mesh.cells;
    let vertices = move |i: usize| &cells[i * corners..(i + 1) * corners];
    if mesh.labels.is_some() || options.order == Order::Two {
        return write_elements(out, &Elements::of(mesh, options.order)?, options, progress);
    }
    let vtk_type = cell_type(mesh.dimension, Order::One);
    let cells = Cells { count: mesh.cell_count(), corners, vtk_type, vertices: &vertices };
    let arrays = data_arrays(mesh, options);
    write_grid(out, &points(mesh.dimension, (mesh.coordinates, mesh.heights)), &cells, &arrays, progress)
}

/// Writes the cells of a mesh of a domain, or quadratic cells.
fn write_elements(
    out: &mut dyn Write,
    elements: &Elements<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let block = &elements.cells;
    let (count, corners, vtk_type) = (block.len(), block.width, cell_type(block.dimension, elements.order));
    let vertices = |i: usize| block.row(i);
    let cells = Cells { count, corners, vtk_type, vertices: &vertices };
    let arrays = vtu_elements::data_arrays(elements, options, count);
    write_grid(out, &vtu_elements::points(elements), &cells, &arrays, progress)
}

/// Writes points, and a vertex cell for each.
pub fn write_points(
    out: &mut dyn Write,
    set: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let indices: Vec<u64> = (0..set.len() as u64).collect();
    let vertices = |i: usize| &indices[i..=i];
    let cells = Cells { count: set.len(), corners: 1, vtk_type: VERTEX, vertices: &vertices };
    write_grid(out, &points(set.dimension(), (set.coordinates(), None)), &cells, &[], progress)
}

fn write_grid(
    out: &mut dyn Write,
    points: &Array<'_>,
    cells: &Cells<'_>,
    arrays: &[Array<'_>],
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (count, entries) = (cells.count, cells.count * (cells.corners + 1));
    let most = entries.max(points.count) as u64;
    if i32::try_from(most).is_err() {
        return Err(WriteFault::TooLarge(most));
    }
    write!(out, "# vtk DataFile Version 3.0\nseptet\nBINARY\nDATASET UNSTRUCTURED_GRID\n")?;
    writeln!(out, "POINTS {} double", points.count)?;
    write_array(out, points, progress)?;
    writeln!(out, "CELLS {count} {entries}")?;
    write_records(out, count, progress, |buffer, i| {
        buffer.extend_from_slice(&(cells.corners as i32).to_be_bytes());
        for vertex in (cells.vertices)(i) {
            buffer.extend_from_slice(&(*vertex as i32).to_be_bytes());
        }
    })?;
    writeln!(out, "\nCELL_TYPES {count}")?;
    let vtk_type = i32::from(cells.vtk_type).to_be_bytes();
    write_records(out, count, progress, |buffer, _| buffer.extend_from_slice(&vtk_type))?;
    writeln!(out)?;
    write_data(out, Section::PointData, points.count, arrays, progress)?;
    Ok(write_data(out, Section::CellData, count, arrays, progress)?)
}

/// Writes point data or cell data as a field of arrays.
fn write_data(
    out: &mut dyn Write,
    section: Section,
    count: usize,
    arrays: &[Array<'_>],
    progress: &mut WriteProgress<'_>,
) -> io::Result<()> {
    let own: Vec<&Array<'_>> =
        arrays.iter().filter(|a| a.section == section && !a.has_global_ids()).collect();
    if own.is_empty() {
        return Ok(());
    }
    let keyword = if section == Section::PointData { "POINT_DATA" } else { "CELL_DATA" };
    writeln!(out, "{keyword} {count}\nFIELD FieldData {}", own.len())?;
    for array in own {
        let is_short = is_short(array);
        let name = if is_short { "int" } else { type_name(array.kind) };
        writeln!(out, "{} 1 {count} {name}", encoded(array.name))?;
        if is_short {
            write_short(out, array, progress)?;
        } else {
            write_array(out, array, progress)?;
        }
    }
    Ok(())
}

/// Writes the little-endian records of an array as big-endian numbers.
fn write_array(out: &mut dyn Write, array: &Array<'_>, progress: &mut WriteProgress<'_>) -> io::Result<()> {
    let size = if array.kind.ends_with("64") { 8 } else { 4 };
    write_records(out, array.count, progress, |buffer, i| {
        let start = buffer.len();
        (array.record)(buffer, i);
        buffer[start..].chunks_exact_mut(size).for_each(<[u8]>::reverse);
    })?;
    writeln!(out)
}

/// Whether an array has whole numbers of 64 bits that all fit into 32 bits.
fn is_short(array: &Array<'_>) -> bool {
    let mut buffer = Vec::new();
    array.kind == "Int64"
        && (0..array.count).all(|i| {
            buffer.clear();
            (array.record)(&mut buffer, i);
            i32::try_from(whole(&buffer)).is_ok()
        })
}

/// Returns the number of a record of 8 bytes.
fn whole(record: &[u8]) -> i64 {
    record.try_into().map_or(0, i64::from_le_bytes)
}

/// Writes an array of whole numbers in 32 bits.
fn write_short(out: &mut dyn Write, array: &Array<'_>, progress: &mut WriteProgress<'_>) -> io::Result<()> {
    write_records(out, array.count, progress, |buffer, i| {
        let start = buffer.len();
        (array.record)(buffer, i);
        let number = whole(&buffer[start..]) as i32;
        buffer.truncate(start);
        buffer.extend_from_slice(&number.to_be_bytes());
    })?;
    writeln!(out)
}

/// Returns the legacy name of a type of `.vtu` arrays. Only these names are known to all programs. `long` has 64 bits
/// except in VTK on Windows, so that it is used only for numbers that need it.
fn type_name(kind: &str) -> &'static str {
    match kind {
        "Float64" => "double",
        "Int64" => "long",
        "UInt64" => "unsigned_long",
        "UInt32" => "unsigned_int",
        _ => "int",
    }
}

/// Encodes spaces and control characters in a name as `%` and two hexadecimal digits, as VTK does.
fn encoded(name: &str) -> String {
    let byte = |b: u8| match b {
        b'%' | b'"' | 0..=b' ' | 0x7f.. => format!("%{b:02X}"),
        _ => char::from(b).to_string(),
    };
    name.bytes().map(byte).collect()
}
