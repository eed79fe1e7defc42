//! `.pvtu` files: a parallel unstructured grid of VTK. `NAME.pvtu` declares the arrays and lists the pieces, one for each
//! worker, which are the files `NAME.pieces/0000.vtu`, `0001.vtu` and so on.
//!
//! A piece contains a [`Piece`]: the points and cells of a worker, and its ghosts. `vtkGhostType` is 1 for ghosts and 0
//! for all others. The ids of points are their rows in the input. A worker without points has an empty piece.
//!
//! The folder of the pieces is replaced as a whole, and the `.pvtu` file is renamed last. If the program is killed in
//! between, the folder may be missing, or the former `.pvtu` file may list the new pieces. The former pieces are then in a
//! folder with a temporary name.

use std::io::{self, Write};
use std::path::Path;

use septet_core::model::MeshView;

use super::vtu::{
    self, Array, CELL_DATA, POINT_DATA, Record, Section, cell_array, data_arrays, escaped, write_grid,
};
use crate::ending::without_gz;
use crate::read::Column;
use crate::write::error::{OutputError, WriteFault};
use crate::write::folder::{self, Pieces};
use crate::write::names::pieces_path;
use crate::write::options::WriteOptions;
use crate::write::records::WriteProgress;
use crate::write::row_table::RowTable;
use crate::write::stage::{self, Stage};

/// The content of a piece.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// 2 or 3.
    pub dimension: usize,
    /// Number of points that the worker holds. They come first.
    pub owned_points: usize,
    /// Number of cells that belong to the worker. They come first.
    pub owned_cells: usize,
    /// The row of each point: first those of the worker, ascending, then those of ghost points, ascending.
    pub rows: Vec<u64>,
    /// `dimension` coordinates per point.
    pub coordinates: Vec<f64>,
    /// `dimension + 1` vertices per cell, as positions in `rows`. The cells of the worker and the ghost cells are in
    /// canonical order, and so are the vertices of a cell.
    pub cells: Vec<u64>,
    /// The number of each cell in the whole triangulation. Cells are numbered worker by worker, in canonical order.
    pub cell_ids: Vec<u64>,
    /// The worker of each cell, if it is written.
    pub owner: Option<Vec<u32>>,
    /// The leaf of the partition tree of each cell, if it is written.
    pub owning_leaf: Option<Vec<u64>>,
}

impl Piece {
    /// Returns a piece without points and cells.
    pub fn empty(dimension: usize, with_owner: bool) -> Self {
        let (owner, owning_leaf) = (with_owner.then(Vec::new), with_owner.then(Vec::new));
        Piece { dimension, owner, owning_leaf, ..Piece::default() }
    }
}

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
    folder::check(&pieces_path(path), &[])
}

/// Writes the piece of a worker.
pub fn write_piece(
    files: &Pieces,
    worker: u32,
    piece: &Piece,
    table: &RowTable<'_>,
) -> Result<(), OutputError> {
    files.write(worker - 1, |out| {
        let written = with_arrays(piece, table, |view, arrays| {
            let mut ignore = |_, _| {};
            write_grid(out, view, arrays, &mut WriteProgress::new(0, &mut ignore))
        });
        Ok(written?)
    })
}

/// Writes the file that lists the pieces under a temporary name. The empty piece has their arrays.
pub fn stage_list(
    stage: &mut Stage,
    path: &Path,
    files: &Pieces,
    (empty, table): (&Piece, &RowTable<'_>),
) -> Result<(), OutputError> {
    let sources: Vec<String> = (0..files.count()).map(|piece| files.name(piece)).collect();
    stage.write(path, |out| {
        with_arrays(empty, table, |_, arrays| write_list(out, arrays, files.target(), &sources))
            .map_err(WriteFault::from)
    })
}

/// Calls `body` with a piece as a mesh, and with its arrays of point data and cell data.
fn with_arrays<T>(
    piece: &Piece,
    table: &RowTable<'_>,
    body: impl for<'a> FnOnce(&MeshView<'a>, Vec<Array<'a>>) -> T,
) -> T {
    let of_piece = |column: &Column| Column {
        name: column.name.clone(),
        values: piece.rows.iter().map(|&row| column.values[table.position(row)]).collect(),
    };
    let heights = table.heights.as_ref();
    let heights: Option<Vec<f64>> =
        heights.map(|all| piece.rows.iter().map(|&row| all[table.position(row)]).collect());
    let columns: Vec<Column> = table.columns.iter().map(of_piece).collect();
    let options = WriteOptions { with_owner: true, point_data: &columns, ..WriteOptions::default() };
    let view = MeshView {
        dimension: piece.dimension,
        coordinates: &piece.coordinates,
        heights: heights.as_deref(),
        cells: &piece.cells,
        owner: piece.owner.as_deref(),
        owning_leaf: piece.owning_leaf.as_deref(),
        run: None,
        labels: None,
    };
    let mut arrays = data_arrays(&view, &options);
    for array in arrays.iter_mut().filter(|array| array.has_global_ids()) {
        array.record = if array.section == Section::PointData {
            Box::new(|buffer, i| buffer.extend_from_slice(&table.number(piece.rows[i]).to_le_bytes()))
        } else {
            Box::new(|buffer, i| buffer.extend_from_slice(&piece.cell_ids[i].to_le_bytes()))
        };
    }
    let of_points = arrays.iter().take_while(|array| array.section == Section::PointData).count();
    arrays.insert(of_points, ghost_types(Section::PointData, piece.rows.len(), piece.owned_points));
    arrays.push(ghost_types(Section::CellData, piece.cell_ids.len(), piece.owned_cells));
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
    arrays.push(vtu::points(3, (&[], None)));
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
