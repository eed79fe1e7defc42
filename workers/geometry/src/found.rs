//! What was found near a point, and the nearest of it.
//!
//! **Statement.** The `k` nearest are those no farther than the `k`-th, ties included: then they do not depend on how ties
//! are numbered. The `k`-th is selected between bounds that are drawn together: the numbers up to a bound are counted,
//! eight in one step, and the next bound is the one between that would split them right if they were spread evenly (the
//! search by interpolation, Peterson 1957). Among the few that are left it is selected as such (Hoare 1961).
//!
//! **Work.** O(1) for each point found or looked at, linear for the nearest. Those that are kept stand in the order in which
//! they were found, which is that of blocks of points, or in which answers came: whoever uses them sorts them, or does not
//! ask for an order.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

use crate::columns::LANES;
use crate::simd::{Masks, larger, widest};

/// A point found: squared distance, and position in the caller's table.
pub type Found = (f64, u32);

/// Points found, in reused storage.
#[derive(Clone, Debug, Default)]
pub struct FoundList {
    masks: Masks,
    /// Squared distances and positions of those found, and room behind them.
    distances2: Vec<f64>,
    numbers: Vec<u32>,
    len: usize,
    /// Those between the bounds.
    between: Vec<f64>,
}

/// How often the bounds are drawn together at most, and how many between them are few.
const ROUNDS: u32 = 6;
const FEW: usize = 2;

impl FoundList {
    /// Forgets them.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Squared distances of all of them, in the order in which they were found.
    pub fn distances2(&self) -> &[f64] {
        &self.distances2[..self.len]
    }

    /// Positions of all of them, in that order.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers[..self.len]
    }

    /// All of them, in that order.
    pub fn iter(&self) -> impl Iterator<Item = Found> {
        self.distances2().iter().copied().zip(self.numbers().iter().copied())
    }

    /// Room for so many more.
    #[inline(always)]
    fn make_room(&mut self, more: usize) {
        if self.distances2.len() - self.len < more {
            self.grow(more);
        }
    }

    #[cold]
    fn grow(&mut self, more: usize) {
        let room = (self.len + more).max(8 * LANES).next_power_of_two();
        self.distances2.resize(room, 0.0);
        self.numbers.resize(room, 0);
    }

    /// Adds a point.
    #[inline]
    pub fn push(&mut self, (distance2, number): Found) {
        self.make_room(1);
        (self.distances2[self.len], self.numbers[self.len]) = (distance2, number);
        self.len += 1;
    }

    /// Adds points.
    pub fn extend(&mut self, found: impl IntoIterator<Item = Found>) {
        let found = found.into_iter();
        self.make_room(found.size_hint().0);
        found.for_each(|found| self.push(found));
    }

    /// Adds those of eight points that are no farther than `limit2`, and farther than `above2`.
    #[inline(always)]
    pub(crate) fn take_lanes(
        &mut self,
        distances2: &[f64; LANES],
        numbers: &[u32; LANES],
        (above2, limit2): (f64, f64),
    ) {
        self.make_room(LANES);
        let bits = self.masks.up_to(distances2, limit2) & !self.masks.up_to(distances2, above2);
        let packed = self.masks.pack(distances2, numbers, bits);
        self.distances2[self.len..self.len + LANES].copy_from_slice(&packed.0);
        self.numbers[self.len..self.len + LANES].copy_from_slice(&packed.1);
        self.len += bits.count_ones() as usize;
    }

    /// Keeps those no farther than the `k`-th nearest, ties included, and no farther than `limit2`. Returns the `k`-th
    /// squared distance, or infinity if there are fewer than `k`, or `k` is 0.
    pub fn keep_nearest(&mut self, k: usize, limit2: f64) -> f64 {
        if self.distances2().iter().fold(false, |any, &d2| any | (d2 > limit2)) {
            self.keep(limit2);
        }
        self.keep_kth(k)
    }

    /// Keeps those no farther than the `k`-th nearest, and returns its squared distance; all and infinity if there are
    /// fewer.
    pub(crate) fn keep_kth(&mut self, k: usize) -> f64 {
        if k == 0 || self.len < k {
            return f64::INFINITY;
        }
        let kth = self.kth(k);
        if self.len > k {
            self.keep(kth);
        }
        kth
    }

    /// The `k`-th smallest squared distance.
    fn kth(&mut self, k: usize) -> f64 {
        self.make_room(LANES);
        // What is no number is never counted.
        self.distances2[self.len..self.len + LANES].fill(f64::NAN);
        let (all, _) = self.distances2[..self.len.next_multiple_of(LANES)].as_chunks::<LANES>();
        let (len, between) = (self.len, &mut self.between);
        widest(
            #[inline(always)]
            || kth_between(all, len, k, between),
        )
    }

    /// Keeps those no farther than the limit, in their order.
    fn keep(&mut self, limit2: f64) {
        self.make_room(LANES);
        self.distances2[self.len..self.len + LANES].fill(f64::NAN);
        let mut kept = 0;
        widest(
            #[inline(always)]
            || {
                for at in (0..self.len).step_by(LANES) {
                    let (Some(distances2), Some(numbers)) =
                        (self.distances2[at..].first_chunk(), self.numbers[at..].first_chunk())
                    else {
                        break;
                    };
                    let bits = self.masks.up_to(distances2, limit2);
                    let packed = self.masks.pack(distances2, numbers, bits);
                    self.distances2[kept..kept + LANES].copy_from_slice(&packed.0);
                    self.numbers[kept..kept + LANES].copy_from_slice(&packed.1);
                    kept += bits.count_ones() as usize;
                }
            },
        );
        self.len = kept;
    }
}

