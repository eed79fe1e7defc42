//! The cells of a periodic triangulation: one of each class of translated cells, in canonical order.
//!
//! A vertex of a cell is a row and a vector of lengths, its *offset*: the vertex lies at the row's point plus the offset times
//! the box. The least row has the offset 0. If it occurs several times, the occurrence is taken for which the sorted
//! vertices are least. Vertices are sorted by row and offset; the order of the last two keeps the orientation positive.
//! Cells are sorted by their vertices. So the result depends on the triangulation only.

use septet_geometry::point::{Point, Position, lex_cmp};
use septet_geometry::site::Weighted;
use septet_workers::config::cores::sort_rows;

use super::images::{Images, Sites};
use super::lattice::Steps;
use crate::result::share::{Neighbour, WorkerShare};

/// The part of a result that only periodic runs have.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PeriodicCells {
    /// For each vertex of the cells in canonical order, its offset: `space` whole numbers of lengths. The vertex lies at the
    /// point plus the offset times the box.
    pub offsets: Vec<i32>,
    /// Whether the triangulation is a simplicial complex: no site is joined to its own image, and no two sites are joined
    /// twice.
    pub is_simplicial: bool,
    /// The smallest number of boxes along each axis whose triangulation is a simplicial complex: by their product, then in
    /// lexicographic order. At most 3 along each axis; 1 along axes that are not periodic.
    pub sheets: Vec<u32>,
    /// Number of images of sites that the machine triangulated besides the sites.
    pub images: u64,
}

/// A vertex of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Vertex {
    pub(super) row: u32,
    pub(super) offset: Steps,
}

/// The cells of the result.
#[derive(Debug, Default)]
pub(super) struct Quotient {
    /// The vertices of all cells, `space + 1` for each, in canonical order.
    pub(super) vertices: Vec<Vertex>,
    /// The sum of the volumes of the cells.
    pub(super) volume: f64,
}

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
        (0..share.cell_count()).all(|cell| {
            let ids = sites_of(share, cell);
            let is_base = ids.map(|id| self.images.is_base(id));
            let has_base = |slots: &dyn Fn(usize) -> bool| (0..=P::DIM).any(|at| slots(at) && is_base[at]);
            if !has_base(&|_| true) {
                return true;
            }
            let on_hull = |slot: usize| share.neighbour(cell, slot) == Some(Neighbour::Hull);
            let is_open = (0..=P::DIM).any(|slot| on_hull(slot) && has_base(&|at| at != slot));
            !is_open && !self.sites.leaves_cover(&self.corners(ids)[..=P::DIM], self.width)
        })
    }

    fn corners(self, ids: [u64; 4]) -> [Weighted<P>; 4] {
        let mut corners = [Weighted::default(); 4];
        for (corner, id) in corners.iter_mut().zip(&ids[..=P::DIM]) {
            *corner = self.images.sites[*id as usize];
        }
        corners
    }

    /// Returns the cells whose lexicographically smallest vertices are base sites, as rows and offsets.
    pub(super) fn quotient(self) -> Quotient {
        let mut quotient = Quotient::default();
        let mut packed: Vec<u64> = Vec::new();
        for share in self.shares {
            for cell in 0..share.cell_count() {
                let ids = sites_of(share, cell);
                let corners = self.corners(ids);
                let smallest = (1..=P::DIM).fold(0, |least, at| {
                    if lex_cmp(&corners[at], &corners[least]).is_lt() { at } else { least }
                });
                if !self.images.is_base(ids[smallest]) {
                    continue;
                }
                quotient.volume += Weighted::rounded_orientation(&corners[..=P::DIM]).det.abs();
                let vertices = canonical::<P>(ids.map(|id| self.vertex(id)));
                for vertex in &vertices[..=P::DIM] {
                    packed.extend([u64::from(vertex.row), pack(vertex.offset)]);
                }
            }
        }
        quotient.volume /= if P::DIM == 2 { 2.0 } else { 6.0 };
        sort_rows(&mut packed, 2 * (P::DIM + 1));
        quotient.vertices =
            packed.chunks_exact(2).map(|v| Vertex { row: v[0] as u32, offset: unpack(v[1]) }).collect();
        quotient
    }

    /// Returns a site as a vertex, with the offset from the point of its row.
    fn vertex(self, id: u64) -> Vertex {
        if id == u64::MAX {
            return Vertex::default();
        }
        let (row, steps) = self.images.of(id);
        let own = self.sites.steps(row);
        Vertex { row, offset: std::array::from_fn(|axis| steps[axis] + own[axis]) }
    }
}

/// Returns the sites of a cell. In the plane, the last entry is not used.
fn sites_of(share: &WorkerShare, cell: usize) -> [u64; 4] {
    let mut ids = [u64::MAX; 4];
    ids.iter_mut().zip(share.cell_ids(cell)).for_each(|(to, id)| *to = id);
    ids
}

/// Brings the vertices of a positive cell into canonical order.
fn canonical<P: Point>(vertices: [Vertex; 4]) -> [Vertex; 4] {
    let n = P::DIM + 1;
    let least = vertices[..n].iter().map(|vertex| vertex.row).min().unwrap_or(0);
    let moved = |at: Steps| {
        let mut moved = vertices;
        for vertex in &mut moved[..n] {
            vertex.offset = std::array::from_fn(|axis| vertex.offset[axis] - at[axis]);
        }
        let is_odd = sort(&mut moved[..n]);
        (moved, is_odd)
    };
    let all = vertices[..n].iter().filter(|vertex| vertex.row == least).map(|vertex| moved(vertex.offset));
    let Some((mut first, is_odd)) = all.min() else { return vertices };
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

/// Number of bits of an offset along one axis.
const BITS: u32 = 21;

/// Packs an offset into a number with the same order. Offsets are smaller than `2^20`.
fn pack(offset: Steps) -> u64 {
    offset.iter().fold(0, |word, &steps| word << BITS | (steps + (1 << (BITS - 1))) as u64)
}

fn unpack(word: u64) -> Steps {
    let mask = (1 << BITS) - 1;
    std::array::from_fn(|axis| ((word >> (BITS * (2 - axis as u32))) & mask) as i32 - (1 << (BITS - 1)))
}
