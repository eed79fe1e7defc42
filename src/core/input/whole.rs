//! An input that is in the memory of the caller.

use septet_geometry::point::Point;
use septet_workers::input::{Rows, Source};

use super::held::Held;

/// All rows of an input, as the source of a machine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole<'a, P> {
    /// The points.
    pub(crate) positions: &'a [P],
    /// The size of each point for an independent set; otherwise empty.
    pub(crate) sizes: &'a [f64],
}

impl<'a, P> Whole<'a, P> {
    /// Creates the input of a triangulation.
    pub(crate) fn points(positions: &'a [P]) -> Self {
        Whole { positions, sizes: &[] }
    }
}

impl<P: Point> Whole<'_, P> {
    /// Returns the rows as those of the only process.
    pub(crate) fn held(&self) -> Held<'_, P> {
        Held { source: self, points: self.positions, first: 0, rows: self.positions.len() as u64 }
    }
}

impl<P: Point> Source<P> for Whole<'_, P> {
    fn block(&self, block: u32, blocks: u32) -> Rows<P> {
        Rows::of_whole(0, self.positions, self.sizes, block, blocks)
    }
}
