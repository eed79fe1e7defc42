//! What was found near a point, and the nearest of it.
//!
//! **Statement.** The `k` nearest are those no farther than the `k`-th, ties included: then they do not depend on how ties
//! are numbered. The `k`-th is selected (Hoare 1961) among the bits of the squared distances, which are in the order of
//! the distances.
//!
//! **Work.** O(1) for each point found or looked at, linear for the nearest. Those that are kept stand in the order in which
//! they were found, which is that of blocks of points, or in which answers came: whoever uses them sorts them, or does not
//! ask for an order.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

use crate::columns::LANES;

/// A point found: squared distance, and position in the caller's table.
pub type Found = (f64, u32);

/// Points found, in reused storage.
#[derive(Clone, Debug, Default)]
pub struct FoundList {
    /// Those found, and room behind them.
    room: Vec<Found>,
    len: usize,
    keys: Vec<u64>,
}

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

    /// All of them, in the order in which they were found.
    pub fn as_slice(&self) -> &[Found] {
        &self.room[..self.len]
    }

    /// Room for so many more.
    #[inline(always)]
    fn make_room(&mut self, more: usize) {
        if self.room.len() - self.len < more {
            self.grow(more);
        }
    }

    #[cold]
    fn grow(&mut self, more: usize) {
        self.room.resize((self.len + more).max(8 * LANES).next_power_of_two(), (0.0, 0));
    }

    /// Adds a point.
    #[inline]
    pub fn push(&mut self, found: Found) {
        self.make_room(1);
        self.room[self.len] = found;
        self.len += 1;
    }

    /// Adds points.
    pub fn extend(&mut self, found: impl IntoIterator<Item = Found>) {
        let found = found.into_iter();
        self.make_room(found.size_hint().0);
        found.for_each(|found| self.push(found));
    }

    /// Adds those of eight points that are wanted.
    #[inline(always)]
    pub(crate) fn take_lanes(
        &mut self,
        distances2: &[f64; LANES],
        number: impl Fn(usize) -> u32,
        is_wanted: impl Fn(f64) -> bool,
    ) {
        self.make_room(LANES);
        let room = &mut self.room[self.len..self.len + LANES];
        let mut count = 0;
        // Without a branch: each is written, and stays if it is wanted.
        for (lane, &d2) in distances2.iter().enumerate() {
            room[count & (LANES - 1)] = (d2, number(lane));
            count += usize::from(is_wanted(d2));
        }
        self.len += count;
    }

    /// Keeps those no farther than the `k`-th nearest, ties included, and no farther than `limit2`. Returns the `k`-th
    /// squared distance, or infinity if there are fewer than `k`, or `k` is 0.
    pub fn keep_nearest(&mut self, k: usize, limit2: f64) -> f64 {
        let found = self.as_slice();
        if found.iter().fold(false, |any, found| any | (found.0 > limit2)) {
            self.keep(limit2);
        }
        if self.len == k && k > 0 {
            let farther = |most, found: &Found| if found.0 > most { found.0 } else { most };
            return self.as_slice().iter().fold(0.0, farther);
        }
        self.keep_kth(k)
    }

    /// Keeps those no farther than the `k`-th nearest, and returns its squared distance; all and infinity if there are
    /// fewer.
    pub(crate) fn keep_kth(&mut self, k: usize) -> f64 {
        if k == 0 || self.len < k {
            return f64::INFINITY;
        }
        self.keys.clear();
        self.keys.extend(self.room[..self.len].iter().map(|found| found.0.to_bits()));
        let kth = f64::from_bits(*self.keys.select_nth_unstable(k - 1).1);
        self.keep(kth);
        kth
    }

    /// Keeps those no farther than the limit, in their order.
    fn keep(&mut self, limit2: f64) {
        let found = &mut self.room[..self.len];
        let mut kept = 0;
        for at in 0..found.len() {
            let this = found[at];
            found[kept] = this;
            kept += usize::from(this.0 <= limit2);
        }
        self.len = kept;
    }
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
                    assert_eq!(list.as_slice(), within, "{count} {k} {limit2}");
                    // The nearest of the nearest are the same.
                    assert_eq!(list.keep_nearest(k, limit2), kth, "{count} {k} {limit2}");
                    assert_eq!(list.as_slice(), within, "{count} {k} {limit2}");
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
            list.take_lanes(&distances2, |lane| start + lane as u32, |d2| d2 > 0.0 && d2 <= 3.0);
        }
        let numbers: Vec<u32> = list.as_slice().iter().map(|found| found.1).collect();
        assert_eq!(numbers, [9, 10, 13, 15, 17, 20, 23, 25, 27]);
        list.clear();
        assert!(list.is_empty() && list.as_slice().is_empty());
        // More than there was room for.
        for start in 0..100 {
            list.take_lanes(&[f64::from(start); LANES], |lane| start as u32 * 8 + lane as u32, |_| true);
        }
        assert!(list.as_slice().iter().map(|found| found.1).eq(0..800));
        assert_eq!((list.keep_nearest(9, f64::INFINITY), list.len()), (1.0, 16));
    }
}
