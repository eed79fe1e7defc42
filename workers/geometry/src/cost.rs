//! Work and depth on the EREW PRAM with unit-time scans, charged by the primitives that do the work.
//!
//! **Model.** Blelloch's scan-vector model (Vector Models for Data-Parallel Computing, 1990): a
//! problem of `m` items has `m` virtual processors, times a stated constant. A vector step over `m`
//! items costs work `m` and depth 1; where the items have costs of their own, the sum of their work and
//! the largest of their depths. A scan costs one step; a second depth charges `ceil(log2 m)` for it.
//!
//! [`Cost`] has private fields and no constructor but zero: only the primitives below raise it, and
//! each one runs the loop it charges for. A handler can neither state a number nor loop for free
//! inside a primitive without the loop being a primitive itself.
//!
//! The clock belongs to a subproblem. A subproblem spread over a group of workers is charged by every
//! member for its own share; shares are merged by [`Cost::beside`] (sum of work, largest depth), and
//! the scans are charged over the number of items of the whole subproblem when the ledger folds them
//! ([`Cost::depth_log_scan`]), so that no figure depends on the number of workers.

mod marks;

use std::cmp::Ordering;

pub use marks::{Marks, Places};

use crate::coordinate_arrays::{CoordinateArrays, Rows};
use crate::kd_blocks::KdBlocks;
use crate::point::Point;
use crate::selection::NeighbourList;
use crate::simd::Masks;

/// Work and depth so far. See the module's text for the rules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    work: u64,
    depth: u64,
    scans: u64,
    inner_log: u64,
}

impl Cost {
    /// Nothing done yet.
    pub const ZERO: Cost = Cost { work: 0, depth: 0, scans: 0, inner_log: 0 };

    /// Number of elementary operations.
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Longest chain of vector steps, a scan counting 1.
    pub fn depth(&self) -> u64 {
        self.depth
    }

    /// Number of scans over the subproblem's own items on that chain.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Longest chain with every scan over `items` items counting `ceil(log2 items)`, at least 1.
    pub fn depth_log_scan(&self, items: u64) -> u64 {
        self.depth + self.inner_log + self.scans * (ceil_log2(items).max(1) - 1)
    }

    /// The cost as four numbers, for the wire.
    pub fn to_parts(self) -> [u64; 4] {
        [self.work, self.depth, self.scans, self.inner_log]
    }

    /// A cost that another worker measured. Only for decoding what [`Cost::to_parts`] encoded.
    pub fn from_parts(p: [u64; 4]) -> Self {
        Cost { work: p[0], depth: p[1], scans: p[2], inner_log: p[3] }
    }

    /// This, then `next`.
    pub fn then(&mut self, next: Cost) {
        self.work += next.work;
        self.depth += next.depth;
        self.scans += next.scans;
        self.inner_log += next.inner_log;
    }

    /// This and `other` at the same time: sum of work, largest depth.
    pub fn beside(&mut self, other: Cost) {
        self.work += other.work;
        self.depth = self.depth.max(other.depth);
        self.scans = self.scans.max(other.scans);
        self.inner_log = self.inner_log.max(other.inner_log);
    }

    /// Turns the scans over this problem's `items` items into a fixed charge of the log column, so
    /// that the problem can become an item of a larger vector step.
    #[inline]
    pub fn close(&mut self, items: u64) {
        self.inner_log += self.scans * (ceil_log2(items).max(1) - 1);
        self.scans = 0;
    }

    fn step(&mut self, work: usize) {
        self.work += work as u64;
        self.depth += 1;
    }

    fn scan_step(&mut self, work: usize) {
        self.step(work);
        self.scans += 1;
    }

    /// One vector step: `f` of every item.
    pub fn map<T, U>(&mut self, items: &[T], mut f: impl FnMut(&T) -> U) -> Vec<U> {
        self.step(items.len());
        items.iter().map(&mut f).collect()
    }

    /// One vector step over items that change in place.
    pub fn update<T>(&mut self, items: &mut [T], mut f: impl FnMut(&mut T)) {
        self.step(items.len());
        items.iter_mut().for_each(&mut f);
    }

    /// One vector step whose items have costs of their own: work is their sum (at least one each),
    /// depth the largest.
    pub fn map_nested<T, U>(&mut self, items: &[T], mut f: impl FnMut(&T, &mut Cost) -> U) -> Vec<U> {
        let mut all = Cost::ZERO;
        let out = items
            .iter()
            .map(|item| {
                let mut own = Cost::ZERO;
                let value = f(item, &mut own);
                own.work = own.work.max(1);
                own.depth = own.depth.max(1);
                all.beside(own);
                value
            })
            .collect();
        self.then(all);
        out
    }

