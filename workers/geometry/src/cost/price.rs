//! The price list of the machine: the cost of each primitive as a function of its number of items.
//!
//! **Statement.** The table at [`Primitive`].
//!
//! **Source.** Packs, splits and copy-scans: Blelloch, *Vector Models for Data-Parallel Computing* (1990). Sort:
//! pipelined merge sort (Cole 1988, EREW). Merge: halving merge (Blelloch 1990).

use crate::predicates::ExactTests;

/// A primitive operation of the machine, priced by its number of items.
///
/// A *vector step* over `m` items costs work `m` and depth 1. A *scan* is a vector step that also counts as one scan.
/// Every other primitive is a fixed sequence of these. With `L = max(ceil(log2 m), 1)`:
///
/// | primitive | sequence | work | depth | scans |
/// | --- | --- | --- | --- | --- |
/// | vector step | one step | `m` | 1 | 0 |
/// | scan | one scan | `m` | 1 | 1 |
/// | pack | flag, scan, permute | `3 m` | 3 | 1 |
/// | split | flag, two scans, permute | `4 m` | 4 | 2 |
/// | broadcast and map | copy-scan, step | `2 m` | 2 | 1 |
/// | pairs | copy-scan, step, segmented reduction | `3 m` | 3 | 2 |
/// | sweep | step, scan that collects the result | `2 m` | 2 | 1 |
/// | sort | `L` steps | `L m` | `L` | 0 |
/// | distinct | sort, flag, scan, permute | `(L + 3) m` | `L + 3` | 1 |
/// | delivery | sort by receiver, copy-scan, comparison, scan, permute | `(L + 4) m` | `L + 4` | 2 |
/// | replication | copy-scan, two steps, scan, permute, copy-scan | `6 m` | 6 | 3 |
/// | combination | permute, two steps, scan | `4 m` | 4 | 1 |
/// | merge | steps over `m`, `m/2` (rounded up), ..., 1 items | the sum | number of steps | 0 |
/// | sequential loop | `m` steps over one item | `m` | `m` | 0 |
///
/// A sweep, a delivery, a replication, a combination, a merge or a sequential loop without items is free. Without
/// items, the other primitives still cost their depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Primitive {
    /// One operation on every item.
    VectorStep,
    /// A scan, a reduction or a copy-scan (broadcast).
    Scan,
    /// The selected items, moved together.
    Pack,
    /// The selected items moved together, and the other items moved together.
    Split,
    /// One value copied to every item, then one operation on every item.
    BroadcastMap,
    /// One operation on every pair of a row and a column, and a reduction for each row. The items are the pairs.
    Pairs,
    /// A step over visited items, and a scan that collects its result.
    Sweep,
    /// A stable sort.
    Sort,
    /// A sort that keeps one item of each run of equal items.
    Distinct,
    /// A sort of items by receiver that drops the items that the receiver already holds.
    Delivery,
    /// Items that go to one or both children of a node.
    Replicate,
    /// Results of items and their copies, combined in pairs.
    Combine,
    /// A merge of two sorted lists. The number of items is the sum of both lengths.
    Merge,
    /// A loop on one processor. The items are its iterations.
    Sequential,
}

/// Work and depth of a computation, in the model of [`crate::cost`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Price {
    work: u64,
    depth: u64,
    /// Open scans: those on the longest chain that run over the items of the subproblem.
    scans: u64,
    /// Additional depth of the closed scans, which run over known numbers of items, if a scan of `m` items takes
    /// `ceil(log2 m)` steps.
    inner_log: u64,
    /// Exact tests ([`crate::predicates::ExactTests`]). They are in the work, too, like all other tests.
    exact_tests: u64,
}

#[expect(clippy::inline_always, reason = "the price of a known primitive is a few instructions")]
impl Price {
    /// The numbers of [`Price::to_parts`].
    pub const PARTS: usize = 5;

    /// The price of an empty computation.
    pub const ZERO: Price = Price::from_parts([0; Price::PARTS]);

    /// Returns the number of elementary operations.
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Returns the length of the longest chain of vector steps, with each scan counted as 1.
    pub fn depth(&self) -> u64 {
        self.depth
    }

    /// Returns the number of exact tests.
    pub fn exact_tests(&self) -> u64 {
        self.exact_tests
    }

    /// Returns the number of scans over the subproblem's own items on the longest chain.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Returns the length of the longest chain if a scan over `items` items counts `ceil(log2 items)`, at least 1.
    pub fn depth_log_scan(&self, items: u64) -> u64 {
        self.depth + self.inner_log + self.additional_depth(items)
    }

    /// Returns the additional depth of the open scans if each takes `ceil(log2 items)` steps, at least 1, instead of
    /// one.
    #[inline(always)]
    fn additional_depth(&self, items: u64) -> u64 {
        self.scans * (sort_steps(items) - 1)
    }

    /// Encodes the price as numbers: work, depth, scans, the additional depth of closed scans, and exact tests.
    pub fn to_parts(self) -> [u64; Price::PARTS] {
        [self.work, self.depth, self.scans, self.inner_log, self.exact_tests]
    }

    /// Decodes a price from the numbers of [`Price::to_parts`].
    pub const fn from_parts(parts: [u64; Price::PARTS]) -> Self {
        let [work, depth, scans, inner_log, exact_tests] = parts;
        Price { work, depth, scans, inner_log, exact_tests }
    }

