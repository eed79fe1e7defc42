//! Lists of neighbours of a point, and the selection of the nearest ones.
//!
//! **Statement.** The `k` nearest neighbours are those no farther than the `k`-th, ties included. So they do not
//! depend on the indices of tied points.
//!
//! The `k`-th squared distance is selected between a lower and an upper bound that converge. Each round counts the
//! distances up to a value between the bounds, eight in one step. The value is chosen such that `k` distances would lie
//! below it if they were evenly spread (interpolation search, Peterson 1957). After a few rounds, quickselect (Hoare
//! 1961) finds the `k`-th among the distances between the bounds. Without an instruction set that compares eight
//! numbers in one step, quickselect runs on all distances.
//!
//! **Work.** O(1) for each point added or tested; linear for the selection. The list keeps the order in which points
//! were added, which may be the order of blocks or of incoming replies. Callers sort the list or use it as a set.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

use crate::coordinate_arrays::LANES;
use crate::simd::{Interval, Masks, NamedLanes, NamedLanesMut, larger, widest};

/// A neighbour: its squared distance, and its position in the caller's table.
pub type Neighbour = (f64, u32);

/// A list of neighbours, in reused storage.
#[derive(Clone, Debug, Default)]
pub struct NeighbourList {
    masks: Masks,
    /// Squared distances and positions. Entries behind the first `len` are unused.
    distances2: Vec<f64>,
    positions: Vec<u32>,
    len: usize,
    /// Scratch: the distances between the bounds as bit patterns, which have the order of the distances.
    between: Vec<u64>,
}

/// Largest number of rounds that narrow the bounds.
const ROUNDS: u32 = 6;
/// Rounds end when at most this number of distances lies between the bounds.
const FEW: usize = 2;

impl NeighbourList {
    /// Removes all neighbours.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Returns the number of neighbours.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns `true` if there are no neighbours.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns the squared distances of the neighbours, in the order in which they were added.
    pub fn distances2(&self) -> &[f64] {
        &self.distances2[..self.len]
    }

    /// Positions of the neighbours, in the same order.
    pub fn positions(&self) -> &[u32] {
        &self.positions[..self.len]
    }

    /// Iterates over the neighbours, in the same order.
    pub fn iter(&self) -> impl Iterator<Item = Neighbour> {
        self.distances2().iter().copied().zip(self.positions().iter().copied())
    }

    /// Makes room for `more` further neighbours.
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
        self.positions.resize(room, 0);
    }

    /// Adds one neighbour.
    #[inline]
    pub fn push(&mut self, (distance2, position): Neighbour) {
        self.make_room(1);
        (self.distances2[self.len], self.positions[self.len]) = (distance2, position);
        self.len += 1;
    }

    /// Adds neighbours by their positions; `distance2` computes their squared distances.
    #[inline]
    pub fn extend(&mut self, positions: &[u32], distance2: impl Fn(u32) -> f64) {
        self.make_room(positions.len());
        let added = self.len..self.len + positions.len();
        self.positions[added.clone()].copy_from_slice(positions);
        for (d2, &number) in self.distances2[added].iter_mut().zip(positions) {
            *d2 = distance2(number);
        }
        self.len += positions.len();
    }

    /// Adds, from eight points, the points whose squared distances are wanted.
    #[inline(always)]
    pub(crate) fn take_lanes(
        &mut self,
        distances2: &[f64; LANES],
        positions: &[u32; LANES],
        wanted2: Interval,
    ) {
        self.make_room(LANES);
        let room =
            (self.distances2[self.len..].first_chunk_mut(), self.positions[self.len..].first_chunk_mut());
        if let (Some(to_distances2), Some(to_positions)) = room {
            let from = NamedLanes { numbers: distances2, names: positions };
            let to = NamedLanesMut { numbers: to_distances2, names: to_positions };
            self.len += self.masks.pack(from, wanted2, to);
        }
    }

    /// Keeps the neighbours no farther than the `k`-th nearest, ties included, and no farther than `limit2`. Returns
    /// the `k`-th squared distance, or infinity if there are fewer than `k` or `k` is 0.
    pub fn keep_nearest(&mut self, k: usize, limit2: f64) -> f64 {
        if self.distances2().iter().fold(false, |any, &d2| any | (d2 > limit2)) {
            self.keep(limit2);
        }
        self.keep_kth(k)
    }

    /// Keeps the neighbours no farther than the `k`-th nearest, and returns its squared distance. If there are fewer
    /// than `k`, keeps all and returns infinity.
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

    /// Returns the `k`-th smallest squared distance.
    fn kth(&mut self, k: usize) -> f64 {
        self.make_room(LANES);
        // Comparisons with NaN are false, so the padding is never counted.
        self.distances2[self.len..self.len + LANES].fill(f64::NAN);
        let (all, _) = self.distances2[..self.len.next_multiple_of(LANES)].as_chunks::<LANES>();
        let (len, between) = (self.len, &mut self.between);
        let rounds = if self.masks.can_count() { ROUNDS } else { 0 };
        widest(
            #[inline(always)]
            || kth_between(all, len, k, rounds, between),
        )
    }

    /// Keeps the neighbours no farther than the limit, in their order.
    fn keep(&mut self, limit2: f64) {
        self.make_room(LANES);
        self.distances2[self.len..self.len + LANES].fill(f64::NAN);
        let mut kept = 0;
        widest(
            #[inline(always)]
            || {
                for at in (0..self.len).step_by(LANES) {
                    let from = (self.distances2[at..].first_chunk(), self.positions[at..].first_chunk());
                    let (Some(&distances2), Some(&positions)) = from else { break };
                    let to =
                        (self.distances2[kept..].first_chunk_mut(), self.positions[kept..].first_chunk_mut());
                    let (Some(to_distances2), Some(to_positions)) = to else { break };
                    let from = NamedLanes { numbers: &distances2, names: &positions };
                    let to = NamedLanesMut { numbers: to_distances2, names: to_positions };
                    let wanted2 = Interval { above: f64::NEG_INFINITY, limit: limit2 };
                    kept += self.masks.pack(from, wanted2, to);
                }
            },
        );
        self.len = kept;
    }
}

