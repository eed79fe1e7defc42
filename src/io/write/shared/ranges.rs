//! Files of which every process writes ranges of bytes.

use std::io::{self, Seek, SeekFrom, Write};

use super::counts::Counts;
use super::mesh::SharedMesh;
use super::sort::SortedCells;
use super::staged::Place;
use crate::write::formats::npy::{push_cell, write_cells_head};
use crate::write::formats::vtu::{self, Array, Record, Section};
use crate::write::records::{WriteProgress, write_records};

/// Writes the share of a process of a `.npy` file of cells.
pub(super) fn write_npy(place: &mut Place, cells: &SortedCells) -> io::Result<()> {
    let row = 8 * cells.corners as u64;
    let mut head = Vec::new();
    write_cells_head(&mut head, cells.total as usize, cells.corners)?;
    let start = head.len() as u64;
    if place.is_first {
        place.out.get_ref().set_len(start + cells.total * row)?;
        place.out.write_all(&head)?;
    }
    place.out.seek(SeekFrom::Start(start + cells.first * row))?;
    let mut ignore = |_, _| {};
    let progress = &mut WriteProgress::new(0, &mut ignore);
    write_records(&mut place.out, cells.len(), progress, |buffer, cell| push_cell(buffer, cells.row(cell)))
}

/// Writes the share of a process of a `.vtu` file: its input rows as points, and its cells.
pub(super) fn write_vtu(
    place: &mut Place,
    mesh: &SharedMesh<'_>,
    counts: &Counts,
    cells: &SortedCells,
) -> io::Result<()> {
    let arrays = arrays(mesh, counts, cells);
    let head = vtu::grid_head((counts.row_count(), counts.cells as usize), &arrays)?;
    let offsets = vtu::offsets(&arrays).into_iter();
    let mut starts: Vec<usize> = offsets.map(|offset| head.len() + offset).collect();
    let end = starts.pop().unwrap_or(head.len());
    if place.is_first {
        place.out.get_ref().set_len((end + vtu::TAIL.len()) as u64)?;
        place.out.write_all(&head)?;
    }
    let rows = ((mesh.first - counts.rows.start) as usize, mesh.rows.len());
    let mut ignore = |_, _| {};
    let progress = &mut WriteProgress::new(0, &mut ignore);
    for (array, start) in arrays.iter().zip(starts) {
        let of_points = matches!(array.section, Section::PointData | Section::Points);
        let (first, count) = if of_points { rows } else { (cells.first as usize, cells.len()) };
        if place.is_first {
            place.out.seek(SeekFrom::Start(start as u64))?;
            array.write_length(&mut place.out)?;
        }
        place.out.seek(SeekFrom::Start((start + array.position(first)) as u64))?;
        array.write(&mut place.out, first..first + count, progress)?;
    }
    if place.is_first {
        place.out.seek(SeekFrom::Start(end as u64))?;
        place.out.write_all(vtu::TAIL)?;
    }
    Ok(())
}

/// Returns the arrays of the whole file. Only the records of this process can be written.
fn arrays<'a>(mesh: &SharedMesh<'a>, counts: &Counts, cells: &'a SortedCells) -> Vec<Array<'a>> {
    let (rows, total) = (counts.row_count(), counts.cells as usize);
    let (first, base) = (cells.first as usize, counts.rows.start);
    let ratio: Record<'a> =
        Box::new(move |buffer, i| buffer.extend_from_slice(&cells.ratio_bits(i - first).to_le_bytes()));
    // Vertices are positions among the points of the file.
    let position = move |row: u64| (row - base).to_le_bytes();
    let connectivity: Record<'a> =
        Box::new(move |buffer, i| buffer.extend(cells.row(i - first).iter().flat_map(|row| position(*row))));
    let points = vtu::points(mesh.run.space, mesh.rows.coordinates());
    let points = points.placed((mesh.first - base) as usize, rows);
    let mut data = vtu::plain_data_arrays((rows, total), &[], ratio);
    let has_rows = |array: &&mut Array<'_>| array.section == Section::PointData && array.has_global_ids();
    for array in data.iter_mut().filter(has_rows) {
        array.record = Box::new(move |buffer, i| buffer.extend_from_slice(&(base + i as u64).to_le_bytes()));
    }
    vtu::grid_arrays(data, points, mesh.run.space, (total, connectivity))
}
