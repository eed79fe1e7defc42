//! The canonical order of cells, in which they are exported. No phase counts the sorting.
//!
//! A row starts with its smallest index, followed by the second smallest. The order of the last two indices (in the
//! plane, of the second and third) keeps the orientation positive. Rows are sorted. The output therefore depends on the
//! triangulation only.

use septet_geometry::point::Point;
use septet_workers::config::cores::{each_chunk_mut, sort_rows};

use crate::result::share::WorkerShare;

/// Cells for each unit of parallel work.
const BLOCK: usize = 4096;

/// Puts a positively oriented row into canonical order: sorts it and, if the permutation was odd, swaps the last two.
pub fn canonical_row(row: &mut [u64]) {
    let mut odd = false;
    for i in 1..row.len() {
        let mut j = i;
        while j > 0 && row[j - 1] > row[j] {
            row.swap(j - 1, j);
            odd = !odd;
            j -= 1;
        }
    }
    if odd {
        let n = row.len();
        row.swap(n - 2, n - 1);
    }
}

/// Cells with the owner and the leaf of each.
#[derive(Clone, Debug, Default)]
pub struct LabelledCells {
    /// `DIM + 1` indices per row.
    pub rows: Vec<u64>,
    /// Owner of each row, if kept.
    pub owner: Option<Vec<u32>>,
    /// Leaf of each row, if kept.
    pub leaf: Option<Vec<u64>>,
}

/// Returns the cells of shares as rows of `corners` input indices, share by share, with the owner and the leaf of each if
/// requested.
pub(crate) fn rows_of_shares(shares: &[WorkerShare], corners: usize, with_labels: bool) -> LabelledCells {
    let cells: usize = shares.iter().map(WorkerShare::cell_count).sum();
    let mut rows = Vec::with_capacity(cells * corners);
    let (mut owner, mut leaf) = (Vec::new(), Vec::new());
    for share in shares {
        let start = rows.len();
        rows.resize(start + share.cell_count() * corners, 0);
        each_chunk_mut(&mut rows[start..], BLOCK * corners, |block, rows| {
            for (cell, row) in (block * BLOCK..).zip(rows.chunks_exact_mut(corners)) {
                row.iter_mut().zip(share.cell_ids(cell)).for_each(|(to, id)| *to = id);
            }
        });
        if with_labels {
            owner.extend(std::iter::repeat_n(share.rank, share.cell_count()));
            leaf.extend(share.leaf_of_cells().map(|leaf| leaf.0));
        }
    }
    LabelledCells { rows, owner: with_labels.then_some(owner), leaf: with_labels.then_some(leaf) }
}

/// Brings positively oriented cells into canonical order.
pub fn canonicalise<P: Point>(mut cells: LabelledCells) -> LabelledCells {
    let corners = P::DIM + 1;
    each_chunk_mut(&mut cells.rows, BLOCK * corners, |_, rows| {
        rows.chunks_exact_mut(corners).for_each(canonical_row);
    });
    let width = corners + 2;
    let Some(mut all) = cells.with_labels(corners) else {
        sort_rows(&mut cells.rows, corners);
        return cells;
    };
    sort_rows(&mut all, width);
    let column = |at: usize| all.chunks_exact(width).map(move |row| row[corners + at]);
    let owner = Some(column(0).map(|owner| owner as u32).collect());
    let leaf = Some(column(1).collect());
    let mut rows = Vec::with_capacity(all.len() / width * corners);
    all.chunks_exact(width).for_each(|row| rows.extend_from_slice(&row[..corners]));
    LabelledCells { rows, owner, leaf }
}

impl LabelledCells {
    /// Returns rows that end with the owner and the leaf, or `None` without them. Such cells are taken.
    fn with_labels(&mut self, corners: usize) -> Option<Vec<u64>> {
        let (owner, leaf) = (self.owner.take()?, self.leaf.take()?);
        let rows = std::mem::take(&mut self.rows);
        let mut all = Vec::with_capacity(owner.len() * (corners + 2));
        for ((row, owner), leaf) in rows.chunks_exact(corners).zip(owner).zip(leaf) {
            all.extend_from_slice(row);
            all.extend([u64::from(owner), leaf]);
        }
        Some(all)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn rows_keep_their_orientation() {
        let mut t = [5, 2, 9];
        canonical_row(&mut t);
        // (5, 2, 9) is the cyclic (2, 9, 5).
        assert_eq!(t, [2, 9, 5]);
        let mut q = [3, 1, 2, 0];
        canonical_row(&mut q);
        // (3,1,2,0) to (0,1,2,3) is one transposition, odd.
        assert_eq!(q, [0, 1, 3, 2]);
    }

    #[test]
    fn rows_are_sorted_with_their_owners() {
        let cells =
            LabelledCells { rows: vec![4, 5, 6, 1, 2, 3], owner: Some(vec![7, 8]), leaf: Some(vec![70, 80]) };
        let sorted = canonicalise::<DVec2>(cells);
        assert_eq!(sorted.rows, [1, 2, 3, 4, 5, 6]);
        assert_eq!(sorted.owner, Some(vec![8, 7]));
    }
}