    /// A reduction: one scan over the items.
    pub fn reduce<T, A>(&mut self, items: &[T], init: A, f: impl FnMut(A, &T) -> A) -> A {
        self.scan_step(items.len());
        items.iter().fold(init, f)
    }

    /// Exclusive plus-scan of counts: offsets and total.
    pub fn scan(&mut self, counts: &[usize]) -> (Vec<usize>, usize) {
        self.scan_step(counts.len());
        let mut total = 0;
        let offsets = counts
            .iter()
            .map(|&c| {
                let at = total;
                total += c;
                at
            })
            .collect();
        (offsets, total)
    }

    /// The items that `keep` accepts, in order: flag, scan, permute (three steps, one of them a scan).
    pub fn pack<T: Copy>(&mut self, items: &[T], mut keep: impl FnMut(&T) -> bool) -> Vec<T> {
        self.step(items.len());
        self.scan_step(items.len());
        self.step(items.len());
        items.iter().copied().filter(|t| keep(t)).collect()
    }

    /// Both sides of a split, in order: flag, two scans, one permute.
    pub fn split<T: Copy>(&mut self, items: &[T], mut left: impl FnMut(&T) -> bool) -> (Vec<T>, Vec<T>) {
        self.step(items.len());
        self.scan_step(items.len());
        self.scan_step(items.len());
        self.step(items.len());
        items.iter().copied().partition(|t| left(t))
    }

    /// One value to every item: a copy-scan.
    pub fn broadcast<T>(&mut self, items: &mut [T], mut set: impl FnMut(&mut T)) {
        self.scan_step(items.len());
        items.iter_mut().for_each(&mut set);
    }

    /// One value to every item (a copy-scan), then a vector step: `f` of the value and the item.
    pub fn map_with<V: Copy, T, U>(
        &mut self,
        value: V,
        items: &[T],
        mut f: impl FnMut(V, &T) -> U,
    ) -> Vec<U> {
        self.scan_step(items.len());
        self.step(items.len());
        items.iter().map(|item| f(value, item)).collect()
    }

    /// A split of records that stand in columns, the last of which may be empty, by flags that the vector step before
    /// left: those with the flag `stay` stay, in order, and the others are returned. Flag, two scans, one permute, as
    /// in [`Cost::split`].
    pub fn split_arrays<A: Copy, B: Copy, C: Copy>(
        &mut self,
        flags: &[u8],
        stay: u8,
        (a, b, c): (&mut Vec<A>, &mut Vec<B>, &mut Vec<C>),
    ) -> (Vec<A>, Vec<B>, Vec<C>) {
        self.step(flags.len());
        self.scan_step(flags.len());
        self.scan_step(flags.len());
        self.step(flags.len());
        (take_others(flags, stay, a), take_others(flags, stay, b), take_others(flags, stay, c))
    }

    /// `out[i] = items[index[i]]`: exclusive reads, so the indices must be distinct.
    ///
    /// # Errors
    /// The first index that occurs twice.
    pub fn gather<T: Copy>(&mut self, items: &[T], index: &[u32]) -> Result<Vec<T>, usize> {
        self.step(index.len());
        let mut seen = vec![false; items.len()];
        index
            .iter()
            .map(|&i| {
                let i = i as usize;
                if std::mem::replace(&mut seen[i], true) { Err(i) } else { Ok(items[i]) }
            })
            .collect()
    }

    /// All pairs of a row's point with every column's: one vector step over `rows * cols` pairs, the column values
    /// replicated by a copy-scan, and one segmented reduction that leaves one result a row. `keep` sees those columns
    /// that matter to a row.
    pub fn close_pairs<P: Point>(&mut self, rows: &[P], cols: &CoordinateArrays<P>, keep: &mut impl Rows) {
        let pairs = rows.len() * cols.len();
        self.scan_step(pairs);
        self.step(pairs);
        self.scan_step(pairs);
        cols.each_row(rows, keep);
    }

    /// The same of all pairs of some points, where a processor looks at those whose blocks are within the limit.
    pub fn pairs_in_blocks<P: Point>(&mut self, points: &KdBlocks<P>, keep: &mut impl Rows) {
        let pairs = points.len() * points.len();
        self.scan_step(pairs);
        self.step(pairs);
        self.scan_step(pairs);
        points.each_row(keep);
    }

