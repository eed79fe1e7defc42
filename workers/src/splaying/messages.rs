//! The messages between stars: proposals, objections, and gathered points.

use std::ops::Range;

use septet_geometry::point::{Array, Point, lex_cmp};

use crate::state::table::Table;

/// A cell that the star of `to` may lack. Both `to` and `from` are vertices of the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Proposal<C> {
    /// The receiver.
    pub(super) to: u32,
    /// The vertices in ascending order.
    pub(super) cell: C,
    /// The sender, whose star has the cell.
    pub(super) from: u32,
}

impl<C: AsRef<[u32]>> Proposal<C> {
    /// Returns `true` if the receiver is an owned point and the vertices differ. A damaged message may have other cells;
    /// the certificate decides on their stars.
    pub(super) fn is_for_star_of<P: Point>(&self, table: &Table<P>) -> bool {
        table.is_owned(self.to) && self.cell.as_ref().is_sorted_by(|a, b| a < b)
    }
}

/// A cell that is not Delaunay. Both `to` and `from` are vertices of the cell.
#[derive(Clone, Debug)]
pub(super) struct Objection<C> {
    /// The receiver.
    pub(super) to: u32,
    /// The vertices in ascending order.
    pub(super) cell: C,
    /// The sender.
    pub(super) from: u32,
    /// The positions in [`Objections::witnesses`] of the points in conflict with the cell.
    pub(super) witnesses: Range<usize>,
}

/// Objections with their witnesses. A *witness* is a point in conflict with the cell.
#[derive(Clone, Debug)]
pub(super) struct Objections<C> {
    list: Vec<Objection<C>>,
    witnesses: Vec<u32>,
}

impl<C> Default for Objections<C> {
    fn default() -> Self {
        Objections { list: Vec::new(), witnesses: Vec::new() }
    }
}

impl<C: Copy + Ord> Objections<C> {
    /// Returns `true` if there are no objections.
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Sorts the objections by receiver, cell and sender.
    pub(super) fn sort(&mut self) {
        self.list.sort_unstable_by_key(|objection| (objection.to, objection.cell, objection.from));
    }

    /// Returns the objections.
    pub(super) fn list(&self) -> &[Objection<C>] {
        &self.list
    }

    /// Returns the witnesses of all objections.
    pub(super) fn witnesses(&self) -> &[u32] {
        &self.witnesses
    }

    /// Appends other objections.
    pub(super) fn append(&mut self, other: Self) {
        let offset = self.witnesses.len();
        self.list.extend(other.list.into_iter().map(|objection| {
            let Range { start, end } = objection.witnesses;
            Objection { witnesses: start + offset..end + offset, ..objection }
        }));
        self.witnesses.extend(other.witnesses);
    }

    /// Adds an objection to one cell for each receiver.
    pub(super) fn add(&mut self, to: impl Iterator<Item = u32>, cell: C, from: u32, witnesses: &[u32]) {
        let start = self.witnesses.len();
        self.witnesses.extend_from_slice(witnesses);
        let range = start..self.witnesses.len();
        self.list.extend(to.map(|to| Objection { to, cell, from, witnesses: range.clone() }));
    }
}

/// A cell of an owned star that asks for a point in its circumsphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Question<C> {
    /// The owned point.
    pub(super) star: u32,
    /// The vertices in ascending order.
    pub(super) cell: C,
}

/// A point for an owned star: a neighbour of its vertex in the triangulation of a gathered region, or an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct GatheredPoint {
    /// The owned point.
    pub(super) star: u32,
    /// The point.
    pub(super) point: u32,
}

/// Returns the positions of a cell's vertices in lexicographic order, so that they do not depend on local indices.
pub(super) fn corners<P: Point>(table: &Table<P>, cell: &P::Cell) -> P::Corners {
    let mut all = P::Corners::from_fn(|_| P::default());
    let corners = all.as_mut();
    for (corner, &v) in corners.iter_mut().zip(cell.as_ref()) {
        *corner = table.positions()[v as usize];
    }
    corners[..=P::DIM].sort_unstable_by(lex_cmp);
    all
}
