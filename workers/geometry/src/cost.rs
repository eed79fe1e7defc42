//! Work and depth on the EREW PRAM with unit-time scans, charged by the primitives that do the work.
//!
//! **Model.** Blelloch's scan-vector model (*Vector Models for Data-Parallel Computing*, 1990). A problem of `m`
//! items has `m` virtual processors, up to a stated constant factor. A vector step over `m` items costs work `m` and
//! depth 1. If the items have their own costs, the step costs the sum of their work and the maximum of their depths.
//! A scan costs one step. A second depth ([`Cost::depth_log_scan`]) charges `ceil(log2 m)` for it.
//!
//! **Prices.** Every primitive pays through one private call, `Cost::pay`, with its name and its number of items. The
//! table at [`Primitive`] gives the cost of the call.
//!
//! **Integrity.** The fields of [`Cost`] are private, and only the primitives below raise them. Each primitive runs the
//! loop for which it charges. A caller can therefore neither state a cost nor run an uncharged loop inside a primitive,
//! unless that loop is a primitive itself. There are two exceptions: [`Cost::from_parts`] decodes a cost, and the
//! caller counts the items of a [`Sweep`].
//!
//! **Shared subproblems.** Work and depth are charged to subproblems, not to workers. If a group of workers shares a
//! subproblem, every member charges its own share, and [`Cost::join`] merges the shares (sum of work, maximum depth).
//! The ledger prices the scans over the number of items of the whole subproblem when it folds the shares
//! ([`Cost::depth_log_scan`]). So no count depends on the number of workers.

mod index_sets;
mod price;
mod sorting;
mod sweep;

pub use index_sets::{Marks, Positions};
pub use price::{Price, Primitive, ceil_log2};
pub use sweep::Sweep;

use price::sort_steps;
use sorting::take_others;

use crate::coordinate_arrays::{CoordinateArrays, PairVisitor};
use crate::kd_blocks::KdBlocks;
use crate::point::Point;

/// Work and depth of a computation, in the model of [`crate::cost`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    work: u64,
    depth: u64,
    /// Scans on the longest chain that run over the items of the subproblem.
    scans: u64,
    /// Additional depth of scans over other numbers of items, if a scan of `m` items takes `ceil(log2 m)` steps.
    inner_log: u64,
}

#[expect(clippy::inline_always, reason = "the price of a known primitive is a few instructions")]
impl Cost {
    /// The cost of an empty computation.
    pub const ZERO: Cost = Cost { work: 0, depth: 0, scans: 0, inner_log: 0 };

    /// Returns the number of elementary operations.
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Returns the length of the longest chain of vector steps, with each scan counted as 1.
    pub fn depth(&self) -> u64 {
        self.depth
    }

    /// Returns the number of scans over the subproblem's own items on that chain.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Returns the length of the longest chain if a scan over `items` items counts `ceil(log2 items)`, at least 1.
    pub fn depth_log_scan(&self, items: u64) -> u64 {
        self.depth + self.inner_log + self.additional_depth(items)
    }

    /// Returns the additional depth of the scans if each takes `ceil(log2 items)` steps, at least 1, instead of one.
    #[inline(always)]
    fn additional_depth(&self, items: u64) -> u64 {
        self.scans * (sort_steps(items) - 1)
    }

    /// Encodes the cost as four numbers: work, depth, scans, and the additional depth of closed scans.
    pub fn to_parts(self) -> [u64; 4] {
        [self.work, self.depth, self.scans, self.inner_log]
    }

    /// Decodes a cost from the numbers of [`Cost::to_parts`].
    pub fn from_parts(p: [u64; 4]) -> Self {
        Cost { work: p[0], depth: p[1], scans: p[2], inner_log: p[3] }
    }

    /// Appends a computation that runs after this one.
    pub fn then(&mut self, next: Cost) {
        self.work += next.work;
        self.depth += next.depth;
        self.scans += next.scans;
        self.inner_log += next.inner_log;
    }