    /// A step over items that a caller walks itself, one call of [`Sweep::visit`] an item; charged
    /// when the sweep is dropped into the cost by [`Cost::swept`].
    pub fn sweep(&self) -> Sweep {
        Sweep { items: 0 }
    }

    /// Charges a finished sweep: one vector step and one scan that collects its outcome. Nothing, if it
    /// had no items.
    #[inline]
    pub fn swept(&mut self, sweep: Sweep) {
        if sweep.items > 0 {
            self.step(sweep.items as usize);
            self.scan_step(sweep.items as usize);
        }
    }

    /// Like [`Cost::swept`], for a sweep that is an item of a larger problem: its scan is over its own
    /// items.
    #[inline]
    pub fn swept_inside(&mut self, sweep: Sweep) {
        let mut inner = Cost::ZERO;
        let items = sweep.items;
        inner.swept(sweep);
        inner.close(items);
        self.then(inner);
    }

    /// Charges the delivery of a finished sweep's items to those they are meant for, who drop what they know: the sort by
    /// receiver, a copy-scan that brings each what its receiver knows, the comparison, and the pack. Nothing, if it had no items.
    pub fn delivered(&mut self, sweep: Sweep) {
        let items = sweep.items as usize;
        if items > 0 {
            for _ in 0..ceil_log2(sweep.items).max(1) {
                self.step(items);
            }
            self.scan_step(items);
            self.step(items);
            self.scan_step(items);
            self.step(items);
        }
    }

    /// Sorts the items, equal ones in their present order: a pipelined merge sort (Cole 1988, EREW),
    /// charged as `ceil(log2 m)` vector steps over the items.
    pub fn sort<T>(&mut self, items: &mut [T], compare: impl FnMut(&T, &T) -> Ordering) {
        for _ in 0..ceil_log2(items.len() as u64).max(1) {
            self.step(items.len());
        }
        items.sort_by(compare);
    }

    /// Sorts numbers by `key`, and by `compare`, which must agree with it, where keys are equal or nearly so; equal
    /// ones in no order. Charged as [`Cost::sort`]. Done on keys of which the last digits are places.
    pub fn sort_keyed(
        &mut self,
        numbers: &mut Vec<u32>,
        scratch: &mut Vec<u64>,
        key: impl Fn(u32) -> u64,
        compare: impl Fn(&u32, &u32) -> Ordering,
    ) {
        let len = numbers.len();
        for _ in 0..ceil_log2(len as u64).max(1) {
            self.step(len);
        }
        let places = (1u64 << ceil_log2(len as u64)) - 1;
        scratch.clear();
        scratch.extend((0u64..).zip(numbers.iter()).map(|(place, &number)| key(number) & !places | place));
        let keys = Masks::default().sorted(scratch);
        numbers.extend_from_within(..);
        let (sorted, given) = numbers.split_at_mut(len);
        let (mut last, mut are_clear) = (u64::MAX, true);
        for (number, &key) in sorted.iter_mut().zip(keys) {
            *number = given[(key & places) as usize];
            are_clear &= (key ^ last) > places;
            last = key;
        }
        let mut rest = sorted;
        for run in keys.chunk_by(|a, b| (a ^ b) <= places).filter(|_| !are_clear) {
            let (own, others) = rest.split_at_mut(run.len());
            own.sort_unstable_by(&compare);
            rest = others;
        }
        numbers.truncate(len);
    }

    /// Sorts the items and leaves one of each run of equal ones: the sort, then flag, scan and permute.
    pub fn distinct<T>(&mut self, items: &mut Vec<T>, mut compare: impl FnMut(&T, &T) -> Ordering) {
        self.sort(items, &mut compare);
        self.step(items.len());
        self.scan_step(items.len());
        self.step(items.len());
        items.dedup_by(|a, b| compare(a, b).is_eq());
    }

    /// [`Cost::distinct_inside`] of numbers below that of `seen`'s places: charged as that, and done by a mark on
    /// each. They stay in their order.
    pub fn distinct_numbers(&mut self, numbers: &mut Vec<u32>, seen: &mut Marks) {
        let mut inner = Cost::ZERO;
        let m = numbers.len();
        for _ in 0..=ceil_log2(m as u64).max(1) {
            inner.step(m);
        }
        inner.scan_step(m);
        inner.step(m);
        inner.close(m as u64);
        self.then(inner);
        seen.begin();
        numbers.retain(|&number| seen.is_new(number));
    }

