//! Canonical rows of cells with their neighbours.
//!
//! **Statement.** Each row starts with its smallest vertex, followed by the second smallest; the order of the last two keeps
//! the orientation. Rows are sorted. Entry `k` of the neighbours is the position of the row across the facet opposite vertex
//! `k`.
//!
//! **Method.** The cells of shares are sorted by buckets, one for each smallest vertex, and within each bucket. The inverse
//! permutation renumbers the neighbours. Without neighbours, the facets are sorted in the same way, and equal ones are
//! joined.
//!
//! **Work.** O(n + m) expected for stars of bounded size.

use septet_core::{Neighbour, WorkerShare};
use septet_geometry::point::Simplex;

use crate::dimension::Dimension;
use crate::loops;

/// No cell or vertex: the outside of the hull.
pub const NONE: u32 = u32::MAX;

/// Rows of cells in canonical order.
pub(crate) struct Rows<P: Dimension> {
    pub(crate) cells: Vec<P::Cell>,
    pub(crate) neighbours: Vec<P::Cell>,
}

impl<P: Dimension> Rows<P> {
    /// Collects the cells of the shares of all workers over `n` points.
    pub(crate) fn of_shares(shares: &[WorkerShare], n: usize) -> Self {
        let last_rank = shares.iter().map(|share| share.rank).max().unwrap_or(0);
        let mut first = vec![0; last_rank as usize + 1];
        let mut count = 0;
        for share in shares {
            first[share.rank as usize] = count;
            count += share.cell_count() as u32;
        }
        let mut rows = Vec::with_capacity(count as usize);
        for share in shares {
            let own = first[share.rank as usize];
            rows.extend(loops::map(share.cell_count(), |cell| row::<P>(share, cell, own, &first)));
        }
        let order = order(&loops::map(rows.len(), |i| rows[i].0), n);
        let mut rank = vec![0; rows.len()];
        for (&cell, at) in order.iter().zip(0u32..) {
            rank[cell as usize] = at;
        }
        let cells = loops::map(rows.len(), |at| rows[order[at] as usize].0);
        if !shares.iter().all(WorkerShare::has_neighbours) {
            let neighbours = matched::<P>(&cells, n);
            return Rows { cells, neighbours };
        }
        let neighbours = loops::map(rows.len(), |at| {
            let mut next = rows[order[at] as usize].1;
            for code in next.as_mut().iter_mut().filter(|code| **code != NONE) {
                *code = rank[*code as usize];
            }
            next
        });
        Rows { cells, neighbours }
    }
}

/// Returns a cell of a share as a canonical row, with its neighbours as numbers of all cells. `own` is the number of the first
/// cell of the share, and `first` that of each rank.
fn row<P: Dimension>(share: &WorkerShare, cell: usize, own: u32, first: &[u32]) -> (P::Cell, P::Cell) {
    let (mut vertices, mut next) = (P::Cell::splat(0), P::Cell::splat(NONE));
    for (vertex, id) in vertices.as_mut().iter_mut().zip(share.cell_ids(cell)) {
        *vertex = id as u32;
    }
    for (slot, next) in next.as_mut().iter_mut().enumerate() {
        *next = match share.neighbour(cell, slot) {
            Some(Neighbour::Local(cell)) => own + cell,
            Some(Neighbour::Remote { rank, cell }) => first[rank as usize] + cell,
            Some(Neighbour::Hull) | None => NONE,
        };
    }
    sort(vertices.as_mut(), next.as_mut());
    (vertices, next)
}

/// Puts a positively oriented row into canonical order, and its neighbours into the same order.
fn sort(row: &mut [u32], next: &mut [u32]) {
    let mut odd = false;
    for i in 1..row.len() {
        let mut j = i;
        while j > 0 && row[j - 1] > row[j] {
            row.swap(j - 1, j);
            next.swap(j - 1, j);
            odd = !odd;
            j -= 1;
        }
    }
    if odd {
        let n = row.len();
        row.swap(n - 2, n - 1);
        next.swap(n - 2, n - 1);
    }
}

/// Returns the positions of rows in sorted order. The first entry of each is below `n`.
fn order<S: Simplex>(rows: &[S], n: usize) -> Vec<u32> {
    // `ends` holds the position of the next row of each bucket, and finally the end of each bucket.
    let mut ends = vec![0u32; n + 1];
    for row in rows {
        ends[row.as_ref()[0] as usize + 1] += 1;
    }
    for i in 0..n {
        ends[i + 1] += ends[i];
    }
    let mut order = vec![0u32; rows.len()];
    for (row, at) in rows.iter().zip(0u32..) {
        let end = &mut ends[row.as_ref()[0] as usize];
        order[*end as usize] = at;
        *end += 1;
    }
    let start = |bucket: usize| if bucket == 0 { 0 } else { ends[bucket - 1] as usize };
    let blocks = loops::blocks(n, |buckets| {
        let base = start(buckets.start);
        let mut sorted = order[base..start(buckets.end)].to_vec();
        for bucket in buckets {
            sorted[start(bucket) - base..ends[bucket] as usize - base]
                .sort_unstable_by_key(|&at| rows[at as usize]);
        }
        sorted
    });
    loops::joined(rows.len(), blocks)
}

/// Joins equal facets of cells over `n` points.
fn matched<P: Dimension>(cells: &[P::Cell], n: usize) -> Vec<P::Cell> {
    let corners = P::DIM + 1;
    let facet = |at: usize| {
        let (row, mut facet) = (cells[at / corners].as_ref(), P::Facet::splat(0));
        let others = row.iter().enumerate().filter(|(slot, _)| *slot != at % corners);
        facet.as_mut().iter_mut().zip(others).for_each(|(to, (_, &v))| *to = v);
        facet.as_mut().sort_unstable();
        facet
    };
    let facets = loops::map(cells.len() * corners, facet);
    let order = order(&facets, n);
    let mut neighbours = vec![P::Cell::splat(NONE); cells.len()];
    for pair in order.windows(2) {
        let [a, b] = [pair[0] as usize, pair[1] as usize];
        if facets[a] == facets[b] {
            neighbours[a / corners].as_mut()[a % corners] = (b / corners) as u32;
            neighbours[b / corners].as_mut()[b % corners] = (a / corners) as u32;
        }
    }
    neighbours
}
