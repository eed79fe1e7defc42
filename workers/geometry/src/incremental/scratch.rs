//! The storage of one insertion: lists that are reused from one to the next.

use super::ridges::Ridges;
use super::sphere::Inverse;
use crate::complex::INFINITE;
use crate::point::{Point, Simplex};

/// What one insertion needs; kept from one to the next.
#[derive(Clone, Debug)]
pub(super) struct Scratch<P: Point> {
    /// The cells in conflict.
    pub(super) cavity: List<u32>,
    /// The facets of the border, by their codes from inside and from outside.
    pub(super) border: List<(u32, u32)>,
    /// The cells that the exact predicates found free of conflict.
    pub(super) cleared: Vec<u32>,
    pub(super) faces: List<Face<P::Cell>>,
    /// The vertices of the border from 1 on, each with a new cell that it will be in.
    pub(super) border_vertices: List<(u32, u32)>,
    /// The same vertices, seen from the new one.
    pub(super) around: Vec<Inverse<P>>,
    pub(super) ridges: Ridges,
}

/// A facet of the border, which becomes a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face<S> {
    /// The code of the cell outside, then the vertices so that a point inside and they make a positive cell.
    pub(super) vertices: S,
    /// The vertices' places in `border_vertices`; the third is 0 in the plane.
    pub(super) numbers: [u32; 3],
    /// The new cell.
    pub(super) cell: u32,
}

impl<P: Point> Default for Scratch<P> {
    fn default() -> Self {
        Scratch {
            cavity: List::new(0),
            border: List::new((0, 0)),
            cleared: Vec::new(),
            faces: List::new(Face { vertices: P::Cell::splat(0), numbers: [0; 3], cell: 0 }),
            border_vertices: List::new((INFINITE, 0)),
            around: Vec::new(),
            ridges: Ridges::default(),
        }
    }
}

/// A list whose items are written in any case, and stay or are written over. Storage is reused.
#[derive(Clone, Debug)]
pub(super) struct List<T> {
    pub(super) items: Vec<T>,
    pub(super) len: usize,
}

impl<T: Copy> List<T> {
    /// An empty list; `item` fills its storage.
    fn new(item: T) -> Self {
        List { items: vec![item; 256], len: 0 }
    }

    /// The storage, with room for `more` items behind the first `len`.
    #[inline]
    pub(super) fn room(&mut self, len: usize, more: usize) -> &mut [T] {
        if self.items.len() - len < more {
            self.grow(len + more);
        }
        &mut self.items
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