    /// Puts in the place of each number its place among the distinct ones, in the order of their first occurrence, and
    /// returns those: charged as [`Cost::distinct_inside`], and a step that reads the places back.
    pub fn places_of(&mut self, numbers: &mut [u32], seen: &mut Places) -> Vec<u32> {
        let mut distinct = numbers.to_vec();
        self.distinct_numbers(&mut distinct, &mut seen.marks);
        seen.number(&distinct);
        self.update(numbers, |number| *number = seen.of(*number));
        distinct
    }

    /// Charges the sort of so many items that stand in order already, or are put there by their places.
    pub fn sorted_by_place<T: Copy>(
        &mut self,
        items: &[T],
        place: impl Fn(&T) -> usize,
        places: usize,
    ) -> Vec<T> {
        for _ in 0..ceil_log2(items.len() as u64).max(1) {
            self.step(items.len());
        }
        let mut starts = vec![0usize; places + 1];
        for item in items {
            starts[place(item) + 1] += 1;
        }
        for at in 1..=places {
            starts[at] += starts[at - 1];
        }
        let mut sorted = items.to_vec();
        for &item in items {
            let at = &mut starts[place(&item)];
            sorted[*at] = item;
            *at += 1;
        }
        sorted
    }

    /// [`Cost::distinct`] of a list that is an item of a larger problem: its scan is over itself.
    pub fn distinct_inside<T>(&mut self, items: &mut Vec<T>, compare: impl FnMut(&T, &T) -> Ordering) {
        let (mut inner, m) = (Cost::ZERO, items.len() as u64);
        inner.distinct(items, compare);
        inner.close(m);
        self.then(inner);
    }

    /// The union of two ascending lists, ascending, and of every item whether it is in both: a halving merge
    /// (Blelloch 1990), charged as vector steps over `m`, `m/2`, ..., 1 items, `m` being both lengths together.
    pub fn unite<T: Copy + Ord>(&mut self, a: &[T], b: &[T]) -> Vec<(T, bool)> {
        let mut left = a.len() + b.len();
        while left > 0 {
            self.step(left);
            left = if left == 1 { 0 } else { left.div_ceil(2) };
        }
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

    /// A loop on one processor: every trip costs one unit of work and of depth.
    pub fn sequential<A>(&mut self, trips: usize, init: A, mut f: impl FnMut(A, usize) -> A) -> A {
        let mut state = init;
        for i in 0..trips {
            self.step(1);
            state = f(state, i);
        }
        state
    }
}

/// Counts the items of a vector step one by one, where they are found by walking.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sweep {
    items: u64,
}

impl Sweep {
    /// One more item is processed.
    #[inline]
    pub fn visit(&mut self) {
        self.items += 1;
    }

    /// So many items are processed together, as the lanes of registers.
    #[inline]
    pub fn visit_lanes(&mut self, lanes: usize) {
        self.items += lanes as u64;
    }

    /// Processes all items of a slice.
    #[inline]
    pub fn each<T>(&mut self, items: &[T], f: impl FnMut(&T)) {
        self.items += items.len() as u64;
        items.iter().for_each(f);
    }

    /// Processes the distances of a point to all others of a range: see [`CoordinateArrays::each_within`].
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

    /// Finds the points within the limit of a centre (`KdBlocks::find_within`). The machine looks at all, in one step, and
    /// that is what is charged; a processor looks at those whose blocks are within it.
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

    /// Number of items so far.
    pub fn items(&self) -> u64 {
        self.items
    }

    /// Joins another share of the same step.
    pub fn join(&mut self, other: &Sweep) {
        self.items += other.items;
    }
}

/// Takes the items whose flag is not `stay` out of a column, if it is not empty. Which way an item goes cannot be foreseen,
/// so it is written to both places, and the list that it belongs to grows.
fn take_others<T: Copy>(flags: &[u8], stay: u8, items: &mut Vec<T>) -> Vec<T> {
    let Some(&first) = items.first() else { return Vec::new() };
    let all = flags.iter().filter(|&&flag| flag != stay).count();
    let mut others = vec![first; all + 1];
    let (mut kept, mut gone) = (0, 0);
    for (i, &flag) in flags.iter().enumerate() {
        let (item, stays) = (items[i], usize::from(flag == stay));
        items[kept] = item;
        others[gone] = item;
        kept += stays;
        gone += 1 - stays;
    }
    items.truncate(kept);
    others.truncate(gone);
    others
}

/// `ceil(log2 m)`, 0 for `m <= 1`.
#[inline]
pub fn ceil_log2(m: u64) -> u64 {
    if m <= 1 { 0 } else { u64::from((m - 1).ilog2()) + 1 }
}

#[cfg(test)]
mod tests;
