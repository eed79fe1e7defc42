//! `.npy` files: arrays of `NumPy`, version 1.0, C order.

use std::io::{self, Write};

use crate::write::cell_range::CellRange;
use crate::write::error::WriteFault;
use crate::write::place::Place;
use crate::write::records::{WriteProgress, write_records};
use crate::write::row_table::RowTable;
use septet_core::model::Points;

/// Writes cells with zero-based numbers of the rows of the input.
pub fn write_cells(
    place: &mut Place<'_>,
    cells: &CellRange<'_>,
    table: &RowTable<'_>,
    progress: &mut WriteProgress<'_>,
) -> io::Result<()> {
    let mut head = Vec::new();
    write_head(&mut head, "<i8", &format!("({}, {})", cells.total, cells.corners))?;
    let position = |cell: usize| head.len() + cell * 8 * cells.corners;
    if place.is_first {
        place.set_len(position(cells.total))?;
        place.write_all(&head)?;
    }
    place.go_to(position(cells.first))?;
    write_records(place, cells.len(), progress, |buffer, cell| match &table.source {
        None => push_cell(buffer, cells.row(cell)),
        Some(_) => cells.row(cell).iter().for_each(|row| push_cell(buffer, &[table.number(*row)])),
    })
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
    write_head(out, "<f8", &format!("({}, {width})", points.len()))?;
    write_records(out, points.len(), progress, |buffer, row| {
        for coordinate in &coordinates[row * width..(row + 1) * width] {
            buffer.extend_from_slice(&coordinate.to_le_bytes());
        }
    })?;
    Ok(())
}

/// Writes numbers of rows.
pub fn write_rows(out: &mut dyn Write, rows: &[u64]) -> io::Result<()> {
    write_head(out, "<u8", &format!("({},)", rows.len()))?;
    rows.iter().try_for_each(|row| out.write_all(&row.to_le_bytes()))
}

/// Writes the header of an array of this type and shape. It is padded with spaces to a multiple of 64 bytes and ends with a line feed.
pub fn write_head(out: &mut dyn Write, kind: &str, shape: &str) -> io::Result<()> {
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
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
        let corners = dimension + 1;
        let total = cells.len() / corners;
        let cells = CellRange { corners, first: 0, total, width: corners, words: cells };
        let mut bytes = Vec::new();
        let mut report = |_, _| {};
        let progress = &mut WriteProgress::new(total as u64, &mut report);
        write_cells(&mut Place::stream(&mut bytes), &cells, &RowTable::default(), progress).unwrap();
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
