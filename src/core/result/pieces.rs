//! A triangulation in memory as the workers made it: one piece for each worker, with adjacency within and across pieces.
//!
//! A piece has local vertex indices of 32 bits and a table of their input indices. A cell is in the piece of the worker
//! that owns its lexicographically smallest vertex. Canonical rows of 64-bit indices are made only for export
//! (`Pieces::rows`). With the data needed to sort them, canonical rows take four times the memory of the pieces' own
//! rows.

use rayon::prelude::*;
use septet_protocol::ids::Rank;
use septet_workers::share::{PieceRows, Seam};
use septet_workers::state::rows::{HULL, INTERFACE};

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

/// One worker's cells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Piece {
    /// The worker's rank.
    pub owner: u32,
    /// The leaf of the partition tree that holds the worker's points.
    pub leaf: u64,
    /// Input index of each vertex.
    pub ids: Vec<u64>,
    /// One row per cell: `d + 1` vertices, positively oriented, then the neighbour across the facet opposite each vertex.
    /// A neighbour is a cell of this piece, or [`HULL`], or [`INTERFACE`] plus one plus a position in
    /// `seam`.
    pub rows: Vec<u32>,
    /// Neighbours in other pieces: piece and cell.
    pub seam: Vec<(u32, u32)>,
}

/// All cells of a triangulation, each in one piece.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pieces {
    corners: usize,
    pieces: Vec<Piece>,
}

impl Pieces {
    /// Joins the pieces of ranks, in the order of the ranks. Their cells have `corners` vertices. Returns `None` if the
    /// number of facets on the hull is not `hull_facets`, or if a neighbour is in a piece that does not exist.
    pub(crate) fn join(corners: usize, loose: Vec<(Rank, PieceRows)>, hull_facets: u64) -> Option<Self> {
        let hull: u64 = loose.iter().map(|(_, piece)| piece.hull_facets).sum();
        if hull != hull_facets || !loose.is_sorted_by_key(|(rank, _)| *rank) {
            return None;
        }
        let cells: Vec<(Rank, usize)> =
            loose.iter().map(|(rank, piece)| (*rank, piece.rows.len() / (2 * corners).max(1))).collect();
        let place = |seam: &Seam| {
            let at = cells.binary_search_by_key(&seam.rank, |(rank, _)| *rank).ok()?;
            ((seam.cell as usize) < cells[at].1).then_some((at as u32, seam.cell))
        };
        let piece = |(owner, PieceRows { leaf, ids, rows, seam, .. })| {
            let seam = seam.iter().map(place).collect::<Option<Vec<_>>>()?;
            Some(Piece { owner, leaf, ids, rows, seam })
        };
        let pieces = loose.into_iter().map(piece).collect::<Option<Vec<_>>>()?;
        Some(Pieces { corners, pieces })
    }

    /// Returns the pieces, ordered by rank.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Returns the number of cells.
    pub fn len(&self) -> usize {
        self.pieces.iter().map(|p| p.rows.len() / (2 * self.corners).max(1)).sum()
    }

    /// Returns `true` if there are no cells.
    pub fn is_empty(&self) -> bool {
        self.pieces.iter().all(|p| p.rows.is_empty())
    }

    /// Returns the cell across the facet opposite the vertex in `slot` of a cell, as piece and cell. Returns `None`
    /// for a hull facet.
    pub fn neighbour(&self, piece: u32, cell: u32, slot: usize) -> Option<(u32, u32)> {
        let own = &self.pieces[piece as usize];
        match own.rows[(2 * cell as usize + 1) * self.corners + slot] {
            HULL => None,
            code if code > INTERFACE => Some(own.seam[(code - INTERFACE) as usize - 1]),
            code => Some((piece, code)),
        }
    }

    /// Returns the input indices of a cell's vertices, positively oriented.
    pub fn cell(&self, piece: u32, cell: u32) -> impl Iterator<Item = u64> + '_ {
        let own = &self.pieces[piece as usize];
        let start = 2 * cell as usize * self.corners;
        own.rows[start..start + self.corners].iter().map(|&v| own.ids[v as usize])
    }

    /// Returns all cells as rows of input indices, piece by piece, with the owner and the leaf of each if requested.
    pub(crate) fn rows(&self, with_owner: bool) -> LabelledCells {
        let mut rows = Vec::with_capacity(self.len() * self.corners);
        let (mut owner, mut leaf) = (Vec::new(), Vec::new());
        for piece in &self.pieces {
            let vertices = piece.rows.par_chunks_exact(2 * self.corners).map(|row| &row[..self.corners]);
            rows.par_extend(vertices.flat_map_iter(|cell| cell.iter().map(|&v| piece.ids[v as usize])));
            if with_owner {
                let n = piece.rows.len() / (2 * self.corners);
                owner.extend(std::iter::repeat_n(piece.owner, n));
                leaf.extend(std::iter::repeat_n(piece.leaf, n));
            }
        }
        LabelledCells { rows, owner: with_owner.then_some(owner), leaf: with_owner.then_some(leaf) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Joins a square of two triangles, each in its own piece, with this cell across the diagonal of the first.
    fn square(across: Seam, hull_facets: u64) -> Option<Pieces> {
        let diagonal = INTERFACE + 1;
        let first = ([0, 1, 2], [HULL, diagonal, HULL], across);
        let second = ([0, 2, 3], [HULL, HULL, diagonal], Seam { rank: 3, cell: 0 });
        let loose = [(3, first), (7, second)].map(|(rank, (ids, neighbours, across))| {
            let rows = [0, 1, 2].into_iter().chain(neighbours).collect();
            let (ids, seam) = (ids.to_vec(), vec![across]);
            (
                rank,
                PieceRows { leaf: 1, ids, rows, open: vec![0], seam, hull_facets: 2, ..PieceRows::default() },
            )
        });
        Pieces::join(3, loose.into(), hull_facets)
    }

    #[test]
    fn neighbours_are_found_across_pieces() {
        let joined = square(Seam { rank: 7, cell: 0 }, 4).unwrap();
        let across = |piece, slot| joined.neighbour(piece, 0, slot);
        assert_eq!([0, 1, 2].map(|slot| across(0, slot)), [None, Some((1, 0)), None]);
        assert_eq!([0, 1, 2].map(|slot| across(1, slot)), [None, None, Some((0, 0))]);
    }

    #[test]
    fn pieces_that_do_not_fit_are_refused() {
        assert_eq!(square(Seam { rank: 7, cell: 0 }, 3), None);
        assert_eq!(square(Seam { rank: 5, cell: 0 }, 4), None);
        assert_eq!(square(Seam { rank: 7, cell: 1 }, 4), None);
    }
}
