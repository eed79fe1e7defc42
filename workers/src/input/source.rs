//! The input of a run, as the ranks read it.

use std::ops::Range;

use septet_geometry::evaluation::Evaluation;

use crate::state::blocks::block_of;

/// The rows of an input. Every host has a source, which holds at least the blocks of its own ranks.
pub trait Source<P>: Sync {
    /// Returns block `block`, if the rows are divided into `blocks` parts in their order. The blocks of a run contain
    /// each row once.
    fn block(&self, block: u32, blocks: u32) -> Rows<P>;

    /// Returns the rule and the first items of an evaluation, if the run is one.
    fn evaluation(&self) -> Option<&dyn Evaluation> {
        None
    }
}

/// Consecutive rows of an input: points as they were given.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows<P> {
    /// Number of the first row, counted from 0.
    pub first: u64,
    /// Coordinates, which may be infinite or not a number.
    pub positions: Vec<P>,
    /// The size of each point for an independent set; otherwise empty.
    pub sizes: Vec<f64>,
}

impl<P> Default for Rows<P> {
    fn default() -> Self {
        Rows { first: 0, positions: Vec::new(), sizes: Vec::new() }
    }
}

impl<P: Copy> Rows<P> {
    /// Returns block `block` of `blocks` equal parts of the rows of a whole input, whose first row has the number `first`.
    /// `sizes` may be empty.
    pub fn of_whole(first: u64, positions: &[P], sizes: &[f64], block: u32, blocks: u32) -> Self {
        let Range { start, end } = block_of(positions.len() as u64, block, blocks);
        let range = start as usize..end as usize;
        let mut rows = Rows {
            first: first + range.start as u64,
            positions: Vec::with_capacity(with_room(range.len())),
            sizes: sizes.get(range.clone()).unwrap_or_default().to_vec(),
        };
        rows.positions.extend_from_slice(&positions[range]);
        rows
    }
}

/// Returns a capacity for the points of a block. A worker later owns about as many points as its block has. The extra
/// capacity is for the ghosts that it then receives.
pub(super) fn with_room(points: usize) -> usize {
    points + points / 8
}
