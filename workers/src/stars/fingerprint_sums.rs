//! Hashes of points and cells, and the sums of them that a certificate compares ([`crate::stars::check`]).

use std::collections::{BTreeMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::atomic::{AtomicU64, Ordering};

use septet_geometry::complex::INFINITE;
use septet_geometry::point::Point;
use septet_protocol::ids::Rank;

/// Order-free sums of a set of stars, by who else must hold the same.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sums {
    /// Pairs both at home, seen from the smallest vertex.
    pub(crate) from_smallest: (u128, u64),
    /// The same, seen from the other vertex.
    pub(crate) from_other: (u128, u64),
    /// Pairs with a vertex at home elsewhere.
    pub(crate) remote: BTreeMap<Rank, (u128, u64)>,
}

impl Sums {
    /// Adds one hash.
    pub(crate) fn count(entry: &mut (u128, u64), key: u128) {
        unite(entry, (key, 1));
    }

    /// Adds a sum of pairs with a vertex at home on a rank, or takes it away.
    pub(crate) fn join_remote(&mut self, (rank, sum): (Rank, (u128, u64)), add: bool) {
        if sum != (0, 0) {
            join(self.remote.entry(rank).or_default(), sum, add);
        }
    }
}

/// The sum of pairs with one other worker after another: those with the same one follow each other.
pub(crate) struct RemoteSums {
    rank: Rank,
    sum: (u128, u64),
    add: bool,
}

impl RemoteSums {
    /// Nothing yet; pairs are added to sums, or taken away.
    pub(crate) fn new(add: bool) -> Self {
        RemoteSums { rank: 0, sum: (0, 0), add }
    }

    /// Counts a pair with a vertex at home on a rank.
    #[inline]
    pub(crate) fn count(&mut self, sums: &mut Sums, rank: Rank, hash: u128) {
        if rank != self.rank {
            sums.join_remote((self.rank, std::mem::take(&mut self.sum)), self.add);
            self.rank = rank;
        }
        Sums::count(&mut self.sum, hash);
    }

    /// Joins what is left to the sums.
    pub(crate) fn finish(self, sums: &mut Sums) {
        sums.join_remote((self.rank, self.sum), self.add);
    }
}

/// For each home vertex some sums over the pairs it is the smallest vertex of, both at home: those seen from there
/// less those seen from the others, so zero if the stars agree. Of 64 bits: they tell where to look, and certify
/// nothing. A pair is in one of [`SHARES`] sums, by the hash of its cell.
pub(crate) struct ShortSums {
    sums: Vec<AtomicU64>,
    /// Does one core alone add to them? Then they are changed without locking.
    alone: bool,
}

/// Sums of each vertex.
pub(crate) const SHARES: usize = 4;

/// The sum that a cell is in, of those of its smallest vertex.
#[inline]
pub(crate) fn share_of(cell_hash: u128) -> usize {
    (cell_hash >> 64) as usize % SHARES
}

impl ShortSums {
    /// Zeros, for so many home vertices; `alone` if one core adds to them.
    pub(crate) fn new(owned_points: u32, alone: bool) -> Self {
        let sums = (0..SHARES * owned_points as usize).map(|_| AtomicU64::new(0)).collect();
        ShortSums { sums, alone }
    }

    #[inline]
    fn change(&self, sum: &AtomicU64, by: u64) {
        if self.alone {
            sum.store(sum.load(Ordering::Relaxed).wrapping_add(by), Ordering::Relaxed);
        } else {
            sum.fetch_add(by, Ordering::Relaxed);
        }
    }

    /// Adds what a smallest vertex sees.
    pub(crate) fn add(&self, smallest: u32, seen: [u64; SHARES]) {
        let first = SHARES * smallest as usize;
        for (sum, seen) in self.sums[first..first + SHARES].iter().zip(seen) {
            self.change(sum, seen);
        }
    }

    /// Takes away a pair that another vertex sees.
    #[inline]
    pub(crate) fn subtract(&self, smallest: u32, cell_hash: u128) {
        let sum = &self.sums[SHARES * smallest as usize + share_of(cell_hash)];
        self.change(sum, (cell_hash as u64).wrapping_neg());
    }

    /// Which sums of each home vertex are not zero.
    pub(crate) fn open(self) -> OpenShares {
        let sums: Vec<u64> = self.sums.into_iter().map(AtomicU64::into_inner).collect();
        let mask = |sums: &[u64]| sums.iter().rev().fold(0, |mask, &sum| mask << 1 | u8::from(sum != 0));
        let masks = sums.chunks_exact(SHARES).map(mask);
        OpenShares(masks.chain([0]).collect())
    }
}

/// A bit for each sum of each home vertex that is not zero; then none, for all others.
pub(crate) struct OpenShares(Vec<u8>);