    /// Adds a computation that runs in parallel: sum of work, maximum depth.
    pub fn join(&mut self, other: Cost) {
        self.work += other.work;
        self.depth = self.depth.max(other.depth);
        self.scans = self.scans.max(other.scans);
        self.inner_log = self.inner_log.max(other.inner_log);
    }

    /// Fixes the number of items of all scans so far. The problem can then become an item of a larger vector step.
    #[inline(always)]
    pub fn close(&mut self, items: u64) {
        self.inner_log += self.additional_depth(items);
        self.scans = 0;
    }

    /// Charges one call of a primitive.
    #[inline(always)]
    fn pay(&mut self, primitive: Primitive, items: usize) {
        let price = primitive.price(items as u64);
        self.work += price.work;
        self.depth += price.depth;
        self.scans += price.scans;
    }

    /// Charges one call of a primitive that is an item of a larger problem: its scans run over its own items.
    #[inline(always)]
    fn pay_nested(&mut self, primitive: Primitive, items: usize) {
        let mut inner = Cost::ZERO;
        inner.pay(primitive, items);
        inner.close(items as u64);
        self.then(inner);
    }

    /// Applies `f` to every item in one vector step.
    pub fn map<T, U>(&mut self, items: &[T], mut f: impl FnMut(&T) -> U) -> Vec<U> {
        self.pay(Primitive::VectorStep, items.len());
        items.iter().map(&mut f).collect()
    }

    /// Changes every item in place in one vector step.
    pub fn update<T>(&mut self, items: &mut [T], mut f: impl FnMut(&mut T)) {
        self.pay(Primitive::VectorStep, items.len());
        items.iter_mut().for_each(&mut f);
    }

    /// Applies `f` to every item in one vector step whose items have their own costs. The step costs the sum of their
    /// work and the maximum of their depths; an item costs at least one unit of each.
    pub fn map_nested<T, U>(&mut self, items: &[T], mut f: impl FnMut(&T, &mut Cost) -> U) -> Vec<U> {
        let mut all = Cost::ZERO;
        let out = items
            .iter()
            .map(|item| {
                let mut own = Cost::ZERO;
                let value = f(item, &mut own);
                own.work = own.work.max(1);
                own.depth = own.depth.max(1);
                all.join(own);
                value
            })
            .collect();
        self.then(all);
        out
    }

    /// Reduces the items to one value by a scan.
    pub fn reduce<T, A>(&mut self, items: &[T], init: A, f: impl FnMut(A, &T) -> A) -> A {
        self.pay(Primitive::Scan, items.len());
        items.iter().fold(init, f)
    }

