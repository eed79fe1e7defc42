//! Parallel loops in blocks of a fixed size, so that no result depends on the number of threads.

use std::ops::Range;

use septet_core::cores;

/// Items of a block. A list that is not longer is handled on the caller's thread.
pub(crate) const BLOCK: usize = 4096;

/// Returns the values of `f` for the blocks of the numbers below `len`, in the order of the blocks.
pub(crate) fn blocks<U: Send>(len: usize, f: impl Fn(Range<usize>) -> U + Sync) -> Vec<U> {
    if len == 0 {
        Vec::new()
    } else if len <= BLOCK {
        vec![f(0..len)]
    } else {
        cores::map_blocks(len, BLOCK, f)
    }
}

/// Ends the call if its flag is set. Loops that take long for a block call it for each item.
pub(crate) fn check() {
    // Before each item, a loop looks at the flag.
    cores::each(1, &|_| {});
}

/// Returns the values of `f` for the numbers below `len`, in their order.
pub(crate) fn map<U: Send>(len: usize, f: impl Fn(usize) -> U + Sync) -> Vec<U> {
    let one = |i: usize| {
        check();
        f(i)
    };
    joined(len, blocks(len, |at| at.map(one).collect::<Vec<U>>()))
}

/// Joins the items of blocks, `len` items or more.
pub(crate) fn joined<U>(len: usize, blocks: Vec<Vec<U>>) -> Vec<U> {
    let mut all = Vec::with_capacity(len);
    for block in blocks {
        all.extend(block);
    }
    all
}
