//! The canonical order of cells: an export, counted in no phase.
//!
//! A row starts with its smallest index, then the second smallest; the last two (in the plane: the second
//! and third) stand in the order that keeps the orientation positive. Rows are sorted. So the bytes written
//! depend on the triangulation alone.

use rayon::prelude::*;

use septet_geometry::point::Point;

/// Puts a positively oriented row into canonical order: sorts it and, if that was an odd permutation, swaps
/// the last two.
fn canonical_row(row: &mut [u64]) {
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

/// Cells with what travels beside them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cells {
    /// `DIM + 1` indices a row.
    pub(crate) rows: Vec<u64>,
    /// Owner of each row, if kept.
    pub(crate) owner: Option<Vec<u32>>,
    /// Home leaf of each row, if kept.
    pub(crate) leaf: Option<Vec<u64>>,
}

/// Brings positively oriented cells into canonical order.
pub(crate) fn canonicalise<P: Point>(mut cells: Cells) -> Cells {
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
    use super::*;
    use glam::{DVec2, DVec3};

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
        let cells = Cells { rows: vec![4, 5, 6, 1, 2, 3], owner: Some(vec![7, 8]), leaf: Some(vec![70, 80]) };
        let sorted = canonicalise::<DVec2>(cells);
        assert_eq!(sorted.rows, [1, 2, 3, 4, 5, 6]);
        assert_eq!(sorted.owner, Some(vec![8, 7]));
        let cells = Cells { rows: vec![9, 8, 7, 6, 0, 1, 2, 3], owner: None, leaf: None };
        assert_eq!(canonicalise::<DVec3>(cells).rows, [0, 1, 2, 3, 6, 7, 8, 9]);
    }
}
