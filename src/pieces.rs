//! A triangulation in memory as the workers made it: pieces with 32-bit numbers inside, a table of input
//! indices each, and adjacency within and across pieces.
//!
//! A cell is in the piece of the worker where its lexicographically smallest vertex is at home. Canonical rows
//! of 64-bit indices are an export ([`Pieces::rows`], four times the size of a piece's own rows with all that is
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
    /// `d + 1` vertices a cell, positively oriented.
    pub cells: Vec<u32>,
    /// Across the facet opposite each vertex: a cell of this piece, [`HULL`], or, from [`SEAM`] on, a place in
    /// `seam`.
    pub neighbours: Vec<u32>,
    /// Cells of other pieces: piece, cell.
    pub seam: Vec<(u32, u32)>,
}

/// All cells of a triangulation, each in one piece.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pieces {
    corners: usize,
    pieces: Vec<Piece>,
}

/// A facet that another piece shares: its vertices' input indices (sorted), piece, entry in `neighbours`.
type Open = ([u64; 3], u32, u32);

impl Pieces {
    /// Joins pieces, whose cells have `corners` vertices, across their seams. Nothing if three cells share a
    /// facet, or if other than `hull_facets` have one cell.
    pub(crate) fn join(corners: usize, mut pieces: Vec<Piece>, hull_facets: u64) -> Option<Self> {
        pieces.sort_by_key(|p| p.owner);
        let mut open: Vec<Open> = pieces
            .par_iter()
            .enumerate()
            .flat_map_iter(|(at, piece)| piece.open(corners, at as u32))
            .collect();
        open.par_sort_unstable();
        for pair in open.chunk_by(|a, b| a.0 == b.0) {
            let [(_, a, at), (_, b, bt)] = match *pair {
                [a, b] => [a, b],
                [(_, a, at)] => {
                    pieces[a as usize].neighbours[at as usize] = HULL;
                    continue;
                }
                _ => return None,
            };
            for (piece, entry, other) in
                [(a, at, (b, bt / corners as u32)), (b, bt, (a, at / corners as u32))]
            {
                let piece = &mut pieces[piece as usize];
                piece.neighbours[entry as usize] = SEAM + piece.seam.len() as u32;
                piece.seam.push(other);
            }
        }
        let hull: usize =
            pieces.par_iter().map(|p| p.neighbours.iter().filter(|&&code| code == HULL).count()).sum();
        (hull as u64 == hull_facets).then_some(Pieces { corners, pieces })
    }

    /// The pieces, by rank.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.pieces.iter().map(|p| p.cells.len() / self.corners.max(1)).sum()
    }

    /// Is there no cell?
    pub fn is_empty(&self) -> bool {
        self.pieces.iter().all(|p| p.cells.is_empty())
    }

    /// The cell across the facet opposite the vertex in `slot` of a cell, as piece and cell; nothing across a
    /// hull facet.
    pub fn neighbour(&self, piece: u32, cell: u32, slot: usize) -> Option<(u32, u32)> {
        let own = &self.pieces[piece as usize];
        match own.neighbours[cell as usize * self.corners + slot] {
            HULL => None,
            code if code >= SEAM => Some(own.seam[(code - SEAM) as usize]),
            code => Some((piece, code)),
        }
    }

    /// The input indices of a cell's vertices, positively oriented.
    pub fn cell(&self, piece: u32, cell: u32) -> impl Iterator<Item = u64> + '_ {
        let own = &self.pieces[piece as usize];
        let start = cell as usize * self.corners;
        own.cells[start..start + self.corners].iter().map(|&v| own.ids[v as usize])
    }

    /// All cells as rows of input indices, piece by piece, with the owner and the leaf of each if asked for.
    pub(crate) fn rows(&self, with_owner: bool) -> crate::canonical::Cells {
        let mut rows = Vec::with_capacity(self.len() * self.corners);
        let (mut owner, mut leaf) = (Vec::new(), Vec::new());
        for piece in &self.pieces {
            rows.par_extend(piece.cells.par_iter().map(|&v| piece.ids[v as usize]));
            if with_owner {
                let n = piece.cells.len() / self.corners;
                owner.extend(std::iter::repeat_n(piece.owner, n));
                leaf.extend(std::iter::repeat_n(piece.leaf, n));
            }
        }
        crate::canonical::Cells { rows, owner: with_owner.then_some(owner), leaf: with_owner.then_some(leaf) }
    }

    /// The same in canonical order.
    pub(crate) fn canonical<P: Point>(&self, with_owner: bool) -> crate::canonical::Cells {
        crate::canonical::canonicalise::<P>(self.rows(with_owner))
    }
}

impl Piece {
    fn open(&self, corners: usize, at: u32) -> Vec<Open> {
        let entries = self.neighbours.iter().zip(0u32..).filter(|&(&code, _)| code == SEAM);
        entries.map(|(_, entry)| (self.facet(corners, entry as usize), at, entry)).collect()
    }

    /// The sorted input indices of a facet's vertices, in the plane with a zero before them.
    fn facet(&self, corners: usize, entry: usize) -> [u64; 3] {
        let cell = &self.cells[entry / corners * corners..][..corners];
        let mut facet = [0; 3];
        let others = cell.iter().enumerate().filter(|&(slot, _)| slot != entry % corners);
        for (to, (_, &v)) in facet[4 - corners..].iter_mut().zip(others) {
            *to = self.ids[v as usize];
        }
        facet[4 - corners..].sort_unstable();
        facet
    }
}
