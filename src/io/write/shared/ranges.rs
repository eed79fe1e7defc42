//! Files of which every process writes ranges of bytes.

use std::io;

use super::counts::Counts;
use super::mesh::SharedMesh;
use super::sort::SortedCells;
use crate::write::formats::npy;
use crate::write::formats::vtu::{self, Array, Own, Record, Section};
use crate::write::place::Place;
use crate::write::records::WriteProgress;
use crate::write::row_table::RowTable;

/// Writes the share of a process of a `.npy` file of cells.
pub(super) fn write_npy(place: &mut Place<'_>, cells: &SortedCells, table: &RowTable<'_>) -> io::Result<()> {
    let mut ignore = |_, _| {};
    npy::write_cells(place, &cells.range(), table, &mut WriteProgress::new(0, &mut ignore))
}

/// Writes the share of a process of a `.vtu` file: its input rows as points, and its cells.
pub(super) fn write_vtu(
    place: &mut Place<'_>,
    (mesh, counts): (&SharedMesh<'_>, &Counts),
    cells: &SortedCells,
    table: &RowTable<'_>,
) -> io::Result<()> {
    let first = (mesh.first - counts.rows.start) as usize;
    let range = cells.range();
    let own = Own { points: first..first + mesh.row_count(), cells: range.first..range.first + range.len() };
    let mut ignore = |_, _| {};
    let progress = &mut WriteProgress::new(0, &mut ignore);
    vtu::write_arrays(place, vtu::GRID_DATA, &arrays((mesh, counts), cells, table), &own, progress)
}

/// Returns the arrays of the whole file. Only the records of this process can be written.
fn arrays<'a>(
    (mesh, counts): (&SharedMesh<'a>, &Counts),
    sorted: &'a SortedCells,
    table: &'a RowTable<'_>,
) -> Vec<Array<'a>> {
    let (space, rows, base) = (mesh.run.space, counts.row_count(), counts.rows.start);
    let cells = sorted.range();
    let (first, total) = (cells.first, cells.total);
    let ratio: Record<'a> =
        Box::new(move |buffer, i| buffer.extend_from_slice(&cells.extra(i - first, 0).to_le_bytes()));
    // Vertices are positions among the points of the file.
    let position = move |row: u64| (row - base).to_le_bytes();
    let connectivity: Record<'a> =
        Box::new(move |buffer, i| buffer.extend(cells.row(i - first).iter().flat_map(|row| position(*row))));
    let first_row = (mesh.first - base) as usize;
    let heights = mesh.heights.map(|heights| &heights[first_row..first_row + mesh.row_count()]);
    let points = vtu::points(space, (mesh.coordinates, heights)).placed(first_row, rows);
    let mut data = vtu::plain_data_arrays((rows, total), &table.columns, ratio);
    if sorted.layout.with_owner {
        data.push(vtu::owners(total, move |i| cells.extra(i - first, 1) as u32));
        data.push(vtu::leaves(total, move |i| cells.extra(i - first, 2)));
    }
    let has_rows = |array: &&mut Array<'_>| array.section == Section::PointData && array.has_global_ids();
    for array in data.iter_mut().filter(has_rows) {
        array.record = Box::new(move |buffer, i| buffer.extend_from_slice(&(base + i as u64).to_le_bytes()));
    }
    vtu::grid_arrays(data, points, space, (total, connectivity))
}
