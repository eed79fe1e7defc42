//! The cells of a periodic triangulation: one of each class of translated cells, in canonical order.
//!
//! A vertex of a cell is a row and a vector of lengths, its *offset*: the vertex lies at the row's point plus the offset times
//! the box. The least row has the offset 0. If it occurs several times, the occurrence is taken for which the sorted
//! vertices are least. Vertices are sorted by row and offset; the order of the last two keeps the orientation positive.
//! Cells are sorted by their vertices. So the result depends on the triangulation only.

use std::ops::Range;

use septet_geometry::point::{Point, Position, is_lex_smaller};
use septet_geometry::site::Weighted;
use septet_workers::config::cores::map_blocks;

use super::images::{Images, Sites};
use crate::result::periodic::{Steps, Vertex, difference};
use crate::result::share::{Neighbour, WorkerShare};

/// The cells of the result.
#[derive(Debug, Default)]
pub(super) struct Quotient {
    /// The packed vertices of all cells, `space + 1` for each. Each cell is in canonical order.
    pub(super) packed: Vec<u64>,
    /// The sum of the volumes of the cells.
    pub(super) volume: f64,
}

impl Quotient {
    fn join(mut self, other: Self) -> Self {
        self.packed.extend(other.packed);
        self.volume += other.volume;
        self
    }
}

/// Number of cells that one core handles in turn.
const BLOCK: usize = 1 << 14;

/// The triangulation of some images.
#[derive(Clone, Copy)]
pub(super) struct Covered<'a, P: Position> {
    pub(super) sites: &'a Sites<P>,
    pub(super) images: &'a Images<P>,
    pub(super) shares: &'a [WorkerShare],
    pub(super) width: f64,
}

impl<P: Position> Covered<'_, P> {
    /// Returns `true` if the stars of all base sites are those of all images. A cover with all images needs no check.
    pub(super) fn is_complete(self) -> bool {
        self.sites.has_all(self.width) || self.shares.iter().all(|share| self.is_complete_in(share))
    }

    fn is_complete_in(self, share: &WorkerShare) -> bool {
        let blocks = map_blocks(share.cell_count(), BLOCK, |cells| {
            cells.into_iter().all(|cell| self.is_complete_at(share, cell))
        });
        blocks.into_iter().all(|is_complete| is_complete)
    }

    fn is_complete_at(self, share: &WorkerShare, cell: usize) -> bool {
        let ids = sites_of(share, cell);
        let is_base = ids.map(|id| self.images.is_base(id));
        let has_base = |except: usize| (0..=P::DIM).any(|at| at != except && is_base[at]);
        if !has_base(usize::MAX) {
            return true;
        }
        let on_hull = |slot: usize| share.neighbour(cell, slot) == Some(Neighbour::Hull);
        let is_open = (0..=P::DIM).any(|slot| on_hull(slot) && has_base(slot));
        !is_open && !self.sites.leaves_cover(&self.corners(ids)[..=P::DIM], self.width)
    }

    fn corners(self, ids: [u64; 4]) -> [Weighted<P>; 4] {
        let mut corners = [Weighted::default(); 4];
        for (corner, id) in corners.iter_mut().zip(&ids[..=P::DIM]) {
            *corner = self.images.sites[*id as usize];
        }
        corners
    }

    /// Returns the cells whose lexicographically smallest vertices are base sites.
    pub(super) fn quotient(self) -> Quotient {
        let of_share = |share: &WorkerShare| {
            let blocks = map_blocks(share.cell_count(), BLOCK, |cells| self.quotient_of(share, cells));
            blocks.into_iter().fold(Quotient::default(), Quotient::join)
        };
        self.shares.iter().map(of_share).fold(Quotient::default(), Quotient::join)
    }

    fn quotient_of(self, share: &WorkerShare, cells: Range<usize>) -> Quotient {
        let mut quotient = Quotient::default();
        for cell in cells {
            let ids = sites_of(share, cell);
            if !ids.iter().any(|&id| self.images.is_base(id)) {
                continue;
            }
            let corners = self.corners(ids);
            let smallest = (1..=P::DIM)
                .fold(0, |least, at| if is_lex_smaller(&corners[at], &corners[least]) { at } else { least });
            if self.images.is_base(ids[smallest]) {
                let six = Weighted::rounded_orientation(&corners[..=P::DIM]).det.abs();
                quotient.volume += if P::DIM == 2 { six / 2.0 } else { six / 6.0 };
                let vertices = canonical::<P>(ids.map(|id| self.vertex(id)));
                quotient.packed.extend(vertices[..=P::DIM].iter().map(|vertex| vertex.pack()));
            }
        }
        quotient
    }

    fn vertex(self, id: u64) -> Vertex {
        if id == u64::MAX {
            return Vertex::default();
        }
        let (row, steps) = self.images.of(id);
        Vertex { row, steps }
    }
}

/// Returns the sites of a cell. In the plane, the last entry is not used.
fn sites_of(share: &WorkerShare, cell: usize) -> [u64; 4] {
    let mut ids = [u64::MAX; 4];
    ids.iter_mut().zip(share.cell_ids(cell)).for_each(|(to, id)| *to = id);
    ids
}

/// Brings the vertices of a positive cell into canonical order.
fn canonical<P: Point>(mut vertices: [Vertex; 4]) -> [Vertex; 4] {
    let n = P::DIM + 1;
    let is_odd = sort(&mut vertices[..n]);
    let least = vertices[0].row;
    let moved = |at: Steps| {
        let mut moved = vertices;
        for vertex in &mut moved[..n] {
            vertex.steps = difference(vertex.steps, at);
        }
        moved
    };
    // A translation does not change the order of vertices of the same row.
    let all = vertices[..n].iter().take_while(|vertex| vertex.row == least).map(|vertex| moved(vertex.steps));
    let mut first = all.min().unwrap_or(vertices);
    if is_odd {
        first.swap(n - 2, n - 1);
    }
    first
}

/// Sorts vertices. Returns `true` if the permutation was odd.
fn sort(vertices: &mut [Vertex]) -> bool {
    let mut is_odd = false;
    for i in 1..vertices.len() {
        for j in (1..=i).rev() {
            if vertices[j - 1] <= vertices[j] {
                break;
            }
            vertices.swap(j - 1, j);
            is_odd = !is_odd;
        }
    }
    is_odd
}
