//! Output of a triangulation that several processes hold: together they write the bytes that one process would write.
//!
//! Process 0 creates all files under temporary names. A `.npy` or `.vtu` file has a range of bytes for each process,
//! because the canonical order is sorted across the processes. A `.pvtu` file has pieces, which the process of the worker
//! writes; one process writes all of them in the same way. Values at points, and the numbers of input rows of which some
//! were dropped, go to all processes. Process 0 gathers the triangulation and writes the other formats and compressed files as
//! one process does. A process gathers at most [`GATHER_LIMIT`] bytes. When all processes have written their shares and the
//! bytes are on disk, process 0 renames all files.
//!
//! All functions are collective. If a process has an error, all processes return it, and no output is left. If processes
//! lose each other, process 0 removes its temporary files, but another process may still write to their folder.

mod cells;
mod check;
mod counts;
mod fault;
mod flat;
mod gather;
mod ghosts;
mod mesh;
mod piece;
pub(super) mod pieces;
mod ranges;
mod rows;
mod sort;
mod staged;
mod words;

use std::path::{Path, PathBuf};

use septet_protocol::wire::{Ended, Processes};

pub use fault::GATHER_LIMIT;
pub use gather::{numbers_on_first, to_first};
pub use mesh::SharedMesh;

use super::formats::{Way, writer};
use super::options::WriteOptions;
use super::place::Place;
use super::row_table::RowTable;
use super::staged::Staged;
use crate::ending::without_gz;
use crate::format::Format;
use cells::Layout;
use counts::Counts;
use fault::{SharedFault, describe, fits};
use gather::Whole;

/// Checks before a run that all processes can write these outputs together: the names, the options, and that all
/// processes see the folders of process 0.
///
/// # Errors
/// Returns the first error of a process on all processes. The exit code is 2 if an output, its format or an option is not
/// possible, and 1 if a file cannot be written or if the processes do not share its folder.
pub fn check_shared(
    processes: &mut Processes<'_>,
    outputs: &[PathBuf],
    options: &WriteOptions<'_>,
) -> Result<(), Ended> {
    check::check(processes, outputs, options).map(drop)
}

/// Returns how several processes write an output.
fn way_of(path: &Path, format: Format) -> Way {
    if without_gz(path).1 { Way::Whole } else { writer(format).way }
}

/// Checks, before a run, that the first process can hold the triangulation of so many points for the outputs that one process
/// writes. The check assumes seven cells for each point in space, and two in the plane, as for uniform points.
///
/// # Errors
/// Fails on all processes if the triangulation would need more than [`GATHER_LIMIT`] bytes.
pub fn check_gathered(
    processes: &mut Processes<'_>,
    (outputs, options): (&[PathBuf], &WriteOptions<'_>),
    (points, dimension): (u64, usize),
) -> Result<(), Ended> {
    let is_gathered =
        |output: &PathBuf| options.format_of(output).is_ok_and(|format| way_of(output, format) == Way::Whole);
    let cells = points.saturating_mul(if dimension == 2 { 2 } else { 7 });
    let fitting =
        if outputs.iter().any(is_gathered) { fits(gather::bytes(points, cells, dimension)) } else { Ok(()) };
    processes.agree(fitting, describe)
}

/// Writes outputs on all processes, and returns the files written. They appear under their names only when all processes
/// have written all of them. Coordinates of the input must not be -0.0, which readers replace. Between two outputs, a process asks `stop`
/// whether to end the call on all processes. The values at points in the options of process 0 are those of all rows; other
/// processes need none.
///
/// # Errors
/// See [`check_shared`]. Also fails if writing fails, or if the shares of the processes contradict each other. Existing
/// files then remain unchanged.
pub fn write_shared(
    processes: &mut Processes<'_>,
    outputs: &[PathBuf],
    mesh: &SharedMesh<'_>,
    options: &WriteOptions<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<PathBuf>, Ended> {
    let formats = check::check(processes, outputs, options)?;
    let counts = Counts::gather(processes, mesh, options.with_owner)?;
    let ways: Vec<Way> = outputs.iter().zip(&formats).map(|(path, format)| way_of(path, *format)).collect();
    let of = |way: Way| outputs.iter().zip(&ways).filter(move |(_, own)| **own == way).map(|(path, _)| path);
    let go_on = |processes: &mut Processes<'_>| {
        processes.agree(if stop() { Err(SharedFault::Interrupted) } else { Ok(()) }, describe)
    };
    let mut staged = Staged::default();
    let has = |way: Way| of(way).next().is_some();
    let table = if has(Way::Cells) || has(Way::Grid) || has(Way::Pieces) {
        let columns = if has(Way::Grid) || has(Way::Pieces) { options.point_data } else { &[] };
        rows::gather(processes, mesh, &counts, columns)?
    } else {
        RowTable::default()
    };
    if has(Way::Grid) || has(Way::Cells) {
        let with_ratio = has(Way::Grid);
        let with_owner = with_ratio && counts.with_owner;
        let layout = Layout { corners: mesh.run.space + 1, with_ratio, with_owner };
        let cells = sort::sort(processes, mesh, &counts, layout)?;
        for path in of(Way::Cells) {
            go_on(processes)?;
            staged.write_range(processes, path, |place| ranges::write_npy(place, &cells, &table))?;
        }
        for path in of(Way::Grid) {
            go_on(processes)?;
            let write = |place: &mut Place<'_>| ranges::write_vtu(place, (mesh, &counts), &cells, &table);
            staged.write_range(processes, path, write)?;
        }
    }
    for path in of(Way::Pieces) {
        go_on(processes)?;
        pieces::write(processes, &mut staged, path, (mesh, &counts), &table)?;
    }
    if of(Way::Whole).next().is_some() {
        let whole = Whole::gather(processes, mesh, &counts)?;
        for path in of(Way::Whole) {
            go_on(processes)?;
            whole.write(processes, &mut staged, path, options)?;
        }
    }
    go_on(processes)?;
    // The other processes have no files to rename.
    let renamed = staged.commit();
    processes.agree(renamed.map_err(Into::into), describe)?;
    Ok(outputs.iter().zip(&formats).flat_map(|(path, format)| format.files(path)).collect())
}

#[cfg(test)]
mod tests;