    /// Computes the exclusive prefix sums of some counts, and their total.
    pub fn scan(&mut self, counts: &[usize]) -> (Vec<usize>, usize) {
        self.pay(Primitive::Scan, counts.len());
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

    /// Selects the items that `keep` accepts, in their order.
    pub fn pack<T: Copy>(&mut self, items: &[T], mut keep: impl FnMut(&T) -> bool) -> Vec<T> {
        self.pay(Primitive::Pack, items.len());
        items.iter().copied().filter(|t| keep(t)).collect()
    }

    /// Separates the items that `left` accepts from the other items. Both parts keep their order.
    pub fn split<T: Copy>(&mut self, items: &[T], mut left: impl FnMut(&T) -> bool) -> (Vec<T>, Vec<T>) {
        self.pay(Primitive::Split, items.len());
        items.iter().copied().partition(|t| left(t))
    }

    /// Copies one value to every item by a copy-scan; `set` stores it.
    pub fn broadcast<T>(&mut self, items: &mut [T], mut set: impl FnMut(&mut T)) {
        self.pay(Primitive::Scan, items.len());
        items.iter_mut().for_each(&mut set);
    }

    /// Copies one value to every item by a copy-scan, then applies `f` to the value and the item in a vector step.
    pub fn map_with<V: Copy, T, U>(
        &mut self,
        value: V,
        items: &[T],
        mut f: impl FnMut(V, &T) -> U,
    ) -> Vec<U> {
        self.pay(Primitive::BroadcastMap, items.len());
        items.iter().map(|item| f(value, item)).collect()
    }

    /// Splits records, stored as three parallel arrays, by flags from the previous vector step. Records with the flag
    /// `stay` remain in their order, and the others are returned. Any of the arrays may be empty. Costs the same as
    /// [`Cost::split`].
    pub fn split_arrays<A: Copy, B: Copy, C: Copy>(
        &mut self,
        flags: &[u8],
        stay: u8,
        a: &mut Vec<A>,
        b: &mut Vec<B>,
        c: &mut Vec<C>,
    ) -> (Vec<A>, Vec<B>, Vec<C>) {
        self.pay(Primitive::Split, flags.len());
        (take_others(flags, stay, a), take_others(flags, stay, b), take_others(flags, stay, c))
    }

    /// Reads `out[i] = items[index[i]]`. Reads are exclusive, so the indices must be distinct.
    ///
    /// # Errors
    /// Returns the first index that occurs twice.
    pub fn gather<T: Copy>(&mut self, items: &[T], index: &[u32]) -> Result<Vec<T>, usize> {
        self.pay(Primitive::VectorStep, index.len());
        let mut seen = vec![false; items.len()];
        index
            .iter()
            .map(|&i| {
                let i = i as usize;
                if std::mem::replace(&mut seen[i], true) { Err(i) } else { Ok(items[i]) }
            })
            .collect()
    }

    /// Visits all pairs of a row and a column: a copy-scan replicates the columns, a vector step processes the pairs,
    /// and a segmented reduction leaves one result for each row. `visitor` receives the columns within the limit of a
    /// row.
    pub fn all_pairs<P: Point>(
        &mut self,
        rows: &[P],
        cols: &CoordinateArrays<P>,
        visitor: &mut impl PairVisitor,
    ) {
        self.pay(Primitive::Pairs, rows.len() * cols.len());
        cols.each_row(rows, visitor);
    }

    /// Visits all pairs of points of one set, at the cost of [`Cost::all_pairs`]. A processor tests each point only
    /// against the blocks within the limit of the point.
    pub fn all_pairs_in_blocks<P: Point>(&mut self, points: &KdBlocks<P>, visitor: &mut impl PairVisitor) {
        self.pay(Primitive::Pairs, points.len() * points.len());
        points.each_row(visitor);
    }

    /// Starts a vector step whose items the caller visits one by one ([`Sweep::visit`]). It costs nothing until it is
    /// charged, for example by [`Cost::charge_sweep`].
    pub fn sweep(&self) -> Sweep {
        Sweep::default()
    }

    /// Charges a finished sweep: one vector step, and one scan that collects its result.
    #[inline(always)]
    pub fn charge_sweep(&mut self, sweep: Sweep) {
        self.pay(Primitive::Sweep, sweep.items() as usize);
    }

    /// Charges a finished sweep that is an item of a larger problem: its scan runs over its own items.
    #[inline(always)]
    pub fn charge_nested_sweep(&mut self, sweep: Sweep) {
        self.pay_nested(Primitive::Sweep, sweep.items() as usize);
    }

    /// Charges the delivery of a finished sweep's items to their receivers, which drop the items that they already
    /// hold. The items are sorted by receiver. A copy-scan copies the data of each receiver to its items, and a
    /// comparison and a pack follow.
    pub fn charge_delivery(&mut self, sweep: Sweep) {
        self.pay(Primitive::Delivery, sweep.items() as usize);
    }

    /// Runs a loop on one processor: every iteration costs one unit of work and of depth.
    pub fn sequential<A>(&mut self, iterations: usize, init: A, f: impl FnMut(A, usize) -> A) -> A {
        self.pay(Primitive::Sequential, iterations);
        (0..iterations).fold(init, f)
    }
}

#[cfg(test)]
mod tests;
