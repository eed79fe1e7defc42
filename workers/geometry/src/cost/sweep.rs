//! Vector steps whose items are found by a traversal.
//!
//! **Statement.** A [`Sweep`] counts the items of one vector step while the caller visits them. It costs nothing until
//! a method of [`Cost`](super::Cost) charges it, for example
//! [`Cost::charge_sweep`](super::Cost::charge_sweep).

use crate::coordinate_arrays::CoordinateArrays;
use crate::kd_blocks::KdBlocks;
use crate::point::Point;
use crate::selection::NeighbourList;

/// The number of items of a vector step that have been visited so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sweep {
    items: u64,
}

impl Sweep {
    /// Counts one item.
    #[inline]
    pub fn visit(&mut self) {
        self.items += 1;
    }

    /// Counts items that are processed together, in the lanes of vector registers.
    #[inline]
    pub(crate) fn visit_lanes(&mut self, lanes: usize) {
        self.items += lanes as u64;
    }

    /// Counts all items of a slice, and returns the slice.
    #[inline]
    pub fn visit_all<'a, T>(&mut self, items: &'a [T]) -> &'a [T] {
        self.items += items.len() as u64;
        items
    }

    /// Counts `parts` items for each item of a slice, for example the ridges of facets.
    #[inline]
    pub(crate) fn visit_parts<T>(&mut self, items: &[T], parts: usize) {
        self.items += (items.len() * parts) as u64;
    }

    /// Counts and processes all items of a slice.
    #[inline]
    pub fn each<T>(&mut self, items: &[T], f: impl FnMut(&T)) {
        self.items += items.len() as u64;
        items.iter().for_each(f);
    }

    /// Counts the points of a range, and processes their distances from a centre: see
    /// [`CoordinateArrays::each_within`].
    #[inline]
    pub fn each_distance<P: Point>(
        &mut self,
        points: &CoordinateArrays<P>,
        range: std::ops::Range<usize>,
        centre: P,
        limit2: f64,
        near: impl FnMut(usize, f64) -> f64,
    ) {
        self.items += range.len() as u64;
        points.each_within(range, centre, limit2, near);
    }

    /// Counts all points, and finds those within the limit of a centre (`KdBlocks::find_within`). The machine tests all
    /// points in one step, so all are charged. A processor tests only the points of blocks within the limit.
    #[inline]
    pub fn each_in_blocks<P: Point>(
        &mut self,
        blocks: &KdBlocks<P>,
        centre: P,
        limit2: f64,
        start: u32,
        found: &mut NeighbourList,
    ) {
        self.items += blocks.len() as u64;
        blocks.find_within(centre, limit2, start, found);
    }

    /// Returns the sweep over the parts of each item, for example the places of each ball. All items have `parts` parts.
    #[must_use]
    pub fn of_parts(&self, parts: u64) -> Sweep {
        Sweep { items: self.items * parts }
    }

    /// Returns the number of items so far.
    pub fn items(&self) -> u64 {
        self.items
    }

    /// Adds the items of another share of the same step.
    pub fn join(&mut self, other: &Sweep) {
        self.items += other.items;
    }
}
