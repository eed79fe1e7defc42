//! The price list of the machine: the cost of each primitive as a function of its number of items.
//!
//! **Statement.** The table at [`Primitive`].
//!
//! **Source.** Packs, splits and copy-scans: Blelloch, *Vector Models for Data-Parallel Computing* (1990). Sort:
//! pipelined merge sort (Cole 1988, EREW). Merge: halving merge (Blelloch 1990).

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
/// | merge | steps over `m`, `m/2` (rounded up), ..., 1 items | the sum | number of steps | 0 |
/// | sequential loop | `m` steps over one item | `m` | `m` | 0 |
///
/// A sweep, a delivery, a merge or a sequential loop without items is free. Without items, the other primitives still
/// cost their depth.
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
    /// A merge of two sorted lists. The items of both lists count.
    Merge,
    /// A loop on one processor. The items are its iterations.
    Sequential,
}

/// The cost of one call of a primitive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Price {
    /// Number of elementary operations.
    pub work: u64,
    /// Number of consecutive vector steps, with each scan counted as 1.
    pub depth: u64,
    /// Number of scans among these steps.
    pub scans: u64,
}

impl Price {
    /// Returns the price of `steps` vector steps over `items` items, of which `scans` are scans.
    #[inline]
    const fn of_steps(items: u64, steps: u64, scans: u64) -> Self {
        Price { work: steps * items, depth: steps, scans }
    }

    /// Returns the price of a halving merge.
    #[inline]
    const fn of_merge(items: u64) -> Self {
        let mut price = Price { work: 0, depth: 0, scans: 0 };
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
            Primitive::Sweep | Primitive::Delivery if items == 0 => Price::of_steps(0, 0, 0),
            Primitive::BroadcastMap | Primitive::Sweep => Price::of_steps(items, 2, 1),
            Primitive::Delivery => Price::of_steps(items, sort_steps(items) + 4, 2),
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
