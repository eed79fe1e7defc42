//! Blocks of rows: consecutive rows of nearly equal number.

use std::ops::Range;

/// Returns the rows of block `block`, if `rows` rows are divided into `blocks` parts in their order.
pub fn block_of(rows: u64, block: u32, blocks: u32) -> Range<u64> {
    let at = |block: u32| (u128::from(rows) * u128::from(block) / u128::from(blocks)) as u64;
    at(block)..at(block + 1)
}
