//! Work and depth on the EREW PRAM with unit-time scans, charged by the primitives that do the work.
//!
//! **Model.** Blelloch's scan-vector model (*Vector Models for Data-Parallel Computing*, 1990). A problem of `m`
//! items has `m` virtual processors, up to a stated constant factor. A vector step over `m` items costs work `m` and
//! depth 1. If the items have their own costs, the step costs the sum of their work and the maximum of their depths.
//! A scan costs one step. A second depth ([`Price::depth_log_scan`]) charges `ceil(log2 m)` for it.
//!
//! **Prices.** Every primitive pays through the private method `Cost::pay`, with its name and its number of items. The
//! table at [`Primitive`] gives the cost of the call. Two methods do not use it: [`Cost::charge_sweeps`] adds the
//! prices of several sweeps at once, and [`Cost::run_lanes`] adds the price of its lanes.
//!
//! **Integrity.** The fields of [`Cost`] are private, and only the methods below increase them. A primitive takes its
//! number of items from the data that it walks, or from a [`Sweep`], which counts items while a traversal visits them.
//! On a processor, the traversal itself may be faster than the step that it charges.
//!
//! **Scans.** A scan runs over the items of its call. If a group of workers shares a subproblem, a member knows only
//! its own share of these items. The meter of a subproblem ([`Cost::of_subproblem`]) therefore counts scans, every
//! member charges its share, and [`Price::join`] merges the shares (sum of work, maximum depth). The ledger prices the
//! scans over the items of the whole subproblem ([`Price::depth_log_scan`]). The meter of a nested problem
//! ([`Cost::nested`]), for example of one star, prices each scan at once. No count therefore depends on the number of
//! workers.
//!
//! **Exact tests.** A test of a predicate is a part of an item's step, so the price of the step contains it. Meters count how
//! many tests needed exact arithmetic ([`Cost::charge_exact_tests`]). This count adds nothing to work or depth.
//!
//! **Second account.** A meter can also record its calls, without prices ([`Tape`]). The laboratory prices such records
//! independently of this module.

mod index_sets;
mod lanes;
mod price;
mod sorting;
mod sweep;
mod tape;

pub use index_sets::{Marks, Positions};
pub use lanes::Lanes;
pub use price::{Price, Primitive, ceil_log2};
pub use sweep::Sweep;
pub use tape::{Call, LaneStep, Step, Tape};

use sorting::take_others;

use crate::coordinate_arrays::{CoordinateArrays, PairVisitor};
use crate::kd_blocks::KdBlocks;
use crate::point::Point;
use crate::predicates::ExactTests;

/// The meter of a computation: its price, and the record of its calls if it keeps one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    price: Price,
    /// Whether every scan is priced at once, over the items of its call.
    is_nested: bool,
    tape: Option<Box<Tape>>,
}

#[expect(clippy::inline_always, reason = "the price of a known primitive is a few instructions")]
impl Cost {
    /// Creates the meter of a subproblem, whose scans the ledger prices. If `records` is set, it also records its
    /// calls.
    pub fn of_subproblem(records: bool) -> Self {
        Cost { price: Price::ZERO, is_nested: false, tape: records.then(Box::default) }
    }

    /// Creates an empty meter of the same kind.
    #[must_use]
    pub fn fresh(&self) -> Self {
        Cost { is_nested: self.is_nested, ..Cost::of_subproblem(self.tape.is_some()) }
    }

    /// Creates the meter of a nested problem, for example of one star. [`Cost::then`] or a lane adds it to this meter.
    #[must_use]
    pub fn nested(&self) -> Self {
        Cost { is_nested: true, ..Cost::of_subproblem(self.tape.is_some()) }
    }

    /// Creates the meter of a nested problem whose chains have their own clocks: its work, the steps of its longest chain,
    /// and these steps if a scan counts `ceil(log2 m)`. The meter keeps no record of calls.
    pub(crate) fn of_clock(work: u64, steps: u64, log_scan: u64) -> Self {
        let price = Price::from_parts([work, steps, 0, log_scan.saturating_sub(steps), 0]);
        Cost { price, is_nested: true, tape: None }
    }

