//! `.pvtu` files: a parallel unstructured grid of VTK. `NAME.pvtu` declares the arrays and lists the pieces, one for each
//! worker, which are the files `NAME.pieces/0000.vtu`, `0001.vtu` and so on.
//!
//! A piece contains a [`Part`]: the points and cells of a worker, and its ghosts. `vtkGhostType` is 1 for ghosts and 0
//! for all others. The ids of points are their rows in the input. A worker without points has an empty piece.
//!
//! The folder of the pieces is replaced as a whole, and the `.pvtu` file is renamed last. If the program is killed in
//! between, the folder may be missing, or the former `.pvtu` file may list the new pieces. The former pieces are then in a
//! folder with a temporary name.

use std::io::{self, Write};
use std::path::Path;

use rayon::prelude::*;
use septet_core::model::MeshView;
use septet_core::result::part::{Division, DivisionError, Part};

use super::vtu::{
    self, Array, CELL_DATA, POINT_DATA, Record, Section, cell_array, data_arrays, escaped, write_grid,
};
use crate::ending::without_gz;
use crate::read::Column;
use crate::write::error::{OutputError, WriteFault};
use crate::write::folder::{self, Folder, Pieces};
use crate::write::names::pieces_path;
use crate::write::options::WriteOptions;
use crate::write::records::WriteProgress;
use crate::write::stage::{self, Stage};
use crate::write::staged::Staged;

/// The value of `vtkGhostType` for a ghost cell (`DUPLICATECELL`) and for a ghost point (`DUPLICATEPOINT`).
const GHOST: u8 = 1;

/// Checks that a `.pvtu` file and its pieces can be written under this path.
pub fn check(path: &Path) -> Result<(), OutputError> {
    let at = || path.to_path_buf();
    if without_gz(path).1 {
        return Err(OutputError::Compressed { path: at() });
    }
    if stage::is_special(path) {
        return Err(OutputError::NotOneFile);
    }
    let name = path.file_name().unwrap_or_default();
    if name.to_str().is_none_or(|name| name.contains(char::is_control)) {
        return Err(OutputError::NotText { path: at() });
    }
    stage::probe(path)?;
    folder::check(&pieces_path(path))
}

/// Writes the pieces of a triangulation and the file that lists them.
pub fn write(
    path: &Path,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    staged: &mut Staged,
    progress: &mut WriteProgress<'_>,
) -> Result<(), OutputError> {
    check(path)?;
    let division = Division::new(*mesh).map_err(|error| match error {
        DivisionError::NoShares => OutputError::NoPieces { path: path.to_path_buf() },
        error => OutputError::InvalidMesh { reason: error.to_string() },
    })?;
    let folder = Folder::create(&pieces_path(path), division.workers())?;
    let pieces = folder.pieces().clone();
    // If a piece fails, dropping the folder removes it.
    staged.folders.push(folder);
    let workers: Vec<u32> = (1..=division.workers()).collect();
    // Each thread has one part in memory.
    for batch in workers.chunks(rayon::current_num_threads()) {
        let piece = |&worker: &u32| {
            let part = division.part(worker);
            write_piece(&pieces, worker, &part, options)?;
            Ok(vtu::records(part.owned_points, part.owned_cells))
        };
        let written = batch.par_iter().map(piece).collect::<Result<Vec<u64>, OutputError>>()?;
        progress.advance(written.iter().sum());
    }
    stage_list(&mut staged.stage, path, &empty_part(mesh), options, &pieces, division.workers())
}

/// Writes the piece of a worker.
pub fn write_piece(
    pieces: &Pieces,
    worker: u32,
    part: &Part,
    options: &WriteOptions<'_>,
) -> Result<(), OutputError> {
    pieces.write(worker - 1, |out| Ok(write_part(out, part, options)?))
}

/// Writes the file that lists the pieces of all workers under a temporary name. The empty part has their arrays.
pub fn stage_list(
    stage: &mut Stage,
    path: &Path,
    empty: &Part,
    options: &WriteOptions<'_>,
    pieces: &Pieces,
    workers: u32,
) -> Result<(), OutputError> {
    let sources: Vec<String> = (0..workers).map(|piece| pieces.name(piece)).collect();
    stage.write(path, |out| {
        with_arrays(empty, options, |_, arrays| write_list(out, arrays, pieces.target(), &sources))
            .map_err(WriteFault::from)
    })
}

