//! A triangulation whose indices count all rows of the input, including rows that were dropped.

use super::options::KeptRows;
use crate::read::Column;
use septet_core::model::{MeshView, Shares};

/// The arrays of a triangulation, with one entry for each row of the input.
pub(super) struct InputRows {
    coordinates: Vec<f64>,
    cells: Vec<u64>,
    point_owner: Option<Vec<u32>>,
    /// The columns of the input.
    pub columns: Vec<Column>,
}

impl InputRows {
    /// Renumbers a triangulation. The coordinates and values of dropped rows are 0.
    pub fn of(view: &MeshView<'_>, columns: &[Column], kept: KeptRows<'_>) -> Self {
        let source = kept.rows;
        let rows = source.len() + kept.dropped as usize;
        let of_column = |column: &Column| Column {
            name: column.name.clone(),
            values: spread(&column.values, 1, source, rows),
        };
        InputRows {
            coordinates: spread(view.coordinates, view.dimension, source, rows),
            cells: view.cells.iter().map(|&v| source[v as usize]).collect(),
            point_owner: view.shares.map(|shares| spread(shares.point_owner, 1, source, rows)),
            columns: columns.iter().map(of_column).collect(),
        }
    }

    /// Returns the renumbered triangulation. `view` is the one from which it was made.
    pub fn view<'a>(&'a self, view: &MeshView<'a>) -> MeshView<'a> {
        let shares = view.shares.zip(self.point_owner.as_deref());
        MeshView {
            coordinates: &self.coordinates,
            cells: &self.cells,
            shares: shares.map(|(shares, point_owner)| Shares { point_owner, ..shares }),
            ..*view
        }
    }
}

/// Puts the values of points, `width` for each, into the rows of these points. The other rows have zeros.
fn spread<T: Copy + Default>(values: &[T], width: usize, source: &[u64], rows: usize) -> Vec<T> {
    let mut all = vec![T::default(); rows * width];
    for (point, &row) in values.chunks_exact(width).zip(source) {
        all[row as usize * width..][..width].copy_from_slice(point);
    }
    all
}
