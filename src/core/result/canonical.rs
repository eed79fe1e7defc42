//! The canonical order of cells, in which they are exported. No phase counts the sorting.
//!
//! A row starts with its smallest index, followed by the second smallest. The order of the last two indices (in the
//! plane, of the second and third) keeps the orientation positive. Rows are sorted. The output therefore depends on the
//! triangulation only.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use septet_geometry::point::Point;
use septet_protocol::ids::Rank;
use septet_workers::share::Share;

pub use crate::result::pieces::LabelledCells;
use crate::result::pieces::Pieces;

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

/// Cells as rows of input indices, part by part.
#[derive(Clone, Debug, Default)]
pub(crate) struct OwnedRows {
    /// The rows of each rank.
    parts: Vec<Vec<u64>>,
    /// The rank of each cell, if kept.
    owners: Vec<Rank>,
    /// The leaf of each cell, if kept.
    leaves: Vec<u64>,
}

impl OwnedRows {
    /// Takes the cells of all shares. If `with_owner` is set, also takes the rank and the leaf of each.
    pub(crate) fn of<P: Point>(shares: &mut [Share<P>], with_owner: bool) -> Self {
        let mut all = OwnedRows::default();
        for share in shares {
            let mut cells = std::mem::take(&mut share.cells);
            if with_owner {
                all.owners.extend(std::iter::repeat_n(share.rank, cells.rows.len() / (P::DIM + 1)));
                all.leaves.append(&mut cells.leaves);
            }
            all.parts.push(cells.rows);
        }
        all
    }
}

/// Cells before they are exported.
#[derive(Clone, Debug)]
pub(crate) enum Store {
    /// Rows of input indices, rank by rank.
    Rows(OwnedRows),
    /// Subdomain triangulations.
    Pieces(Pieces),
    /// This number of cells, which several processes hold.
    Elsewhere(u64),
}

/// The cells of a run. The first request brings them into canonical order.
#[derive(Clone, Debug)]
pub(crate) struct Export {
    space: usize,
    store: Store,
    with_owner: bool,
    canonical: OnceLock<LabelledCells>,
}

impl Export {
    /// Stores cells of `space + 1` vertices. If `with_owner` is set, the owner of each cell is exported.
    pub(crate) fn new(space: usize, store: Store, with_owner: bool) -> Self {
        Export { space, store, with_owner, canonical: OnceLock::new() }
    }

    /// Returns the number of cells.
    pub(crate) fn len(&self) -> usize {
        match &self.store {
            Store::Rows(rows) => rows.parts.iter().map(Vec::len).sum::<usize>() / (self.space + 1),
            Store::Pieces(pieces) => pieces.len(),
            Store::Elsewhere(cells) => *cells as usize,
        }
    }

    /// Returns the subdomain triangulations, if the run made any.
    pub(crate) fn pieces(&self) -> Option<&Pieces> {
        match &self.store {
            Store::Rows(_) | Store::Elsewhere(_) => None,
            Store::Pieces(pieces) => Some(pieces),
        }
    }

    /// Returns the cells in canonical order.
    pub(crate) fn canonical(&self) -> &LabelledCells {
        self.canonical.get_or_init(|| {
            let cells = self.unsorted();
            if self.space == 2 { canonicalise::<DVec2>(cells) } else { canonicalise::<DVec3>(cells) }
        })
    }

    fn unsorted(&self) -> LabelledCells {
        match &self.store {
            Store::Pieces(pieces) => pieces.rows(self.with_owner),
            Store::Elsewhere(_) => LabelledCells::default(),
            Store::Rows(OwnedRows { parts, owners, leaves }) => LabelledCells {
                rows: parts.concat(),
                owner: self.with_owner.then(|| owners.clone()),
                leaf: self.with_owner.then(|| leaves.clone()),
            },
        }
    }
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
        let parts = vec![vec![9, 8, 7, 6], vec![], vec![0, 1, 2, 3]];
        let export = Export::new(3, Store::Rows(OwnedRows { parts, ..OwnedRows::default() }), false);
        assert_eq!(export.len(), 2);
        assert_eq!(export.canonical().rows, [0, 1, 2, 3, 6, 7, 8, 9]);
    }
}