/// Returns the `k`-th smallest of `len` nonnegative numbers in blocks of eight. NaN fills the last block.
#[inline(always)]
fn kth_between(all: &[[f64; LANES]], len: usize, k: usize, rounds: u32, between: &mut Vec<u64>) -> f64 {
    let most = largest(all, f64::INFINITY);
    // `below` numbers are at most `low`; `within >= k` are at most `high`. No number is negative.
    let (mut low, mut below, mut high, mut within) = (-1.0, 0, most, len);
    // The first value lies between the exact values for points that are evenly spread in the plane and in space.
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
    // At least `high` is between the bounds. If the input has NaN, there may be fewer than `k - below`.
    let last = between.len() - 1;
    f64::from_bits(*between.select_nth_unstable((k - below - 1).min(last)).1)
}

/// Counts the values that are at most `limit`.
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

/// Returns the largest value that is at most `limit`.
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

    /// Returns a squared distance that is not monotone in `i` and has ties.
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
        // All cases share one list, whose storage was longer before.
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
                    // A second selection changes nothing.
                    assert_eq!(list.keep_nearest(k, limit2), kth, "{count} {k} {limit2}");
                    assert_eq!(list.iter().collect::<Vec<_>>(), within, "{count} {k} {limit2}");
                }
            }
        }
    }

    /// The values have all magnitudes, are evenly spread or not, and include ties, zeros, infinities and NaN.
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

    /// With NaN input the result is unspecified; the search still terminates.
    #[test]
    fn selection_terminates_with_nan() {
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
            let positions = std::array::from_fn(|lane| start + lane as u32);
            list.take_lanes(&distances2, &positions, Interval { above: 0.0, limit: 3.0 });
        }
        assert_eq!(list.positions(), [9, 10, 13, 15, 17, 20, 23, 25, 27]);
        list.clear();
        assert!(list.is_empty() && list.positions().is_empty() && list.distances2().is_empty());
        // There are more points than the list has room for.
        for start in 0..100 {
            let positions = std::array::from_fn(|lane| start as u32 * 8 + lane as u32);
            list.take_lanes(
                &[f64::from(start); LANES],
                &positions,
                Interval { above: -1.0, limit: f64::INFINITY },
            );
        }
        assert!(list.positions().iter().copied().eq(0..800));
        assert_eq!((list.keep_nearest(9, f64::INFINITY), list.len()), (1.0, 16));
    }
}