/// The `k`-th smallest of `len` numbers of at least 0 in blocks of eight, of which the last is filled up with what is no
/// number.
#[inline(always)]
fn kth_between(all: &[[f64; LANES]], len: usize, k: usize, between: &mut Vec<f64>) -> f64 {
    let most = largest(all, f64::INFINITY);
    // `below` are up to `low`, at least k up to `high`.
    let (mut low, mut below, mut high, mut within) = (-1.0, 0, most, len);
    let mut middle = most * (k as f64 / len as f64);
    for _ in 0..ROUNDS {
        if within == k || within - below <= FEW || !(low < middle && middle < high) {
            break;
        }
        let count = count_up_to(all, middle);
        if count < k {
            (low, below) = (middle, count);
        } else {
            (high, within) = (middle, count);
        }
        middle = low + (high - low) * ((k - below) as f64 - 0.5) / (within - below) as f64;
    }
    if within == k {
        return largest(all, high);
    }
    between.clear();
    between.extend(all.as_flattened().iter().filter(|&&d2| d2 > low && d2 <= high));
    *between.select_nth_unstable_by(k - below - 1, f64::total_cmp).1
}

/// How many are no larger than the limit.
#[inline(always)]
fn count_up_to(all: &[[f64; LANES]], limit: f64) -> usize {
    let mut counts = [0u64; LANES];
    for block in all {
        for (count, &d2) in counts.iter_mut().zip(block) {
            *count = count.wrapping_add(u64::from(d2 <= limit));
        }
    }
    counts.iter().sum::<u64>() as usize
}

/// The largest that is no larger than the limit.
#[inline(always)]
fn largest(all: &[[f64; LANES]], limit: f64) -> f64 {
    let mut most = [0.0; LANES];
    for block in all {
        for (most, &d2) in most.iter_mut().zip(block) {
            *most = if d2 <= limit && d2 > *most { d2 } else { *most };
        }
    }
    most.into_iter().fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squared distances with ties, in no order.
    fn some(count: u32) -> Vec<Found> {
        (0..count).map(|i| (f64::from(i * 7 % 13), i)).collect()
    }

    #[test]
    fn the_nearest_are_those_of_a_sorted_list() {
        // One list for all, in storage that was longer.
        let mut list = FoundList::default();
        list.extend(some(200));
        for count in 0..40 {
            for k in 0..45 {
                for limit2 in [0.0, 3.0, 12.0, f64::INFINITY] {
                    list.clear();
                    list.extend(some(count));
                    let kth = list.keep_nearest(k, limit2);
                    let mut within: Vec<Found> = some(count).into_iter().filter(|f| f.0 <= limit2).collect();
                    let mut sorted: Vec<f64> = within.iter().map(|f| f.0).collect();
                    sorted.sort_by(f64::total_cmp);
                    let expected = k.checked_sub(1).and_then(|last| sorted.get(last)).copied();
                    assert_eq!(kth, expected.unwrap_or(f64::INFINITY), "{count} {k} {limit2}");
                    within.retain(|f| f.0 <= kth);
                    assert_eq!(list.iter().collect::<Vec<_>>(), within, "{count} {k} {limit2}");
                    // The nearest of the nearest are the same.
                    assert_eq!(list.keep_nearest(k, limit2), kth, "{count} {k} {limit2}");
                    assert_eq!(list.iter().collect::<Vec<_>>(), within, "{count} {k} {limit2}");
                }
            }
        }
    }

    #[test]
    fn lanes_are_taken_in_their_order() {
        let mut list = FoundList::default();
        list.push((9.0, 9));
        let distances2 = [3.0, f64::NAN, 0.0, 1.0, 4.0, 1.0, f64::INFINITY, 2.0];
        for start in [10, 20] {
            let numbers = std::array::from_fn(|lane| start + lane as u32);
            list.take_lanes(&distances2, &numbers, (0.0, 3.0));
        }
        assert_eq!(list.numbers(), [9, 10, 13, 15, 17, 20, 23, 25, 27]);
        list.clear();
        assert!(list.is_empty() && list.numbers().is_empty() && list.distances2().is_empty());
        // More than there was room for.
        for start in 0..100 {
            let numbers = std::array::from_fn(|lane| start as u32 * 8 + lane as u32);
            list.take_lanes(&[f64::from(start); LANES], &numbers, (-1.0, f64::INFINITY));
        }
        assert!(list.numbers().iter().copied().eq(0..800));
        assert_eq!((list.keep_nearest(9, f64::INFINITY), list.len()), (1.0, 16));
    }
}
