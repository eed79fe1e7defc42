//! The prices of the primitives, from the table in the guide (`machine`).

use std::collections::BTreeMap;

use super::error::AccountError;
use super::row::Entry;

/// Work and depth of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Price {
    pub(super) work: u64,
    pub(super) depth: u64,
}

/// Computes the number of vector steps of a sort: `ceil(log2 items)`, at least 1.
fn sort_steps(items: u64) -> u64 {
    let mut steps = 1;
    while 1u128 << steps < u128::from(items) {
        steps += 1;
    }
    steps
}

/// Returns the price of one call, or `None` for an unknown primitive.
pub(super) fn of_call(primitive: &str, items: u64) -> Option<Price> {
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
        "sequential" => return Some(Price { work: items, depth: items }),
        "merge" => return Some(of_merge(items)),
        _ => return None,
    };
    Some(Price { work: steps * items, depth: steps })
}

/// Returns the price of vector steps over all items, over half of them, and so on down to one item.
fn of_merge(items: u64) -> Price {
    let (mut price, mut left) = (Price::default(), items);
    while left > 0 {
        price = Price { work: price.work + left, depth: price.depth + 1 };
        left = if left > 1 { left - left / 2 } else { 0 };
    }
    price
}

/// The number of times that each call occurs.
type Counts<'a> = BTreeMap<(&'a str, u64), u64>;

/// Returns the price of a row.
pub(super) fn of_entry(row: u64, entry: &Entry) -> Result<Price, AccountError> {
    if entry.primitive != "lanes" {
        return priced(row, &entry.primitive, entry.items);
    }
    let mut work = 0;
    let mut counts = Counts::new();
    for calls in &entry.calls {
        work += calls.times * priced(row, &calls.primitive, calls.items)?.work;
        *counts.entry((&calls.primitive, calls.items)).or_default() += calls.times;
    }
    let mut longest = Counts::new();
    count(&entry.longest, &mut longest);
    if longest.iter().any(|(call, times)| counts.get(call).is_none_or(|all| all < times)) {
        return Err(AccountError::Longest { row });
    }
    let depths = entry.longest.iter().map(|entry| Ok(of_entry(row, entry)?.depth));
    Ok(Price { work, depth: depths.sum::<Result<u64, AccountError>>()? })
}

fn priced(row: u64, primitive: &str, items: u64) -> Result<Price, AccountError> {
    of_call(primitive, items).ok_or_else(|| AccountError::Primitive { row, primitive: primitive.to_owned() })
}

/// Counts the calls of a lane, with those of the vector steps inside.
fn count<'a>(lane: &'a [Entry], counts: &mut Counts<'a>) {
    for entry in lane {
        if entry.primitive == "lanes" {
            for calls in &entry.calls {
                *counts.entry((&calls.primitive, calls.items)).or_default() += calls.times;
            }
        } else {
            *counts.entry((&entry.primitive, entry.items)).or_default() += 1;
        }
    }
}
