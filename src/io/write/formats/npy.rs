//! `.npy` files: arrays of `NumPy`, version 1.0, C order.

use std::io::{self, Write};

use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, write_records};
use septet_core::model::{MeshView, Points};

/// Writes the cells with zero-based indices.
pub fn write_cells(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (cells, width) = (mesh.cells, mesh.dimension + 1);
    write_cells_head(out, mesh.cell_count(), width)?;
    write_records(out, mesh.cell_count(), progress, |buffer, row| {
        push_cell(buffer, &cells[row * width..(row + 1) * width]);
    })?;
    Ok(())
}

/// Writes the header of an array of cells with this number of vertices.
pub fn write_cells_head(out: &mut dyn Write, cells: usize, corners: usize) -> io::Result<()> {
    write_head(out, "<i8", cells, corners)
}

/// Appends the vertices of a cell.
pub fn push_cell(buffer: &mut Vec<u8>, cell: &[u64]) {
    for index in cell {
        buffer.extend_from_slice(&index.to_le_bytes());
    }
}

/// Writes points.
pub fn write_points(
    out: &mut dyn Write,
    points: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (coordinates, width) = (points.coordinates(), points.dimension());
    write_head(out, "<f8", points.len(), width)?;
    write_records(out, points.len(), progress, |buffer, row| {
        for coordinate in &coordinates[row * width..(row + 1) * width] {
            buffer.extend_from_slice(&coordinate.to_le_bytes());
        }
    })?;
    Ok(())
}

/// Writes the header. It is padded with spaces to a multiple of 64 bytes and ends with a line feed.
fn write_head(out: &mut dyn Write, kind: &str, rows: usize, columns: usize) -> io::Result<()> {
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    let blanks = 63 - (10 + text.len()) % 64;
    text.push_str(&" ".repeat(blanks));
    text.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(text.len() as u16).to_le_bytes())?;
    out.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    use super::*;
    use crate::read::{CellOptions, ReadOptions, read_cells_from, read_from};

    /// Returns the bytes that [`write_points`] writes.
    fn points_file(points: &Points) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut report = |_, _| {};
        write_points(&mut bytes, points, &mut WriteProgress::new(points.len() as u64, &mut report)).unwrap();
        bytes
    }

    /// Returns the bytes that [`write_cells`] writes.
    fn cells_file(dimension: usize, cells: &[u64]) -> Vec<u8> {
        let (owner, owning_leaf, shares, labels) = (None, None, None, None);
        let mesh = MeshView { dimension, coordinates: &[], cells, owner, owning_leaf, shares, labels };
        let mut bytes = Vec::new();
        let mut report = |_, _| {};
        write_cells(&mut bytes, &mesh, &mut WriteProgress::new(cells.len() as u64, &mut report)).unwrap();
        bytes
    }

    /// Returns the bytes that `numpy.save` writes in version 1.0.
    fn saved(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let mut head = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
        while (11 + head.len()) % 64 != 0 {
            head.push(' ');
        }
        head.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((head.len() as u16).to_le_bytes());
        bytes.extend(head.as_bytes());
        bytes.extend(data);
        bytes
    }

    /// Finite numbers other than -0.0, which readers convert to 0.0.
    fn coordinate() -> impl Strategy<Value = f64> {
        any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |c| c.is_finite()).prop_map(|c| c + 0.0)
    }

    fn points() -> impl Strategy<Value = Points> {
        let plane = proptest::collection::vec((coordinate(), coordinate()), 0..40)
            .prop_map(|rows| Points::Plane(rows.into_iter().map(DVec2::from).collect()));
        let space = proptest::collection::vec((coordinate(), coordinate(), coordinate()), 0..40)
            .prop_map(|rows| Points::Space(rows.into_iter().map(DVec3::from).collect()));
        prop_oneof![plane, space]
    }

    proptest! {
        #[test]
        fn points_come_back(points in points()) {
            let bytes = points_file(&points);
            let (name, options) = (Path::new("p.npy"), ReadOptions::default());
            let read = read_from(&bytes[..], name, None, &options, &mut |_, _| {}).unwrap();
            let bits = |points: &Points| points.coordinates().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(read.points.dimension(), points.dimension());
            prop_assert_eq!(bits(&read.points), bits(&points));
            prop_assert!(read.notes.is_empty());
            let data: Vec<u8> = points.coordinates().iter().flat_map(|c| c.to_le_bytes()).collect();
            let shape = format!("({}, {})", points.len(), points.dimension());
            prop_assert_eq!(bytes, saved("<f8", &shape, &data));
        }

        #[test]
        fn cells_come_back(dimension in 2..=3_usize, flat in proptest::collection::vec(0..u64::MAX >> 1, 0..60)) {
            let width = dimension + 1;
            let cells = &flat[..flat.len() / width * width];
            let bytes = cells_file(dimension, cells);
            let (name, options) = (Path::new("c.npy"), CellOptions::default());
            let read = read_cells_from(&bytes[..], name, None, &options, &mut |_, _| {}).unwrap();
            prop_assert_eq!((read.dimension, &read.cells[..]), (dimension, cells));
            let data: Vec<u8> = cells.iter().flat_map(|c| c.to_le_bytes()).collect();
            let shape = format!("({}, {width})", cells.len() / width);
            prop_assert_eq!(bytes, saved("<i8", &shape, &data));
        }
    }
}
