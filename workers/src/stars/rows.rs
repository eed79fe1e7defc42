//! Cells on the wire: rows of positions among the points they name, each point once.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use septet_geometry::point::{Point, Simplex};
use septet_protocol::message::PointBatch;

use crate::state::table::{IdHasher, Table};

/// Objected cells, number of points against each, and their positions.
pub(crate) type Objections<P> = (Rows<P>, Vec<u32>, Vec<u32>);

/// Cells as rows of positions among the points they name.
pub(crate) struct Rows<P> {
    pub(crate) points: PointBatch<P>,
    pub(crate) cells: Vec<u32>,
    places: HashMap<u64, u32, BuildHasherDefault<IdHasher>>,
}

impl<P> Default for Rows<P> {
    fn default() -> Self {
        Rows { points: PointBatch::default(), cells: Vec::new(), places: HashMap::default() }
    }
}

impl<P: Point> Rows<P> {
    /// The position of a point, which is added if need be.
    pub(crate) fn place(&mut self, table: &Table<P>, v: u32) -> u32 {
        let next = self.points.len() as u32;
        let place = *self.places.entry(u64::from(v)).or_insert(next);
        if place == next {
            table.export(v, &mut self.points);
        }
        place
    }

    /// Adds a cell: from, to, then the others.
    pub(crate) fn cell(&mut self, table: &Table<P>, from: u32, to: u32, cell: &P::Cell) {
        let others = cell.as_ref().iter().copied().filter(|&v| v != from && v != to);
        for v in [from, to].into_iter().chain(others) {
            let place = self.place(table, v);
            self.cells.push(place);
        }
    }
}

/// The cell of a row.
pub(crate) fn cell_of<P: Point>(row: &[u32], numbers: &[u32]) -> P::Cell {
    let mut cell = P::Cell::splat(0);
    for (v, &place) in cell.as_mut().iter_mut().zip(row) {
        *v = numbers[place as usize];
    }
    cell
}
