//! The canonical order of cells: an export, counted in no phase.
//!
//! A row starts with its smallest index, then the second smallest; the last two (in the plane: the second
//! and third) stand in the order that keeps the orientation positive. Rows are sorted. So the bytes written
//! depend on the triangulation alone.

use std::sync::{Mutex, OnceLock, PoisonError};

use glam::{DVec2, DVec3};
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
pub struct Cells {
    /// `DIM + 1` indices a row.
    pub rows: Vec<u64>,
    /// Owner of each row, if kept.
    pub owner: Option<Vec<u32>>,
    /// Home leaf of each row, if kept.
    pub leaf: Option<Vec<u64>>,
}

/// Cells in the order in which they came, until someone asks for the canonical one: they are sorted once, in place.
#[derive(Debug)]
pub(crate) struct Given {
    space: usize,
    numbers: usize,
    /// Of the cells the rows in the parts in which they came, which are put together when they are sorted.
    cells: Mutex<(Vec<Vec<u64>>, Cells)>,
    sorted: OnceLock<Cells>,
}

impl Given {
    /// Cells of `space + 1` vertices: their rows in parts, and what travels beside them.
    pub(crate) fn new(space: usize, parts: Vec<Vec<u64>>, beside: Cells) -> Self {
        let numbers = parts.iter().map(Vec::len).sum();
        Given { space, numbers, cells: Mutex::new((parts, beside)), sorted: OnceLock::new() }
    }

    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.numbers / (self.space + 1)
    }

    /// The cells in canonical order.
    pub(crate) fn sorted(&self) -> &Cells {
        self.sorted.get_or_init(|| {
            let (parts, mut cells) =
                std::mem::take(&mut *self.cells.lock().unwrap_or_else(PoisonError::into_inner));
            cells.rows.reserve_exact(self.numbers);
            for mut part in parts {
                cells.rows.append(&mut part);
            }
            if self.space == 2 { canonicalise::<DVec2>(cells) } else { canonicalise::<DVec3>(cells) }
        })
    }
}

impl Clone for Given {
    /// Of the sorted cells: others may be on their way from one order to the other.
    fn clone(&self) -> Self {
        let sorted = OnceLock::from(self.sorted().clone());
        Given { space: self.space, numbers: self.numbers, cells: Mutex::default(), sorted }
    }
}

/// Brings positively oriented cells into canonical order.
pub fn canonicalise<P: Point>(mut cells: Cells) -> Cells {
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
        let parts = vec![vec![9, 8, 7, 6], vec![], vec![0, 1, 2, 3]];
        let given = Given::new(3, parts, Cells::default());
        assert_eq!((given.len(), given.clone().len()), (2, 2));
        assert_eq!(given.clone().sorted().rows, [0, 1, 2, 3, 6, 7, 8, 9]);
        assert_eq!(given.sorted().rows, [0, 1, 2, 3, 6, 7, 8, 9]);
    }
}