    /// Returns the price so far.
    pub fn price(&self) -> Price {
        self.price
    }

    /// Returns the number of elementary operations so far.
    pub fn work(&self) -> u64 {
        self.price.work()
    }

    /// Returns the length of the longest chain of vector steps so far, with each scan counted as 1.
    pub fn depth(&self) -> u64 {
        self.price.depth()
    }

    /// Returns the record of the calls, if the meter keeps one.
    pub fn into_tape(self) -> Option<Tape> {
        self.tape.map(|tape| *tape)
    }

    /// Appends a computation that runs after this one.
    pub fn then(&mut self, next: Cost) {
        self.price.then(next.price);
        if let (Some(tape), Some(next)) = (&mut self.tape, next.tape) {
            tape.append(*next);
        }
    }

    /// Starts a vector step whose items have their own meters. [`Cost::run_lanes`] charges it.
    pub fn lanes(&self) -> Lanes {
        Lanes::new(self.tape.is_some())
    }

    /// Charges a vector step: the sum of the work of its lanes, and the maximum of their depths.
    pub fn run_lanes(&mut self, lanes: Lanes) {
        let (price, step) = lanes.into_step();
        self.price.then(price);
        if let (Some(tape), Some(step)) = (&mut self.tape, step) {
            tape.push(step);
        }
    }

