//! A piece of a `.pvtu` file: points and cells of a worker, and its ghosts.

use std::path::PathBuf;

use glam::DVec3;
use septet_core::model::Points;

use super::super::arrays::{self, Arrays, DataArray};
use super::super::grid::{agree, integers, parse};
use crate::read::cells::CellOptions;
use crate::read::error::{InputError, Place};
use crate::read::points::ReadOptions;
use crate::read::text::Source;

/// The bit of a ghost (`DUPLICATECELL`, `DUPLICATEPOINT`).
const GHOST: i64 = 1;

/// What to do with pieces of other programs.
pub const ADVICE: &str = "give a .pvtu file of septet, or a .vtu file of the whole triangulation";

/// A piece.
pub struct Piece {
    pub path: PathBuf,
    /// 2 or 3.
    pub dimension: usize,
    /// The global id of each point.
    pub ids: Vec<u64>,
    /// Whether each point is a ghost.
    pub ghost_points: Vec<bool>,
    pub places: Vec<DVec3>,
    /// The vertices of the cells, as positions in the piece.
    pub cells: Vec<u64>,
    /// Whether each cell is a ghost.
    pub ghost_cells: Vec<bool>,
    /// The global number of each cell, if the file has them.
    pub cell_ids: Option<Vec<u64>>,
    /// The worker of each cell, if the file has them.
    pub owners: Option<Vec<u64>>,
    pub notes: Vec<String>,
}

impl Piece {
    /// Reads a piece.
    pub fn read(source: Source<'_>, options: &CellOptions) -> Result<Self, InputError> {
        let grid = arrays::open(source)?;
        let mesh = parse(source, &ReadOptions::default())?;
        let (points, cells) = mesh.into_both(options)?;
        if cells.cell_count() as u64 != grid.cell_count {
            return Err(source.unsupported(Place::Whole, "a piece with cells of several kinds", ADVICE));
        }
        let (points_of, cells_of) = (("points", grid.point_count), ("cells", grid.cell_count));
        let ids = values(&grid, grid.point_ids.as_ref(), points_of)?;
        let ghost_points = values(&grid, grid.point_ghosts.as_ref(), points_of)?;
        let ghost_cells = values(&grid, grid.ghosts.as_ref(), cells_of)?;
        let numbers = |array: &Option<DataArray<'_>>| {
            let array = array.as_ref();
            array.map(|_| unsigned(source, values(&grid, array, cells_of)?)).transpose()
        };
        Ok(Piece {
            path: source.path.to_owned(),
            dimension: cells.dimension,
            ids: unsigned(source, ids)?,
            ghost_points: flags(&ghost_points),
            places: in_space(points.points),
            cells: cells.cells,
            ghost_cells: flags(&ghost_cells),
            cell_ids: numbers(&grid.cell_ids)?,
            owners: numbers(&grid.owners)?,
            notes: cells.notes,
        })
    }

    /// Whether the piece has no cells.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Returns the cells with their positions in the piece.
    pub fn all_cells(&self) -> impl Iterator<Item = (usize, &[u64])> {
        self.cells.chunks_exact(self.dimension + 1).enumerate()
    }

    /// Returns the cells that are not ghosts, with their positions in the piece.
    pub fn owned_cells(&self) -> impl Iterator<Item = (usize, &[u64])> {
        self.all_cells().filter(|(at, _)| !self.ghost_cells[*at])
    }
}

fn flags(kinds: &[i64]) -> Vec<bool> {
    kinds.iter().map(|kind| kind & GHOST != 0).collect()
}

fn in_space(points: Points) -> Vec<DVec3> {
    match points {
        Points::Plane(points) => points.iter().map(|point| point.extend(0.0)).collect(),
        Points::Space(points) => points,
        // The points of a grid have three coordinates.
        Points::Higher(_) => Vec::new(),
    }
}

fn unsigned(source: Source<'_>, values: Vec<i64>) -> Result<Vec<u64>, InputError> {
    let negative = |_| source.unsupported(Place::Whole, "a negative global id", ADVICE);
    values.into_iter().map(|value| u64::try_from(value).map_err(negative)).collect()
}

/// Returns the values of an array of a piece, one for each of `count` points or cells.
fn values(
    grid: &Arrays<'_>,
    array: Option<&DataArray<'_>>,
    (what, count): (&'static str, u64),
) -> Result<Vec<i64>, InputError> {
    let Some(array) = array else {
        let needed = "a piece without GlobalPointIds and vtkGhostType";
        return Err(grid.source.unsupported(Place::Whole, needed, ADVICE));
    };
    let values = integers(grid, array)?;
    agree(grid, array, what, count, values.len() as u64, false)?;
    Ok(values)
}
