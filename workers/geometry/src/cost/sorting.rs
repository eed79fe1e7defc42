//! The primitives that sort, remove duplicates and merge.
//!
//! **Statement.** Some methods use an algorithm that is faster on a processor than the primitive that they charge. The
//! primitive would give the same results. The charges are the prices of [`Primitive::Sort`], [`Primitive::Distinct`]
//! and [`Primitive::Merge`].

use std::cmp::Ordering;

use super::price::{Primitive, ceil_log2};
use super::{Cost, Marks, Positions};
use crate::simd::Masks;

impl Cost {
    /// Sorts the items; the sort is stable.
    pub fn sort<T>(&mut self, items: &mut [T], compare: impl FnMut(&T, &T) -> Ordering) {
        self.pay(Primitive::Sort, items.len());
        items.sort_by(compare);
    }

    /// Sorts indices by `key`, and by `compare` if keys differ at most in their last bits. The sort is unstable, and
    /// `compare` must agree with `key`. Costs the same as [`Cost::sort`]. Internally, positions in `indices` replace
    /// the last bits of the keys.
    pub fn sort_keyed(
        &mut self,
        indices: &mut Vec<u32>,
        scratch: &mut Vec<u64>,
        key: impl Fn(u32) -> u64,
        compare: impl Fn(&u32, &u32) -> Ordering,
    ) {
        let len = indices.len();
        self.pay(Primitive::Sort, len);
        let position_bits = (1u64 << ceil_log2(len as u64)) - 1;
        scratch.clear();
        scratch.extend((0u64..).zip(indices.iter()).map(|(at, &index)| key(index) & !position_bits | at));
        let keys = Masks::default().sorted(scratch);
        indices.extend_from_within(..);
        let (sorted, given) = indices.split_at_mut(len);
        let (mut last, mut are_clear) = (u64::MAX, true);
        for (index, &key) in sorted.iter_mut().zip(keys) {
            *index = given[(key & position_bits) as usize];
            are_clear &= (key ^ last) > position_bits;
            last = key;
        }
        let mut rest = sorted;
        for run in keys.chunk_by(|a, b| (a ^ b) <= position_bits).filter(|_| !are_clear) {
            let (own, others) = rest.split_at_mut(run.len());
            own.sort_unstable_by(&compare);
            rest = others;
        }
        indices.truncate(len);
    }

    /// Sorts the items by their positions, which are below `positions`, with a stable counting sort. Costs the same as
    /// [`Cost::sort`].
    pub fn sort_by_position<T: Copy>(
        &mut self,
        items: &[T],
        position: impl Fn(&T) -> usize,
        positions: usize,
    ) -> Vec<T> {
        self.pay(Primitive::Sort, items.len());
        let mut starts = vec![0usize; positions + 1];
        for item in items {
            starts[position(item) + 1] += 1;
        }
        for at in 1..=positions {
            starts[at] += starts[at - 1];
        }
        let mut sorted = items.to_vec();
        for &item in items {
            let at = &mut starts[position(&item)];
            sorted[*at] = item;
            *at += 1;
        }
        sorted
    }

    /// Sorts the items and keeps one item of each run of equal items.
    pub fn distinct<T>(&mut self, items: &mut Vec<T>, compare: impl FnMut(&T, &T) -> Ordering) {
        self.pay(Primitive::Distinct, items.len());
        sort_and_deduplicate(items, compare);
    }

    /// Keeps the first occurrence of each index, in the given order. `seen` must have room for the indices. Costs the
    /// same as [`Cost::distinct`].
    pub fn distinct_indices(&mut self, indices: &mut Vec<u32>, seen: &mut Marks) {
        self.pay(Primitive::Distinct, indices.len());
        seen.clear();
        indices.retain(|&index| seen.insert(index));
    }

    /// Replaces each index by its position among the distinct indices. Returns the distinct indices in the order of
    /// their first occurrence. Costs the same as [`Cost::distinct`] plus a vector step that reads the positions.
    pub fn relabel(&mut self, indices: &mut [u32], scratch: &mut Positions) -> Vec<u32> {
        let mut distinct = indices.to_vec();
        self.distinct_indices(&mut distinct, &mut scratch.marks);
        scratch.set(&distinct);
        self.update(indices, |index| *index = scratch.of(*index));
        distinct
    }

    /// Merges two ascending lists of distinct items. The result is ascending, and each item comes with a flag: whether
    /// it is in both lists.
    pub fn unite<T: Copy + Ord>(&mut self, a: &[T], b: &[T]) -> Vec<(T, bool)> {
        self.pay(Primitive::Merge, a.len() + b.len());
        let mut out = Vec::with_capacity(a.len().max(b.len()));
        let (mut i, mut j) = (0, 0);
        while let (Some(&x), Some(&y)) = (a.get(i), b.get(j)) {
            out.push((x.min(y), x == y));
            i += usize::from(x <= y);
            j += usize::from(y <= x);
        }
        out.extend(a[i..].iter().chain(&b[j..]).map(|&x| (x, false)));
        out
    }
}

fn sort_and_deduplicate<T>(items: &mut Vec<T>, mut compare: impl FnMut(&T, &T) -> Ordering) {
    items.sort_by(&mut compare);
    items.dedup_by(|a, b| compare(a, b).is_eq());
}

/// Removes the items whose flag is not `stay` from an array, and returns them. Does nothing to an empty array. Branches
/// on the flags would be unpredictable. The function therefore writes each item to both lists, but only the list that
/// keeps the item grows.
pub(super) fn take_others<T: Copy>(flags: &[u8], stay: u8, items: &mut Vec<T>) -> Vec<T> {
    let Some(&first) = items.first() else { return Vec::new() };
    let all = flags.iter().filter(|&&flag| flag != stay).count();
    let mut others = vec![first; all + 1];
    let (mut kept, mut removed) = (0, 0);
    for (i, &flag) in flags.iter().enumerate() {
        let (item, stays) = (items[i], usize::from(flag == stay));
        items[kept] = item;
        others[removed] = item;
        kept += stays;
        removed += 1 - stays;
    }
    items.truncate(kept);
    others.truncate(removed);
    others
}