/// Returns a part without points and cells that has the same arrays as the parts of a triangulation.
fn empty_part(mesh: &MeshView<'_>) -> Part {
    Part {
        dimension: mesh.dimension,
        owner: mesh.owner.map(|_| Vec::new()),
        owning_leaf: mesh.owning_leaf.map(|_| Vec::new()),
        ..Part::default()
    }
}

/// Writes a part as a `.vtu` file.
fn write_part(out: &mut dyn Write, part: &Part, options: &WriteOptions<'_>) -> io::Result<()> {
    with_arrays(part, options, |view, arrays| {
        let mut ignore = |_, _| {};
        write_grid(out, view, arrays, &mut WriteProgress::new(0, &mut ignore))
    })
}

/// Calls `body` with a part as a mesh, and with its arrays of point data and cell data.
fn with_arrays<T>(
    part: &Part,
    options: &WriteOptions<'_>,
    body: impl for<'a> FnOnce(&MeshView<'a>, Vec<Array<'a>>) -> T,
) -> T {
    let of_part = |column: &Column| Column {
        name: column.name.clone(),
        values: part.point_ids.iter().map(|&id| column.values[id as usize]).collect(),
    };
    let columns: Vec<Column> = options.point_data.iter().map(of_part).collect();
    let options = WriteOptions { point_data: &columns, ..*options };
    let view = MeshView {
        dimension: part.dimension,
        coordinates: &part.coordinates,
        cells: &part.cells,
        owner: part.owner.as_deref(),
        owning_leaf: part.owning_leaf.as_deref(),
        shares: None,
        labels: None,
    };
    let mut arrays = data_arrays(&view, &options);
    for array in arrays.iter_mut().filter(|array| array.has_global_ids()) {
        let ids = if array.section == Section::PointData { &part.point_ids } else { &part.cell_ids };
        array.record = Box::new(|buffer, i| buffer.extend_from_slice(&ids[i].to_le_bytes()));
    }
    let of_points = arrays.iter().take_while(|array| array.section == Section::PointData).count();
    arrays.insert(of_points, ghost_types(Section::PointData, part.point_ids.len(), part.owned_points));
    arrays.push(ghost_types(Section::CellData, part.cell_ids.len(), part.owned_cells));
    body(&view, arrays)
}

/// Returns the array that marks ghosts, which follow `owned` others.
fn ghost_types(section: Section, count: usize, owned: usize) -> Array<'static> {
    let record: Record<'static> = Box::new(move |buffer, i| buffer.push(if i < owned { 0 } else { GHOST }));
    cell_array(section, "vtkGhostType", "UInt8", (count, 1), record)
}

/// Writes the file that declares the arrays and lists the pieces, which are relative to it.
fn write_list(
    out: &mut dyn Write,
    arrays: Vec<Array<'_>>,
    folder: &Path,
    sources: &[String],
) -> io::Result<()> {
    let mut arrays = arrays;
    arrays.push(vtu::points(3, &[]));
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    write!(out, "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" ")?;
    writeln!(out, "byte_order=\"LittleEndian\" header_type=\"UInt64\">")?;
    writeln!(out, "  <PUnstructuredGrid GhostLevel=\"1\">")?;
    let sections =
        [(Section::PointData, POINT_DATA), (Section::CellData, CELL_DATA), (Section::Points, "Points")];
    for (section, tag) in sections {
        writeln!(out, "    <P{tag}>")?;
        for array in arrays.iter().filter(|array| array.section == section) {
            writeln!(out, "      <PDataArray {}/>", array.declaration())?;
        }
        let name = tag.split(' ').next().unwrap_or(tag);
        writeln!(out, "    </P{name}>")?;
    }
    let folder = folder.file_name().unwrap_or_default().to_string_lossy();
    for source in sources {
        writeln!(out, "    <Piece Source=\"{}/{source}\"/>", escaped(&folder))?;
    }
    writeln!(out, "  </PUnstructuredGrid>\n</VTKFile>")
}
