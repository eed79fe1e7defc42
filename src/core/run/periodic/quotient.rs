//! The cells of a periodic triangulation: one of each class of translated cells, in canonical order.
//!
//! A vertex of a cell is a row and a vector of lengths, its *offset*: the vertex lies at the row's point plus the offset times
//! the box. The least row has the offset 0. If it occurs several times, the first occurrence by position has. Vertices are
//! sorted by row and offset; the order of the last two keeps the orientation positive.
//! Cells are sorted by their vertices. So the result depends on the triangulation only.

use std::ops::Range;

use septet_geometry::point::{Point, Position, is_lex_smaller};
use septet_geometry::site::Weighted;
use septet_workers::config::cores::{map, map_blocks};

use super::images::{Images, Sites};
use super::team::Team;
use crate::error::Error;
use crate::result::periodic::{Vertex, difference};
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

/// The points of a share, in its order, which is that of a curve.
struct Local<'a, P: Position> {
    share: &'a WorkerShare,
    sites: &'a [Weighted<P>],
    is_base: Vec<bool>,
}

impl<P: Position> Local<'_, P> {
    /// Returns the sites of a cell, and which of them are base sites.
    fn corners(&self, cell: usize) -> ([Weighted<P>; 4], [bool; 4]) {
        let (mut corners, mut is_base) = ([Weighted::default(); 4], [false; 4]);
        for (slot, &vertex) in self.share.cell(cell).iter().enumerate() {
            corners[slot] = self.sites[vertex as usize];
            is_base[slot] = self.is_base[vertex as usize];
        }
        (corners, is_base)
    }
}

impl<P: Position> Covered<'_, P> {
    /// Returns the cells of this process whose lexicographically smallest vertices are base sites. Returns `None` if the stars
    /// of base sites may not be those of all images. A cover with all images needs no check.
    ///
    /// # Errors
    /// Fails if a process is gone.
    pub(super) fn quotient(self, team: &mut Team<'_, '_>) -> Result<Option<Quotient>, Error> {
        let ids: Vec<u64> = self.shares.iter().flat_map(|share| &share.ids).copied().collect();
        let sites = self.images.fetch(&ids, team)?;
        let (mut all, mut rest) = (Quotient::default(), &sites[..]);
        for share in self.shares {
            let (sites, others) = rest.split_at(share.ids.len());
            rest = others;
            let is_base = map(&share.ids, |&id| self.images.is_base(id));
            let local = &Local { share, sites, is_base };
            for block in map_blocks(share.cell_count(), BLOCK, |cells| self.quotient_of(local, cells)) {
                let Some(block) = block else { return Ok(None) };
                all = all.join(block);
            }
        }
        Ok(Some(all))
    }

    fn quotient_of(self, local: &Local<'_, P>, cells: Range<usize>) -> Option<Quotient> {
        let mut quotient = Quotient::default();
        let is_checked = !self.sites.has_all(self.width);
        for cell in cells {
            let (corners, is_base) = local.corners(cell);
            if !is_base.contains(&true) {
                continue;
            }
            if is_checked && self.is_open(local, cell, (&corners, is_base)) {
                return None;
            }
            if is_first_base::<P>(&corners, is_base) {
                let six = Weighted::rounded_orientation(&corners[..=P::DIM]).det.abs();
                quotient.volume += if P::DIM == 2 { six / 2.0 } else { six / 6.0 };
                let vertices = canonical::<P>(self.vertices(local.share, cell));
                quotient.packed.extend(vertices[..=P::DIM].iter().map(|vertex| vertex.pack()));
            }
        }
        Some(quotient)
    }

    /// Returns `true` if a cell shows that the star of a base site may lack an image: the cell has such a vertex on the hull, or
    /// also has an image as a vertex, and its conflict region may leave the cover.
    ///
    /// The region of a cell of base sites alone needs no test. Let it contain a position `y` outside of the cover, and walk from
    /// the cell straight to `y`. The power of `y` decreases from cell to cell, so `y` is in all their regions. The walk leaves
    /// the hull, from a cell with a base site on the hull, or after the last cell with a base site. The facet to the cell after
    /// that one has only images.
    fn is_open(
        self,
        local: &Local<'_, P>,
        cell: usize,
        (corners, is_base): (&[Weighted<P>; 4], [bool; 4]),
    ) -> bool {
        let on_hull = |slot: usize| local.share.neighbour(cell, slot) == Some(Neighbour::Hull);
        let has_other = |slot: usize| (0..=P::DIM).any(|at| at != slot && is_base[at]);
        let is_mixed = is_base[..=P::DIM].contains(&false);
        (0..=P::DIM).any(|slot| on_hull(slot) && has_other(slot))
            || is_mixed && self.sites.leaves_cover(&corners[..=P::DIM], self.width)
    }

    /// Returns the vertices of a cell. In the plane, the last one is not used.
    fn vertices(self, share: &WorkerShare, cell: usize) -> [Vertex; 4] {
        let mut vertices = [Vertex::default(); 4];
        for (vertex, id) in vertices.iter_mut().zip(share.cell_ids(cell)) {
            *vertex = self.images.of(id);
        }
        vertices
    }
}

/// Returns `true` if the lexicographically smallest vertex of a cell is a base site.
fn is_first_base<P: Position>(corners: &[Weighted<P>; 4], is_base: [bool; 4]) -> bool {
    if is_base[..=P::DIM] == [true; 4][..=P::DIM] {
        return true;
    }
    let smaller = |least, at| if is_lex_smaller(&corners[at], &corners[least]) { at } else { least };
    is_base[(1..=P::DIM).fold(0, smaller)]
}

/// Brings the vertices of a positive cell into canonical order.
fn canonical<P: Point>(mut vertices: [Vertex; 4]) -> [Vertex; 4] {
    let n = P::DIM + 1;
    let is_odd = sort(&mut vertices[..n]);
    // A translation does not change the order of vertices of the same row.
    let first = vertices[0].steps;
    for vertex in &mut vertices[..n] {
        vertex.steps = difference(vertex.steps, first);
    }
    if is_odd {
        vertices.swap(n - 2, n - 1);
    }
    vertices
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