    /// Appends a computation that runs after this one.
    #[inline(always)]
    pub fn then(&mut self, next: Price) {
        self.work += next.work;
        self.depth += next.depth;
        self.scans += next.scans;
        self.inner_log += next.inner_log;
        self.exact_tests += next.exact_tests;
    }

    /// Adds exact tests.
    pub(super) fn add_exact_tests(&mut self, tests: ExactTests) {
        self.exact_tests += tests.count();
    }

    /// Adds a computation that runs in parallel: sum of work and exact tests, maximum depth.
    pub fn join(&mut self, other: Price) {
        self.work += other.work;
        self.depth = self.depth.max(other.depth);
        self.scans = self.scans.max(other.scans);
        self.inner_log = self.inner_log.max(other.inner_log);
        self.exact_tests += other.exact_tests;
    }

    /// Closes all open scans: fixes their number of items. The computation can then become an item of a larger vector
    /// step.
    #[must_use]
    #[inline(always)]
    pub fn closed(self, items: u64) -> Self {
        Price { inner_log: self.inner_log + self.additional_depth(items), scans: 0, ..self }
    }

    /// Returns the price as a lane of a vector step. A lane without calls is a vector step over one item.
    pub(super) fn of_lane(self) -> Self {
        if self.depth == 0 {
            Price { exact_tests: self.exact_tests, ..Price::of_steps(1, 1, 0) }
        } else {
            self
        }
    }

    /// Returns the price of `steps` vector steps over `items` items, of which `scans` are scans.
    #[inline]
    const fn of_steps(items: u64, steps: u64, scans: u64) -> Self {
        Price { work: steps * items, depth: steps, scans, ..Price::ZERO }
    }

    /// Returns the price of a halving merge.
    #[inline]
    const fn of_merge(items: u64) -> Self {
        let mut price = Price::ZERO;
        let mut left = items;
        while left > 0 {
            price.work += left;
            price.depth += 1;
            left = if left == 1 { 0 } else { left.div_ceil(2) };
        }
        price
    }
}

#[expect(clippy::inline_always, reason = "the price of a known primitive is a few instructions")]
impl Primitive {
    /// All primitives.
    pub const ALL: [Primitive; 14] = [
        Primitive::VectorStep,
        Primitive::Scan,
        Primitive::Pack,
        Primitive::Split,
        Primitive::BroadcastMap,
        Primitive::Pairs,
        Primitive::Sweep,
        Primitive::Sort,
        Primitive::Distinct,
        Primitive::Delivery,
        Primitive::Replicate,
        Primitive::Combine,
        Primitive::Merge,
        Primitive::Sequential,
    ];

    /// Returns the name of the primitive in cost traces.
    pub fn name(self) -> &'static str {
        match self {
            Primitive::VectorStep => "step",
            Primitive::Scan => "scan",
            Primitive::Pack => "pack",
            Primitive::Split => "split",
            Primitive::BroadcastMap => "broadcast-map",
            Primitive::Pairs => "pairs",
            Primitive::Sweep => "sweep",
            Primitive::Sort => "sort",
            Primitive::Distinct => "distinct",
            Primitive::Delivery => "delivery",
            Primitive::Replicate => "replicate",
            Primitive::Combine => "combine",
            Primitive::Merge => "merge",
            Primitive::Sequential => "sequential",
        }
    }

    /// Returns the price of one call over `items` items.
    #[inline(always)]
    pub const fn price(self, items: u64) -> Price {
        match self {
            Primitive::VectorStep => Price::of_steps(items, 1, 0),
            Primitive::Scan => Price::of_steps(items, 1, 1),
            Primitive::Pack => Price::of_steps(items, 3, 1),
            Primitive::Split => Price::of_steps(items, 4, 2),
            Primitive::Pairs => Price::of_steps(items, 3, 2),
            Primitive::Sort => Price::of_steps(items, sort_steps(items), 0),
            Primitive::Distinct => Price::of_steps(items, sort_steps(items) + 3, 1),
            Primitive::Sweep | Primitive::Delivery | Primitive::Replicate | Primitive::Combine
                if items == 0 =>
            {
                Price::ZERO
            }
            Primitive::BroadcastMap | Primitive::Sweep => Price::of_steps(items, 2, 1),
            Primitive::Delivery => Price::of_steps(items, sort_steps(items) + 4, 2),
            Primitive::Replicate => Price::of_steps(items, 6, 3),
            Primitive::Combine => Price::of_steps(items, 4, 1),
            Primitive::Merge => Price::of_merge(items),
            Primitive::Sequential => Price::of_steps(1, items, 0),
        }
    }
}

/// Computes `ceil(log2 m)`, at least 1: the vector steps of a sort, and the depth of a scan without a scan unit.
#[inline]
pub(super) const fn sort_steps(items: u64) -> u64 {
    let steps = ceil_log2(items);
    if steps == 0 { 1 } else { steps }
}

/// Computes `ceil(log2 m)`, which is 0 for `m <= 1`.
#[inline]
pub const fn ceil_log2(m: u64) -> u64 {
    if m <= 1 { 0 } else { (m - 1).ilog2() as u64 + 1 }
}
