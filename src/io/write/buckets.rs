//! A counting sort into many small buckets.

use septet_core::cores::{each_item, map_blocks};

/// The number of buckets per unit of parallel work.
const CHUNK: usize = 2048;

/// The number of units that are processed before their results are used. It limits the memory for results.
const BATCH: usize = 64;

/// An index of 32 or 64 bits.
pub(super) trait Item: Copy + Ord + Default + Send + Sync {
    /// Converts an index, which must be in range.
    fn narrow(value: u64) -> Self;
    /// Returns the index.
    fn wide(self) -> u64;
}

impl Item for u32 {
    fn narrow(value: u64) -> Self {
        value as u32
    }
    fn wide(self) -> u64 {
        u64::from(self)
    }
}

impl Item for u64 {
    fn narrow(value: u64) -> Self {
        value
    }
    fn wide(self) -> u64 {
        self
    }
}

/// Items grouped by a small key.
pub(super) struct Buckets<T> {
    /// Bucket `k` is `items[starts[k]..starts[k + 1]]`.
    starts: Vec<usize>,
    items: Vec<T>,
}

impl<T: Item> Buckets<T> {
    /// Sorts the pairs of bucket and item that `source` passes to its visitor. `source` runs twice. Items of a bucket
    /// keep their order.
    pub(super) fn fill(count: usize, source: impl Fn(&mut dyn FnMut(usize, u64))) -> Self {
        let mut starts = vec![0usize; count + 1];
        source(&mut |bucket, _| starts[bucket + 1] += 1);
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total;
        }
        let mut items = vec![T::default(); total];
        let mut next = starts.clone();
        source(&mut |bucket, item| {
            items[next[bucket]] = T::narrow(item);
            next[bucket] += 1;
        });
        Self { starts, items }
    }

    /// Returns the buckets in order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[T]> {
        self.starts.windows(2).map(|w| &self.items[w[0]..w[1]])
    }

    /// Sorts the items of every bucket.
    pub(super) fn sort_each(&mut self) {
        let mut rest = self.items.as_mut_slice();
        let mut slices = Vec::new();
        for bounds in self.starts.chunks(CHUNK).zip(self.starts[1..].chunks(CHUNK)) {
            let (begin, end) = (bounds.0[0], bounds.1[bounds.1.len() - 1]);
            let (slice, tail) = rest.split_at_mut(end - begin);
            slices.push((bounds, slice));
            rest = tail;
        }
        each_item(slices, |((starts, ends), mut slice)| {
            for (start, end) in starts.iter().zip(ends) {
                let (bucket, tail) = std::mem::take(&mut slice).split_at_mut(end - start);
                bucket.sort_unstable();
                slice = tail;
            }
        });
    }

    /// Calls `work` for all buckets in parallel, and `accept` with the results in the order of the buckets. Returns the
    /// error of the first bucket that has one.
    pub(super) fn for_each_batch<R: Send, E: Send>(
        &self,
        work: impl Fn(&[T], &mut Vec<R>) -> Result<(), E> + Sync,
        mut accept: impl FnMut(Vec<R>),
    ) -> Result<(), E> {
        let count = self.starts.len() - 1;
        for start in (0..count).step_by(CHUNK * BATCH) {
            let end = count.min(start + CHUNK * BATCH);
            let results = map_blocks(end - start, CHUNK, |block| {
                let mut results = Vec::new();
                for bucket in start + block.start..start + block.end {
                    let range = self.starts[bucket]..self.starts[bucket + 1];
                    work(&self.items[range], &mut results)?;
                }
                Ok(results)
            });
            for result in results {
                accept(result?);
            }
        }
        Ok(())
    }
}
