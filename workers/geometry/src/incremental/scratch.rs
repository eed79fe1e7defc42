//! Storage of one insertion: lists that the next insertion reuses.

use super::ridges::Ridges;
use super::sphere::Inverse;
use crate::complex::INFINITE;
use crate::point::{Point, Simplex};

/// The data of one insertion, in storage that is reused.
#[derive(Clone, Debug)]
pub(super) struct Scratch<P: Point> {
    /// The cells of the cavity.
    pub(super) cavity: List<u32>,
    /// The facets of the boundary, as their codes seen from inside and from outside.
    pub(super) boundary: List<(u32, u32)>,
    /// The cells that the exact predicates found not to conflict.
    pub(super) cleared: Vec<u32>,
    pub(super) faces: List<Face<P::Cell>>,
    /// The vertices of the boundary, starting at index 1, each with a new cell that contains it.
    pub(super) boundary_vertices: List<(u32, u32)>,
    /// The images of these vertices under inversion around the new vertex.
    pub(super) around: Vec<Inverse<P>>,
    pub(super) ridges: Ridges,
}

/// A facet of the boundary, from which a cell is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face<S> {
    /// The code of the cell outside, then the vertices. A point inside and the vertices form a positive cell.
    pub(super) vertices: S,
    /// Positions of the vertices in `boundary_vertices`; the third is 0 in the plane.
    pub(super) indices: [u32; 3],
    /// Index of the new cell.
    pub(super) cell: u32,
}

impl<P: Point> Default for Scratch<P> {
    fn default() -> Self {
        Scratch {
            cavity: List::new(0),
            boundary: List::new((0, 0)),
            cleared: Vec::new(),
            faces: List::new(Face { vertices: P::Cell::splat(0), indices: [0; 3], cell: 0 }),
            boundary_vertices: List::new((INFINITE, 0)),
            around: Vec::new(),
            ridges: Ridges::default(),
        }
    }
}

impl<P: Point> Scratch<P> {
    /// Returns the bytes of the lists.
    pub(super) fn bytes(&self) -> usize {
        self.cavity.bytes()
            + self.boundary.bytes()
            + self.faces.bytes()
            + self.boundary_vertices.bytes()
            + size_of_val(&self.around[..])
    }
}

/// A list without branches on insertion: every item is written at the end, and the length grows only if the item is
/// kept.
#[derive(Clone, Debug)]
pub(super) struct List<T> {
    pub(super) items: Vec<T>,
    pub(super) len: usize,
}

impl<T: Copy> List<T> {
    /// Creates an empty list; `item` fills its storage.
    fn new(item: T) -> Self {
        List { items: vec![item; 256], len: 0 }
    }

    /// Returns the storage, with room for `more` items behind the first `len`.
    #[inline]
    pub(super) fn room(&mut self, len: usize, more: usize) -> &mut [T] {
        if self.items.len() - len < more {
            self.grow(len + more);
        }
        &mut self.items
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.items[..])
    }

    #[cold]
    fn grow(&mut self, least: usize) {
        let item = self.items[0];
        self.items.resize(least.next_power_of_two(), item);
    }

    #[inline]
    pub(super) fn items(&self) -> &[T] {
        &self.items[..self.len]
    }
}