impl OpenShares {
    /// Of a vertex, at home or not.
    #[inline]
    pub(crate) fn of(&self, vertex: u32) -> u8 {
        self.0[(vertex as usize).min(self.0.len() - 1)]
    }

    /// Does its smallest vertex differ on cells like this one?
    #[inline]
    pub(crate) fn holds(&self, smallest: u32, cell_hash: u128) -> bool {
        self.of(smallest) >> share_of(cell_hash) & 1 != 0
    }
}

/// A set of keys.
pub(crate) type KeySet = HashSet<u64, BuildHasherDefault<KeyHasher>>;

/// Hashes a key, which is a hash.
#[derive(Default)]
pub(crate) struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.0 = self.0.rotate_left(8) ^ u64::from(b);
        }
    }
    fn write_u64(&mut self, key: u64) {
        self.0 = key;
    }
}

/// Adds a sum.
pub(crate) fn unite(entry: &mut (u128, u64), other: (u128, u64)) {
    *entry = (entry.0.wrapping_add(other.0), entry.1.wrapping_add(other.1));
}

/// Adds a sum, or takes it away.
pub(crate) fn join(entry: &mut (u128, u64), other: (u128, u64), add: bool) {
    unite(entry, if add { other } else { (other.0.wrapping_neg(), other.1.wrapping_neg()) });
}

/// The hash of a point: id and coordinate bits.
pub(crate) fn point_hash<P: Point>(id: u64, x: P) -> u128 {
    let mut h = u128::from(id) | 1 << 64;
    for i in 0..P::DIM {
        h = mix(h ^ u128::from(x.coord(i).to_bits()) << (i * 29));
    }
    mix(h)
}

/// Hashes of points that were asked for last, by their local numbers.
pub(crate) struct RecentHashes(Vec<(u32, u128)>);

/// The most places, of 32 bytes each: half a MiB, for which most cores' caches have room.
const RECENT: usize = 1 << 14;

impl RecentHashes {
    /// None yet, of so many points.
    pub(crate) fn of_points(points: usize) -> Self {
        // Nothing has the number of what is at infinity.
        RecentHashes(vec![(INFINITE, 0); RECENT.min(points.next_power_of_two())])
    }

    /// The hash of a point, which `make` gives if it is not remembered.
    #[inline]
    pub(crate) fn hash(&mut self, v: u32, make: impl FnOnce() -> u128) -> u128 {
        let places = self.0.len();
        let place = &mut self.0[v as usize & (places - 1)];
        if place.0 != v {
            *place = (v, make());
        }
        place.1
    }
}

/// Mixes 128 bits (the multiplier is that of the 128-bit PCG family).
pub(crate) fn mix(h: u128) -> u128 {
    let h = (h ^ (h >> 67)).wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645);
    let h = (h ^ (h >> 59)).wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645);
    h ^ (h >> 64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recent_hashes_are_those_that_were_made() {
        assert_eq!([0, 1, 3, 2 * RECENT].map(|n| RecentHashes::of_points(n).0.len()), [1, 1, 4, RECENT]);
        let mut recent = RecentHashes::of_points(2 * RECENT);
        let mut made = 0;
        let places = RECENT as u32;
        for v in [0, 7, 0, places, 7, 0, places - 1, 2 * places + 7, 7, INFINITE - 1] {
            let hash = recent.hash(v, || {
                made += 1;
                u128::from(v) + 1
            });
            assert_eq!(hash, u128::from(v) + 1);
        }
        assert_eq!(made, 8);
    }

    #[test]
    fn a_share_is_open_where_one_side_saw_what_the_other_did_not() {
        shares_are_open_where_sides_differ(true);
        shares_are_open_where_sides_differ(false);
    }

    fn shares_are_open_where_sides_differ(alone: bool) {
        let short = ShortSums::new(3, alone);
        let cells: Vec<u128> = (0..40).map(|i| mix(i + 1)).collect();
        let mut seen = [0u64; SHARES];
        for &cell in &cells {
            seen[share_of(cell)] = seen[share_of(cell)].wrapping_add(cell as u64);
        }
        short.add(1, seen);
        for &cell in &cells[1..] {
            short.subtract(1, cell);
        }
        // The second's other vertex does not see the first cell; the third's sees one that it lacks itself.
        short.subtract(2, cells[5]);
        let open = short.open();
        let expected = [0, 1 << share_of(cells[0]), 1 << share_of(cells[5]), 0, 0];
        assert_eq!([0, 1, 2, 3, u32::MAX].map(|v| open.of(v)), expected);
        assert!(open.holds(1, cells[0]) && open.holds(2, cells[5]) && !open.holds(0, cells[0]));
        assert!((0..SHARES).all(|share| cells.iter().any(|&cell| share_of(cell) == share)));
    }
}