    /// Charges one call of a primitive.
    #[inline(always)]
    fn pay(&mut self, primitive: Primitive, items: usize) {
        let items = items as u64;
        let price = primitive.price(items);
        self.price.then(if self.is_nested { price.closed(items) } else { price });
        if let Some(tape) = &mut self.tape {
            tape.call(Call { primitive, items });
        }
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

    /// Applies `f` to every item in one vector step whose items have their own meters. The step costs the sum of their
    /// work and the maximum of their depths. An item without calls costs one unit of each.
    pub fn map_nested<T, U>(&mut self, items: &[T], mut f: impl FnMut(&T, &mut Cost) -> U) -> Vec<U> {
        let mut lanes = self.lanes();
        let out = items
            .iter()
            .map(|item| {
                let mut own = self.nested();
                let value = f(item, &mut own);
                lanes.add(own);
                value
            })
            .collect();
        self.run_lanes(lanes);
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

    /// Copies one value to every item by a copy-scan. `set` stores the value in an item.
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

    /// Computes which children of a node each item reaches, and replicates the items to the children: see
    /// [`Cost::charge_replication`]. Returns the result of `f` for each item.
    pub fn replicate<T, U>(&mut self, items: &[T], f: impl FnMut(&T) -> U) -> Vec<U> {
        self.pay(Primitive::Replicate, items.len());
        items.iter().map(f).collect()
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

    /// Visits all pairs like [`Cost::all_pairs`], for a visitor that keeps a list of columns for each row. The scan
    /// computes the positions of the pairs in the lists, and another vector step moves the pairs there.
    pub fn all_pairs_to_lists<P: Point>(
        &mut self,
        rows: &[P],
        cols: &CoordinateArrays<P>,
        visitor: &mut impl PairVisitor,
    ) {
        self.all_pairs(rows, cols, visitor);
        self.pay(Primitive::VectorStep, rows.len() * cols.len());
    }

    /// Visits all pairs like [`Cost::all_pairs`], for a visitor that keeps the `k` nearest columns of each row. For
    /// `k > 1`, the pairs are also sorted by row and distance, and a vector step moves the first `k` pairs of each row.
    pub fn all_pairs_to_nearest<P: Point>(
        &mut self,
        rows: &[P],
        cols: &CoordinateArrays<P>,
        k: usize,
        visitor: &mut impl PairVisitor,
    ) {
        self.all_pairs(rows, cols, visitor);
        self.charge_lists_of(rows.len() * cols.len(), k);
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
        self.charge_sweeps([sweep]);
    }

    /// Charges finished sweeps that run one after the other.
    #[inline(always)]
    pub fn charge_sweeps<const N: usize>(&mut self, sweeps: [Sweep; N]) {
        let mut sum = Price::ZERO;
        for sweep in sweeps {
            let items = sweep.items();
            let price = Primitive::Sweep.price(items);
            sum.then(if self.is_nested { price.closed(items) } else { price });
        }
        self.price.then(sum);
        if let Some(tape) = &mut self.tape {
            for sweep in sweeps {
                tape.call(Call { primitive: Primitive::Sweep, items: sweep.items() });
            }
        }
    }

    /// Charges the replication of the items of a finished sweep to the two children of a node:
    /// 1. A copy-scan copies the separator to the items.
    /// 2. Two vector steps compute the sides that each item reaches.
    /// 3. A scan computes the positions of the copies.
    /// 4. A vector step moves the items, and a copy-scan copies each item to its positions.
    pub fn charge_replication(&mut self, sweep: Sweep) {
        self.pay(Primitive::Replicate, sweep.items() as usize);
    }

    /// Charges the combination of the results of a finished sweep's items. A vector step moves the result of each item
    /// and the result of its copy together. Two vector steps combine them, and a scan collects them.
    pub fn charge_combination(&mut self, sweep: Sweep) {
        self.pay(Primitive::Combine, sweep.items() as usize);
    }

    /// Counts exact tests among the operations that the other calls charge.
    pub fn charge_exact_tests(&mut self, tests: ExactTests) {
        self.price.add_exact_tests(tests);
    }

    /// Charges the pairs of items that a finished sweep counted, at the cost of [`Cost::all_pairs`].
    pub fn charge_pairs(&mut self, sweep: Sweep) {
        self.pay(Primitive::Pairs, sweep.items() as usize);
    }

    /// Charges the iterations that a finished sweep counted, which one processor performs in sequence.
    pub fn charge_sequence(&mut self, sweep: Sweep) {
        self.pay(Primitive::Sequential, sweep.items() as usize);
    }

    /// Charges a stable sort of a finished sweep's items.
    pub fn charge_sort(&mut self, sweep: Sweep) {
        self.pay(Primitive::Sort, sweep.items() as usize);
    }

    /// Charges the removal of repetitions from a finished sweep's items, at the cost of [`Cost::distinct`].
    pub fn charge_distinct(&mut self, sweep: Sweep) {
        self.pay(Primitive::Distinct, sweep.items() as usize);
    }

    /// Charges the lists of the `k` nearest of a finished sweep's pairs, as [`Cost::all_pairs_to_nearest`] does.
    pub fn charge_lists(&mut self, pairs: Sweep, k: usize) {
        self.charge_lists_of(pairs.items() as usize, k);
    }

    /// Charges the lists of the `k` nearest columns of each row, after the pairs were charged by [`Cost::all_pairs`].
    /// For `k = 1`, the reduction of each row is the result. Otherwise the pairs are sorted by row and distance, and a
    /// vector step moves the first `k` pairs of each row.
    fn charge_lists_of(&mut self, pairs: usize, k: usize) {
        if k > 1 {
            self.pay(Primitive::Sort, pairs);
            self.pay(Primitive::VectorStep, pairs);
        }
    }

    /// Charges a merge of two sorted lists of `len` items for each item of a finished sweep: `ceil(log2 (2 len))`
    /// vector steps over all items of the lists (bitonic merge, Batcher 1968). For lists of one item, the merge is a
    /// comparison, which [`Cost::charge_combination`] includes.
    pub fn charge_list_merges(&mut self, sweep: Sweep, len: u32) {
        if len > 1 {
            let items = sweep.items() * 2 * u64::from(len);
            for _ in 0..ceil_log2(2 * u64::from(len)) {
                self.pay(Primitive::VectorStep, items as usize);
            }
        }
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

impl Lanes {
    /// Adds a lane. A lane without calls is a vector step over one item.
    pub fn add(&mut self, lane: Cost) {
        self.add_lane(lane.price, lane.tape.map(|tape| *tape));
    }
}

#[cfg(test)]
mod tests;
