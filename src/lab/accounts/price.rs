//! The prices of the primitives, from the table on the page `machine` of the guide.

use std::collections::BTreeMap;

use super::error::AccountError;
use super::row::Entry;

/// Work and depth of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Price {
    pub(super) work: u64,
    pub(super) depth: u64,
}

impl Price {
    /// Adds the price of a later step. Returns `None` if a sum is above the largest 64-bit number.
    fn plus(self, other: Price) -> Option<Price> {
        let work = self.work.checked_add(other.work)?;
        Some(Price { work, depth: self.depth.checked_add(other.depth)? })
    }
}

/// The largest number of nested `lanes`: the longest lane of a `lanes` entry may contain another one.
const DEEPEST: u32 = 2;

/// Computes the number of vector steps of a sort: `ceil(log2 items)`, at least 1.
fn sort_steps(items: u64) -> u64 {
    let mut steps = 1;
    while 1u128 << steps < u128::from(items) {
        steps += 1;
    }
    steps
}

/// The reason why a call has no price.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unpriced {
    /// The primitive is unknown.
    Unknown,
    /// The price is above the largest 64-bit number.
    TooLarge,
}

/// Returns the price of one call.
pub(super) fn of_call(primitive: &str, items: u64) -> Result<Price, Unpriced> {
    let steps = match primitive {
        "barrier" => 0,
        "sweep" | "delivery" | "replicate" | "combine" if items == 0 => 0,
        "step" | "scan" => 1,
        "broadcast-map" | "sweep" => 2,
        "pack" | "pairs" => 3,
        "split" | "combine" => 4,
        "replicate" => 6,
        "sort" => sort_steps(items),
        "distinct" => sort_steps(items) + 3,
        "delivery" => sort_steps(items) + 4,
        "sequential" => return Ok(Price { work: items, depth: items }),
        "merge" => return of_merge(items).ok_or(Unpriced::TooLarge),
        _ => return Err(Unpriced::Unknown),
    };
    let work = items.checked_mul(steps).ok_or(Unpriced::TooLarge)?;
    Ok(Price { work, depth: steps })
}

/// Returns the price of vector steps over all items, over half of them (rounded up), and so on down to one item.
fn of_merge(items: u64) -> Option<Price> {
    let (mut price, mut left) = (Price::default(), items);
    while left > 0 {
        price = price.plus(Price { work: left, depth: 1 })?;
        left = if left > 1 { left - left / 2 } else { 0 };
    }
    Some(price)
}

/// The number of times that each call occurs.
type Counts<'a> = BTreeMap<(&'a str, u64), u64>;

/// Returns the price of a row.
pub(super) fn of_entry(row: u64, entry: &Entry) -> Result<Price, AccountError> {
    nested(row, entry, 0)
}

/// Returns the price of an entry that is nested in `outside` other entries.
fn nested(row: u64, entry: &Entry, outside: u32) -> Result<Price, AccountError> {
    if entry.primitive != "lanes" {
        return priced(row, &entry.primitive, entry.items);
    }
    if outside == DEEPEST {
        return Err(AccountError::Nesting { row });
    }
    let overflow = || AccountError::Overflow { row };
    let mut work = 0_u64;
    let mut counts = Counts::new();
    for calls in &entry.calls {
        let all = priced(row, &calls.primitive, calls.items)?.work.checked_mul(calls.times);
        work = all.and_then(|all| work.checked_add(all)).ok_or_else(overflow)?;
        add(&mut counts, &calls.primitive, calls.items, calls.times).ok_or_else(overflow)?;
    }
    let mut longest = Counts::new();
    count(&entry.longest, &mut longest).ok_or_else(overflow)?;
    if longest.iter().any(|(call, times)| counts.get(call).is_none_or(|all| all < times)) {
        return Err(AccountError::Longest { row });
    }
    let mut depth = 0_u64;
    for entry in &entry.longest {
        let inner = nested(row, entry, outside + 1)?.depth;
        depth = depth.checked_add(inner).ok_or_else(overflow)?;
    }
    Ok(Price { work, depth })
}

fn priced(row: u64, primitive: &str, items: u64) -> Result<Price, AccountError> {
    of_call(primitive, items).map_err(|reason| match reason {
        Unpriced::Unknown => AccountError::Primitive { row, primitive: primitive.to_owned() },
        Unpriced::TooLarge => AccountError::Overflow { row },
    })
}

/// Adds `times` equal calls to the counts. Returns `None` if their number is above the largest 64-bit number.
fn add<'a>(counts: &mut Counts<'a>, primitive: &'a str, items: u64, times: u64) -> Option<()> {
    let count = counts.entry((primitive, items)).or_default();
    *count = count.checked_add(times)?;
    Some(())
}

/// Counts the calls of a lane, including all calls of the `lanes` in it. Returns `None` if a number is above the
/// largest 64-bit number.
fn count<'a>(lane: &'a [Entry], counts: &mut Counts<'a>) -> Option<()> {
    for entry in lane {
        if entry.primitive == "lanes" {
            for calls in &entry.calls {
                add(counts, &calls.primitive, calls.items, calls.times)?;
            }
        } else {
            add(counts, &entry.primitive, entry.items, 1)?;
        }
    }
    Some(())
}
