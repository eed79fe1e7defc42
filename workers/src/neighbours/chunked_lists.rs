//! Lists that grow part by part and share their storage. Received blocks are stored unchanged.

use std::ops::Range;

use septet_geometry::complex::NONE;

/// A list, represented by its first and its last run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ListChain {
    first: u32,
    last: u32,
}

impl ListChain {
    /// An empty list.
    pub(crate) const EMPTY: ListChain = ListChain { first: NONE, last: NONE };
}

/// The parts of all lists, as runs of indices within blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChunkedLists {
    blocks: Vec<Vec<u32>>,
    runs: Vec<IndexRun>,
}

/// Consecutive indices of a block that belong to one list.
#[derive(Clone, Copy, Debug)]
struct IndexRun {
    begin: usize,
    block: u32,
    len: u32,
    /// The next run of the list, or [`NONE`].
    next: u32,
}

impl ChunkedLists {
    /// Reserves capacity for `runs` further runs.
    pub(crate) fn reserve(&mut self, runs: usize) {
        self.runs.reserve(runs);
    }

    /// Returns the index of the block that is added next.
    pub(crate) fn next_block(&self) -> u32 {
        self.blocks.len() as u32
    }

    /// Adds a block.
    pub(crate) fn add_block(&mut self, block: Vec<u32>) {
        self.blocks.push(block);
    }

    /// Appends a run of a block to a list. The block may be the one that is added next.
    pub(crate) fn add(&mut self, chain: &mut ListChain, block: u32, run: Range<usize>) {
        if run.is_empty() {
            return;
        }
        let at = self.runs.len() as u32;
        self.runs.push(IndexRun { begin: run.start, block, len: run.len() as u32, next: NONE });
        match self.runs.get_mut(chain.last as usize) {
            Some(last) => last.next = at,
            None => chain.first = at,
        }
        chain.last = at;
    }

    /// Returns the parts of a list, in the order in which they were appended.
    pub(crate) fn parts(&self, chain: ListChain) -> impl Iterator<Item = &[u32]> {
        let mut at = chain.first;
        std::iter::from_fn(move || {
            let &IndexRun { begin, block, len, next } = self.runs.get(at as usize)?;
            at = next;
            Some(&self.blocks[block as usize][begin..begin + len as usize])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_keep_their_parts_in_order() {
        let mut chains = ChunkedLists::default();
        let [mut a, mut b, c] = [ListChain::EMPTY; 3];
        assert_eq!(chains.next_block(), 0);
        chains.add(&mut a, 0, 0..2);
        chains.add(&mut b, 0, 2..3);
        chains.add_block(vec![1, 2, 7]);
        assert_eq!(chains.next_block(), 1);
        chains.add_block(vec![0, 3, 8, 9]);
        chains.add(&mut a, 1, 2..2);
        chains.add(&mut a, 1, 1..2);
        chains.add(&mut b, 1, 2..4);
        let all = |chain| chains.parts(chain).collect::<Vec<_>>().concat();
        assert_eq!((all(a), all(b), all(c)), (vec![1, 2, 3], vec![7, 8, 9], vec![]));
    }
}
