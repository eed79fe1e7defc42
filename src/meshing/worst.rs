//! The order in which refinement takes bad cells.

use std::cmp::Ordering;

/// A cell that is not good enough, with its N corners. Cells compare by badness, and then by their corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bad<const N: usize> {
    /// A measure of the shape that grows as the cell gets worse, or a negative number for a cell that is only too large.
    pub(crate) badness: f64,
    pub(crate) corners: [u32; N],
    pub(crate) cell: u32,
}

impl<const N: usize> Eq for Bad<N> {}

impl<const N: usize> PartialOrd for Bad<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<const N: usize> Ord for Bad<N> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.badness.total_cmp(&other.badness).then_with(|| other.corners.cmp(&self.corners))
    }
}
