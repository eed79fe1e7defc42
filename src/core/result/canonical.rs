//! The canonical order of cells, in which they are exported. No phase counts the sorting.
//!
//! A row starts with its smallest index, followed by the second smallest. The order of the last two indices (in the
//! plane, of the second and third) keeps the orientation positive. Rows are sorted. The output therefore depends on the
//! triangulation only.

use rayon::prelude::*;

use septet_geometry::point::Point;

use crate::result::share::WorkerShare;

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
        let vertices = share.rows().map(|row| &row[..corners]);
        rows.par_extend(vertices.flat_map_iter(|cell| cell.iter().map(|&v| share.ids[v as usize])));
        if with_labels {
            owner.extend(std::iter::repeat_n(share.rank, share.cell_count()));
            leaf.extend(share.leaf_of_cells().map(|leaf| leaf.0));
        }
    }
    LabelledCells { rows, owner: with_labels.then_some(owner), leaf: with_labels.then_some(leaf) }
}

/// Brings positively oriented cells into canonical order.
pub fn canonicalise<P: Point>(mut cells: LabelledCells) -> LabelledCells {
    let rows: &mut [P::Row] = bytemuck::cast_slice_mut(&mut cells.rows);
    rows.par_iter_mut().for_each(|row| canonical_row(row.as_mut()));
    match (&mut cells.owner, &mut cells.leaf) {
        (Some(owner), Some(leaf)) => {
            let mut order: Vec<u32> = (0..rows.len() as u32).collect();
            order.par_sort_unstable_by(|&a, &b| rows[a as usize].cmp(&rows[b as usize]));
            let sorted: Vec<P::Row> = order.iter().map(|&i| rows[i as usize]).collect();
            rows.copy_from_slice(&sorted);
            *owner = order.iter().map(|&i| owner[i as usize]).collect();
            *leaf = order.iter().map(|&i| leaf[i as usize]).collect();
        }
        _ => rows.par_sort_unstable(),
    }
    cells
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
