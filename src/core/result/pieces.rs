//! A triangulation in memory as the workers made it: pieces with 32-bit numbers inside, a table of input
//! indices each, and adjacency within and across pieces.
//!
//! A cell is in the piece of the worker where its lexicographically smallest vertex is at home. Canonical rows
//! of 64-bit indices are an export (`Pieces::rows`, four times the size of a piece's own rows with all that is
//! needed to sort them).

use rayon::prelude::*;
use septet_geometry::point::Point;
use septet_workers::merge::{HULL, SEAM};

/// One worker's cells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Piece {
    /// The worker's rank.
    pub owner: u32,
    /// The leaf of the partition tree that was home to the worker's points.
    pub leaf: u64,
    /// Input index of each vertex.
    pub ids: Vec<u64>,
    /// A row a cell: `d + 1` vertices, positively oriented, then across the facet opposite each a cell of this
    /// piece, [`HULL`], or, from [`SEAM`] on, a place in `seam`.
    pub rows: Vec<u32>,
    /// Cells of other pieces: piece, cell.
    pub seam: Vec<(u32, u32)>,
}

/// All cells of a triangulation, each in one piece.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pieces {
    corners: usize,
    pieces: Vec<Piece>,
}

/// A piece before it is joined to the others: its neighbours in other pieces are marked [`SEAM`].
#[derive(Clone, Debug)]
pub(crate) struct Loose {
    pub(crate) piece: Piece,
    /// The cells with a facet that is not shared in the piece, by their numbers.
    pub(crate) open: Vec<u32>,
}

/// A facet that another piece shares: its vertices' input indices (sorted), piece, place in `rows`.
type Open = ([u64; 3], u32, u32);

impl Pieces {
    /// Joins pieces, whose cells have `corners` vertices, across their seams. Nothing if three cells share a
    /// facet, if other than `hull_facets` have one cell, or if a list does not ascend or names no cell. A facet that neither of its cells'
    /// pieces lists is not noticed.
    pub(crate) fn join(corners: usize, mut loose: Vec<Loose>, hull_facets: u64) -> Option<Self> {
        loose.sort_by_key(|l| l.piece.owner);
        let facets = |(at, loose): (usize, &Loose)| loose.piece.open(corners, at as u32, &loose.open);
        let parts: Option<Vec<(u64, Vec<Open>)>> = loose.par_iter().enumerate().map(facets).collect();
        let mut pieces: Vec<Piece> = loose.into_iter().map(|l| l.piece).collect();
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
                piece.rows[place as usize] = SEAM + piece.seam.len() as u32;
                piece.seam.push(other);
            }
        }
        (hull == hull_facets).then_some(Pieces { corners, pieces })
    }

    /// The pieces, by rank.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.pieces.iter().map(|p| p.rows.len() / (2 * self.corners).max(1)).sum()
    }

    /// Is there no cell?
    pub fn is_empty(&self) -> bool {
        self.pieces.iter().all(|p| p.rows.is_empty())
    }

    /// The cell across the facet opposite the vertex in `slot` of a cell, as piece and cell; nothing across a
    /// hull facet.
    pub fn neighbour(&self, piece: u32, cell: u32, slot: usize) -> Option<(u32, u32)> {
        let own = &self.pieces[piece as usize];
        match own.rows[(2 * cell as usize + 1) * self.corners + slot] {
            HULL => None,
            code if code >= SEAM => Some(own.seam[(code - SEAM) as usize]),
            code => Some((piece, code)),
        }
    }

    /// The input indices of a cell's vertices, positively oriented.
    pub fn cell(&self, piece: u32, cell: u32) -> impl Iterator<Item = u64> + '_ {
        let own = &self.pieces[piece as usize];
        let start = 2 * cell as usize * self.corners;
        own.rows[start..start + self.corners].iter().map(|&v| own.ids[v as usize])
    }

    /// All cells as rows of input indices, piece by piece, with the owner and the leaf of each if asked for.
    pub(crate) fn rows(&self, with_owner: bool) -> crate::result::canonical::Cells {
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
        crate::result::canonical::Cells {
            rows,
            owner: with_owner.then_some(owner),
            leaf: with_owner.then_some(leaf),
        }
    }

    /// The same in canonical order.
    pub(crate) fn canonical<P: Point>(&self, with_owner: bool) -> crate::result::canonical::Cells {
        crate::result::canonical::canonicalise::<P>(self.rows(with_owner))
    }
}

impl Piece {
    /// The number of hull facets, and all facets that other pieces share, of some cells; nothing if they do not
    /// ascend or there is no such cell.
    fn open(&self, corners: usize, at: u32, cells: &[u32]) -> Option<(u64, Vec<Open>)> {
        if !cells.is_sorted_by(|a, b| a < b) {
            return None;
        }
        let width = 2 * corners;
        let (mut hull, mut open) = (0, Vec::with_capacity(cells.len()));
        for &cell in cells {
            let start = cell as usize * width;
            let row = self.rows.get(start..start + width)?;
            for (slot, &code) in row.iter().enumerate().skip(corners) {
                match code {
                    HULL => hull += 1,
                    SEAM.. => open.push((self.facet(corners, start + slot), at, (start + slot) as u32)),
                    _ => {}
                }
            }
        }
        Some((hull, open))
    }

    /// The sorted input indices of a facet's vertices, in the plane with a zero before them.
    fn facet(&self, corners: usize, place: usize) -> [u64; 3] {
        let cell = &self.rows[place / (2 * corners) * 2 * corners..][..corners];
        let mut facet = [0; 3];
        let others = cell.iter().enumerate().filter(|&(slot, _)| slot != place % corners);
        for (to, (_, &v)) in facet[4 - corners..].iter_mut().zip(others) {
            *to = self.ids[v as usize];
        }
        facet[4 - corners..].sort_unstable();
        facet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles, in a piece each, with these lists of open cells.
    fn square(open: [&[u32]; 2]) -> Option<Pieces> {
        let sides = [(1, vec![0, 1, 2], [HULL, SEAM, HULL]), (2, vec![0, 2, 3], [HULL, HULL, SEAM])];
        let loose = sides.into_iter().zip(open).map(|((owner, ids, across), open)| {
            let rows = [0, 1, 2].into_iter().chain(across).collect();
            Loose { piece: Piece { owner, leaf: 1, ids, rows, seam: Vec::new() }, open: open.to_vec() }
        });
        // In no order.
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
