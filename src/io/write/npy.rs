//! `.npy`: arrays of `NumPy`, version 1.0, C order.

use std::io::{self, Write};

use super::error::Fault;
use super::records::{Progress, write_records};
use septet_core::model::{MeshView, Points};

/// Writes the cells, zero-based.
pub(super) fn write_cells(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut Progress<'_>,
) -> Result<(), Fault> {
    let (cells, width) = (mesh.cells, mesh.dimension + 1);
    write_head(out, "<i8", mesh.cell_count(), width)?;
    write_records(out, mesh.cell_count(), progress, |buffer, row| {
        for index in &cells[row * width..(row + 1) * width] {
            buffer.extend_from_slice(&index.to_le_bytes());
        }
    })?;
    Ok(())
}

/// Writes points.
pub(super) fn write_points(
    out: &mut dyn Write,
    points: &Points,
    progress: &mut Progress<'_>,
) -> Result<(), Fault> {
    let (coordinates, width) = (points.coordinates(), points.dimension());
    write_head(out, "<f8", points.len(), width)?;
    write_records(out, points.len(), progress, |buffer, row| {
        for coordinate in &coordinates[row * width..(row + 1) * width] {
            buffer.extend_from_slice(&coordinate.to_le_bytes());
        }
    })?;
    Ok(())
}

/// The head is filled up with blanks to a multiple of 64 bytes and ends with a new line.
fn write_head(out: &mut dyn Write, kind: &str, rows: usize, columns: usize) -> io::Result<()> {
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    let blanks = 63 - (10 + text.len()) % 64;
    text.push_str(&" ".repeat(blanks));
    text.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(text.len() as u16).to_le_bytes())?;
    out.write_all(text.as_bytes())
}
