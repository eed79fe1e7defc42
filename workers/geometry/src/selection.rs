//! What was found near a point, and the nearest of it.
//!
//! **Statement.** The `k` nearest are those no farther than the `k`-th, ties included: then they do not depend on how ties
//! are numbered. The `k`-th is selected between bounds that are drawn together: the numbers up to a bound are counted,
//! eight in one step, and the next bound is the one between that would split them right if they were spread evenly (the
//! search by interpolation, Peterson 1957). After a few rounds it is selected as such (Hoare 1961) among those that are left
//! between them; where nothing compares eight numbers in one step, among all.
//!
//! **Work.** O(1) for each point found or looked at, linear for the nearest. Those that are kept stand in the order in which
//! they were found, which is that of blocks of points, or in which answers came: whoever uses them sorts them, or does not
//! ask for an order.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

use crate::coordinate_arrays::LANES;
use crate::simd::{Masks, larger, widest};

/// A point found: squared distance, and position in the caller's table.
pub type Neighbour = (f64, u32);

/// Points found, in reused storage.
#[derive(Clone, Debug, Default)]
pub struct NeighbourList {
    masks: Masks,
    /// Squared distances and positions of those found, and room behind them.
    distances2: Vec<f64>,
    numbers: Vec<u32>,
    len: usize,
    /// Those between the bounds, by their bits, which are in the order of the numbers.
    between: Vec<u64>,
}

/// How often the bounds are drawn together at most, and of how many between them it is selected at once.
const ROUNDS: u32 = 6;
const FEW: usize = 2;

impl NeighbourList {
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
    pub fn iter(&self) -> impl Iterator<Item = Neighbour> {
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
    pub fn push(&mut self, (distance2, number): Neighbour) {
        self.make_room(1);
        (self.distances2[self.len], self.numbers[self.len]) = (distance2, number);
        self.len += 1;
    }

    /// Adds points by their positions, with what tells their squared distances.
    #[inline]
    pub fn extend(&mut self, numbers: &[u32], distance2: impl Fn(u32) -> f64) {
        self.make_room(numbers.len());
        let added = self.len..self.len + numbers.len();
        self.numbers[added.clone()].copy_from_slice(numbers);
        for (d2, &number) in self.distances2[added].iter_mut().zip(numbers) {
            *d2 = distance2(number);
        }
        self.len += numbers.len();
    }

    /// Adds those of eight points that are farther than the first limit and no farther than the second.
    #[inline(always)]
    pub(crate) fn take_lanes(
        &mut self,
        distances2: &[f64; LANES],
        numbers: &[u32; LANES],
        limits2: (f64, f64),
    ) {
        self.make_room(LANES);
        let to = (self.distances2[self.len..].first_chunk_mut(), self.numbers[self.len..].first_chunk_mut());
        if let (Some(to_distances2), Some(to_numbers)) = to {
            self.len += self.masks.pack((distances2, numbers), limits2, (to_distances2, to_numbers));
        }
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
        let rounds = if self.masks.can_count() { ROUNDS } else { 0 };
        widest(
            #[inline(always)]
            || kth_between(all, len, k, rounds, between),
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
                    let from = (self.distances2[at..].first_chunk(), self.numbers[at..].first_chunk());
                    let (Some(&distances2), Some(&numbers)) = from else { break };
                    let to =
                        (self.distances2[kept..].first_chunk_mut(), self.numbers[kept..].first_chunk_mut());
                    let (Some(to_distances2), Some(to_numbers)) = to else { break };
                    let limits = (f64::NEG_INFINITY, limit2);
                    kept += self.masks.pack((&distances2, &numbers), limits, (to_distances2, to_numbers));
                }
            },
        );
        self.len = kept;
    }
}

