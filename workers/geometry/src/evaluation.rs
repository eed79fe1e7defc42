//! Rules that the ranks of a machine evaluate at items, level by level.
//!
//! **Statement.** An *item* is a list of words. A rule returns the results of an item, and its items of the next level. It
//! decides by the item, and by data that all ranks have. A level is therefore one vector step, and the results do not
//! depend on the rank that evaluates an item. The results of a level, and the items of the next level, are in the order of
//! the items.
//!
//! **Work and depth.** Each lane of an item has its own meter ([`Made::lane`]). A level costs the work of its lanes and the
//! depth of its deepest lane. If there is a next level, a scan over the items finds the places of the items of that level.

mod words;

use std::ops::Range;

pub use words::{At, Reader, Words};

use crate::cost::{Cost, Lanes};

/// Items, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Items {
    lengths: Vec<u32>,
    words: Vec<u64>,
}

impl Items {
    /// Creates items from their lengths and their words. Returns `None` if the lengths do not add up to the words.
    pub fn from_parts(lengths: Vec<u32>, words: Vec<u64>) -> Option<Self> {
        let sum: u64 = lengths.iter().map(|&length| u64::from(length)).sum();
        (sum == words.len() as u64).then_some(Items { lengths, words })
    }

    /// Returns the lengths and the words.
    pub fn into_parts(self) -> (Vec<u32>, Vec<u64>) {
        (self.lengths, self.words)
    }

    /// Appends an item, which `write` writes.
    pub fn push(&mut self, write: impl FnOnce(&mut Vec<u64>)) {
        let start = self.words.len();
        write(&mut self.words);
        self.lengths.push((self.words.len() - start) as u32);
    }

    /// Moves other items to the end.
    pub fn append(&mut self, mut other: Items) {
        if self.lengths.is_empty() {
            *self = other;
            return;
        }
        self.lengths.append(&mut other.lengths);
        self.words.append(&mut other.words);
    }

    /// Returns the number of items.
    pub fn len(&self) -> usize {
        self.lengths.len()
    }

    /// Returns `true` if there are no items.
    pub fn is_empty(&self) -> bool {
        self.lengths.is_empty()
    }

    /// Returns the items in order.
    pub fn iter(&self) -> impl Iterator<Item = &[u64]> {
        let mut rest = &self.words[..];
        self.lengths.iter().map(move |&length| {
            let (item, after) = rest.split_at((length as usize).min(rest.len()));
            rest = after;
            item
        })
    }

    /// Returns the items as values.
    pub fn read<T: Words>(&self) -> Vec<T> {
        self.iter().map(T::of).collect()
    }

    /// Divides the items into parts of these numbers of items. Items beyond the last part are not returned.
    pub fn parts(&self, counts: impl IntoIterator<Item = usize>) -> Vec<Items> {
        let (mut at, mut from) = (0, 0);
        let part = |count: usize| {
            let lengths = &self.lengths[at..(at + count).min(self.lengths.len())];
            let to = from + lengths.iter().map(|&length| length as usize).sum::<usize>();
            let part = Items { lengths: lengths.to_vec(), words: self.words[from..to].to_vec() };
            (at, from) = (at + lengths.len(), to);
            part
        };
        counts.into_iter().map(part).collect()
    }
}

/// The results of items, and their items of the next level.
#[derive(Debug)]
pub struct Made {
    /// The results.
    pub results: Items,
    /// The items of the next level.
    pub next: Items,
    /// For each item, its number of items of the next level.
    counts: Vec<usize>,
    lanes: Lanes,
    meter: Cost,
}

impl Made {
    /// Creates the results of no items. The meters of the lanes are of the kind of `meter`.
    pub fn new(meter: &Cost) -> Self {
        let (results, next) = (Items::default(), Items::default());
        Made { results, next, counts: Vec::new(), lanes: meter.lanes(), meter: meter.fresh() }
    }

