//! A triangulation in memory as the workers made it: one piece for each worker, with adjacency within and across pieces.
//!
//! A piece has local vertex indices of 32 bits and a table of their input indices. A cell is in the piece of the worker
//! that owns its lexicographically smallest vertex. Canonical rows of 64-bit indices are made only for export
//! (`Pieces::rows`). With the data needed to sort them, canonical rows take four times the memory of the pieces' own
//! rows.

use rayon::prelude::*;
use septet_protocol::ids::Rank;
use septet_workers::coordinator::PieceRows;
use septet_workers::state::rows::{HULL, INTERFACE};

use crate::result::canonical::LabelledCells;

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
    /// A neighbour is a cell of this piece, or [`HULL`], or [`INTERFACE`] plus a position in `seam`.
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

/// A facet that another piece may share: the input indices of its vertices (sorted), the piece, the position in `rows`.
type Open = ([u64; 3], u32, u32);

impl Pieces {
    /// Joins pieces across their interfaces. Their cells have `corners` vertices. Returns `None`
    /// - if three cells share a facet,
    /// - if the number of facets with one cell is not `hull_facets`, or
    /// - if a list of open cells does not ascend or contains an index that is not a cell.
    ///
    /// A facet between pieces is not detected if neither of its cells is listed as open.
    pub(crate) fn join(corners: usize, mut loose: Vec<(Rank, PieceRows)>, hull_facets: u64) -> Option<Self> {
        loose.sort_by_key(|l| l.0);
        let facets = |(at, (_, loose)): (usize, &(Rank, PieceRows))| open_facets(loose, corners, at as u32);
        let parts: Option<Vec<(u64, Vec<Open>)>> = loose.par_iter().enumerate().map(facets).collect();
        let piece =
            |(owner, PieceRows { leaf, ids, rows, .. })| Piece { owner, leaf, ids, rows, seam: Vec::new() };
        let mut pieces: Vec<Piece> = loose.into_iter().map(piece).collect();
        let (mut hull, mut open) = (0, Vec::new());
        for (own, facets) in parts? {
            hull += own;
            open.extend(facets);
        }
        open.par_sort_unstable();
        for pair in open.chunk_by(|a, b| a.0 == b.0) {
            let [(_, a, at), (_, b, bt)] = match *pair {
                [a, b] => [a, b],
                [(_, a, at)] => {
                    pieces[a as usize].rows[at as usize] = HULL;
                    hull += 1;
                    continue;
                }
                _ => return None,
            };
            let width = 2 * corners as u32;
            for (piece, place, other) in [(a, at, (b, bt / width)), (b, bt, (a, at / width))] {
                let piece = &mut pieces[piece as usize];
                piece.rows[place as usize] = INTERFACE + piece.seam.len() as u32;
                piece.seam.push(other);
            }
        }
        (hull == hull_facets).then_some(Pieces { corners, pieces })
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
            code if code >= INTERFACE => Some(own.seam[(code - INTERFACE) as usize]),
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

/// Returns the number of hull facets of the open cells of a piece, and all their facets that other pieces may share.
/// Returns `None` if the open cells do not ascend or one of them does not exist.
fn open_facets(piece: &PieceRows, corners: usize, at: u32) -> Option<(u64, Vec<Open>)> {
    if !piece.open.is_sorted_by(|a, b| a < b) {
        return None;
    }
    let width = 2 * corners;
    let (mut hull, mut open) = (0, Vec::with_capacity(piece.open.len()));
    for &cell in &piece.open {
        let start = cell as usize * width;
        let row = piece.rows.get(start..start + width)?;
        for (slot, &code) in row.iter().enumerate().skip(corners) {
            match code {
                HULL => hull += 1,
                INTERFACE.. => open.push((facet(piece, corners, start + slot), at, (start + slot) as u32)),
                _ => {}
            }
        }
    }
    Some((hull, open))
}

/// Returns the sorted input indices of a facet's vertices. In the plane, a zero comes first.
fn facet(piece: &PieceRows, corners: usize, place: usize) -> [u64; 3] {
    let cell = &piece.rows[place / (2 * corners) * 2 * corners..][..corners];
    let mut facet = [0; 3];
    let others = cell.iter().enumerate().filter(|&(slot, _)| slot != place % corners);
    for (to, (_, &v)) in facet[4 - corners..].iter_mut().zip(others) {
        *to = piece.ids[v as usize];
    }
    facet[4 - corners..].sort_unstable();
    facet
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Joins a square of two triangles, each in its own piece, with these lists of open cells.
    fn square(open: [&[u32]; 2]) -> Option<Pieces> {
        let sides =
            [(1, vec![0, 1, 2], [HULL, INTERFACE, HULL]), (2, vec![0, 2, 3], [HULL, HULL, INTERFACE])];
        let loose = sides.into_iter().zip(open).map(|((owner, ids, across), open)| {
            let rows = [0, 1, 2].into_iter().chain(across).collect();
            (owner, PieceRows { leaf: 1, ids, rows, open: open.to_vec() })
        });
        // The order differs from the order of the owners.
        Pieces::join(3, loose.rev().collect(), 4)
    }

    #[test]
    fn pieces_are_joined_by_their_open_cells() {
        let joined = square([&[0], &[0]]).unwrap();
        let across = |piece, slot| joined.neighbour(piece, 0, slot);
        assert_eq!([0, 1, 2].map(|slot| across(0, slot)), [None, Some((1, 0)), None]);
        assert_eq!([0, 1, 2].map(|slot| across(1, slot)), [None, None, Some((0, 0))]);
    }

    #[test]
    fn lists_that_are_wrong_are_refused() {
        for open in
            [[&[0][..], &[]], [&[], &[0]], [&[0], &[1]], [&[0], &[u32::MAX]], [&[0, 0], &[0]], [&[0, 0], &[]]]
        {
            assert_eq!(square(open), None, "{open:?}");
        }
    }
}