/// The `k`-th smallest of `len` numbers of at least 0 in blocks of eight, of which the last is filled up with what is no
/// number.
#[inline(always)]
fn kth_between(all: &[[f64; LANES]], len: usize, k: usize, rounds: u32, between: &mut Vec<u64>) -> f64 {
    let most = largest(all, f64::INFINITY);
    // `below` are up to `low`, at least k up to `high`. None are below 0.
    let (mut low, mut below, mut high, mut within) = (-1.0, 0, most, len);
    // Between what points spread evenly in the plane and in space would ask for.
    let part = k as f64 / len as f64;
    let mut middle = most * part * (1.5 - 0.5 * part);
    for _ in 0..rounds {
        if within == k || within - below <= FEW || !(low < middle && middle < high) {
            break;
        }
        let count = count_up_to(all, middle);
        if count < k {
            (low, below) = (middle, count);
        } else {
            (high, within) = (middle, count);
        }
        let from = larger(low, 0.0);
        middle = from + (high - from) * ((k - below) as f64 - 0.5) / (within - below) as f64;
    }
    if within == k {
        return largest(all, high);
    }
    between.clear();
    if below == 0 && within == len {
        between.extend(all.as_flattened()[..len].iter().map(|d2| d2.to_bits()));
    } else {
        let is_between = |d2: &&f64| **d2 > low && **d2 <= high;
        between.extend(all.as_flattened().iter().filter(is_between).map(|d2| d2.to_bits()));
    }
    // At least one is, for `high` is; there are too few if some are no numbers.
    let last = between.len() - 1;
    f64::from_bits(*between.select_nth_unstable((k - below - 1).min(last)).1)
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

    /// A squared distance, in no order, with ties.
    fn distance2(i: u32) -> f64 {
        f64::from(i * 7 % 13)
    }

    fn some(count: u32) -> Vec<Neighbour> {
        (0..count).map(|i| (distance2(i), i)).collect()
    }

    fn fill(list: &mut NeighbourList, count: u32) {
        list.extend(&(0..count).collect::<Vec<_>>(), distance2);
    }

    #[test]
    fn the_nearest_are_those_of_a_sorted_list() {
        for masks in Masks::both() {
            the_nearest_are_those_of_a_sorted_list_with(masks);
        }
    }

    fn the_nearest_are_those_of_a_sorted_list_with(masks: Masks) {
        // One list for all, in storage that was longer.
        let mut list = NeighbourList { masks, ..NeighbourList::default() };
        fill(&mut list, 200);
        for count in 0..40 {
            for k in 0..45 {
                for limit2 in [0.0, 3.0, 12.0, f64::INFINITY] {
                    list.clear();
                    fill(&mut list, count);
                    let kth = list.keep_nearest(k, limit2);
                    let mut within: Vec<Neighbour> =
                        some(count).into_iter().filter(|f| f.0 <= limit2).collect();
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

    /// Sizes of all orders, evenly spread or not, with ties, zeros, infinities and what is no number.
    #[test]
    fn the_kth_is_that_of_a_sorted_list() {
        let mut draw = crate::hash::Draw::new(1);
        let scales = [1e-320, 1e-300, 1e-6, 1.0, 1e300];
        let spreads: [fn(f64) -> f64; 6] = [
            |x| x,
            |x| x * x * x,
            |x| 1.0 - x * 1e-12,
            |x| (x * 4.0).floor(),
            |x| 10f64.powf(x * 300.0 - 300.0),
            |x| if x < 0.3 { 0.0 } else { 1.0 / (x - 0.3 + 1e-3) },
        ];
        let mut list = NeighbourList::default();
        for len in [1usize, 2, 7, 8, 9, 48, 63, 64, 65, 100, 208, 300] {
            for (scale, spread) in scales.into_iter().flat_map(|scale| spreads.map(|spread| (scale, spread)))
            {
                for endless in [0, 1, len / 2] {
                    let each = |i| if i < endless { f64::INFINITY } else { spread(draw.unit()) * scale };
                    let distances2: Vec<f64> = (0..len).map(each).collect();
                    let mut sorted = distances2.clone();
                    sorted.sort_by(f64::total_cmp);
                    let mut blocks = distances2.clone();
                    blocks.resize(len.next_multiple_of(LANES), f64::NAN);
                    let blocks = blocks.as_chunks::<LANES>().0;
                    for k in [1, 2, 8, 48, len / 2, len - 1, len].into_iter().filter(|&k| 0 < k && k <= len) {
                        list.clear();
                        list.extend(&(0..len as u32).collect::<Vec<_>>(), |i| distances2[i as usize]);
                        assert_eq!(list.keep_kth(k), sorted[k - 1], "{len} {k} {distances2:?}");
                        for rounds in [0, 1, ROUNDS] {
                            let kth = kth_between(blocks, len, k, rounds, &mut Vec::new());
                            assert_eq!(kth, sorted[k - 1], "{len} {k} {rounds} {distances2:?}");
                        }
                    }
                }
            }
        }
    }

    /// Of what is no number nothing is known, but that it ends.
    #[test]
    fn what_is_no_number_does_no_harm() {
        let few = [1.0, 1.1, 3.0, f64::NAN, f64::NAN, f64::NAN, f64::NAN, f64::NAN];
        for k in 1..=8 {
            for rounds in [0, 1, ROUNDS] {
                let kth = kth_between(&[few], 8, k, rounds, &mut Vec::new());
                assert!(kth.is_nan() || few.contains(&kth), "{kth}");
            }
        }
        assert!(kth_between(&[[f64::NAN; LANES]], 3, 2, ROUNDS, &mut Vec::new()).is_nan());
    }

    #[test]
    fn lanes_are_taken_in_their_order() {
        for masks in Masks::both() {
            lanes_are_taken_in_their_order_with(NeighbourList { masks, ..NeighbourList::default() });
        }
    }

    fn lanes_are_taken_in_their_order_with(mut list: NeighbourList) {
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