    /// Evaluates a rule at items, one after the other.
    pub fn of<'a>(rule: &dyn Evaluation, items: impl IntoIterator<Item = &'a [u64]>, meter: &Cost) -> Self {
        let mut made = Made::new(meter);
        for item in items {
            let before = made.next.len();
            rule.evaluate(item, &mut made);
            made.counts.push(made.next.len() - before);
        }
        made
    }

    /// Runs a lane of the vector step.
    pub fn lane<T>(&mut self, f: impl FnOnce(&mut Cost) -> T) -> T {
        let mut own = self.meter.nested();
        let value = f(&mut own);
        self.lanes.add(own);
        value
    }

    /// Appends what later items of the same level made.
    pub fn append(&mut self, mut later: Made) {
        self.results.append(later.results);
        self.next.append(later.next);
        self.counts.append(&mut later.counts);
        self.lanes.join(later.lanes);
    }

    /// Returns the results, the items of the next level, and the cost of the level. `is_last` is set if the rule has no next
    /// level.
    pub fn into_parts(self, is_last: bool) -> (Items, Items, Cost) {
        let Made { results, next, counts, lanes, meter } = self;
        let mut cost = meter;
        cost.run_lanes(lanes);
        if !is_last {
            cost.scan(&counts);
        }
        (results, next, cost)
    }
}

/// The totals of all ranks after a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Number of levels that were evaluated.
    pub levels: u32,
    /// Number of results of all these levels.
    pub results: u64,
    /// Number of items of the next level.
    pub next: u64,
    /// Number of items of the levels from the second to the next one.
    pub all_next: u64,
}

/// A rule and its first items.
pub trait Evaluation: Sync {
    /// Returns the number of first items.
    fn count(&self) -> u64;

    /// Returns the first items with these numbers.
    fn first(&self, range: Range<u64>) -> Items;

    /// Evaluates an item.
    fn evaluate(&self, item: &[u64], made: &mut Made);

    /// Returns `true` if the rule has one level only.
    fn is_flat(&self) -> bool {
        false
    }

    /// Returns `true` if the evaluation stops before the next level. All ranks have the same totals.
    fn stops(&self, _progress: &Progress) -> bool {
        false
    }
}

/// What a rule returned.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Evaluated {
    /// The results of each level, in the order of the items.
    pub levels: Vec<Items>,
    /// The items that were not evaluated because the rule stopped.
    pub rest: Items,
}

impl Evaluated {
    /// Returns the results of all levels as values.
    pub fn read<T: Words>(&self) -> Vec<T> {
        self.levels.iter().flat_map(|level| level.iter().map(T::of)).collect()
    }

    /// Appends what the next rank returned.
    pub fn append(&mut self, later: Evaluated) {
        let levels = self.levels.len().max(later.levels.len());
        self.levels.resize_with(levels, Items::default);
        for (level, items) in self.levels.iter_mut().zip(later.levels) {
            level.append(items);
        }
        self.rest.append(later.rest);
    }
}

/// Evaluates a rule without a machine. `level` evaluates the items of a level.
pub fn alone(rule: &dyn Evaluation, level: impl Fn(&Items) -> Made) -> Evaluated {
    let mut items = rule.first(0..rule.count());
    let (mut evaluated, mut progress) = (Evaluated::default(), Progress::default());
    loop {
        let (results, next, _) = level(&items).into_parts(true);
        progress.add([results.len() as u64, next.len() as u64]);
        evaluated.levels.push(results);
        if next.is_empty() {
            return evaluated;
        }
        if rule.stops(&progress) {
            evaluated.rest = next;
            return evaluated;
        }
        items = next;
    }
}

impl Progress {
    /// Adds a level, by the number of its results and the number of items of the next level.
    pub fn add(&mut self, [results, next]: [u64; 2]) {
        self.levels += 1;
        self.results += results;
        self.next = next;
        self.all_next += next;
    }
}

/// A function of each item.
pub struct Map<'a, T, F> {
    /// The items.
    pub items: &'a [T],
    /// The function, with the meter of the item's lane.
    pub function: F,
}

impl<T, U, F> Evaluation for Map<'_, T, F>
where
    T: Words + Sync,
    U: Words,
    F: Fn(T, &mut Cost) -> U + Sync,
{
    fn count(&self) -> u64 {
        self.items.len() as u64
    }

    fn first(&self, range: Range<u64>) -> Items {
        let mut items = Items::default();
        for item in &self.items[range.start as usize..range.end as usize] {
            items.push(|words| item.write(words));
        }
        items
    }

    fn evaluate(&self, item: &[u64], made: &mut Made) {
        let value = made.lane(|own| (self.function)(T::of(item), own));
        made.results.push(|words| value.write(words));
    }

    fn is_flat(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests;
