//! Hashes of points and cells, and the sums of them that a certificate compares ([`crate::stars::check`]).

use std::collections::{BTreeMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::atomic::{AtomicU64, Ordering};

use septet_geometry::hash::hash_of_site;
use septet_geometry::point::Point;
use septet_protocol::ids::Rank;

/// The sum of the cell hashes of some pairs, modulo `2^128`, and the number of pairs, modulo `2^64`. A *pair* is a cell with
/// its smallest vertex and another vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PairSum {
    hashes: u128,
    pairs: u64,
}

impl PairSum {
    /// Creates a sum from its parts.
    pub(super) fn new(hashes: u128, pairs: u64) -> Self {
        PairSum { hashes, pairs }
    }

    /// Returns the sum of the hashes.
    pub(super) fn hashes(self) -> u128 {
        self.hashes
    }

    /// Returns the number of pairs.
    pub(super) fn pairs(self) -> u64 {
        self.pairs
    }

    /// Adds one pair.
    #[inline]
    pub(super) fn add_pair(&mut self, hash: u128) {
        self.add(PairSum { hashes: hash, pairs: 1 });
    }

    #[inline]
    fn add(&mut self, other: PairSum) {
        self.hashes = self.hashes.wrapping_add(other.hashes);
        self.pairs = self.pairs.wrapping_add(other.pairs);
    }

    fn subtract(&mut self, other: PairSum) {
        self.hashes = self.hashes.wrapping_sub(other.hashes);
        self.pairs = self.pairs.wrapping_sub(other.pairs);
    }

    fn is_zero(self) -> bool {
        self == PairSum::default()
    }
}

/// Order-independent sums of the pairs of some stars.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sums {
    /// Pairs of two owned vertices, in the star of the smallest vertex.
    from_smallest: PairSum,
    /// Pairs of two owned vertices, in the star of the other vertex.
    from_other: PairSum,
    /// Pairs with a ghost, by the rank that owns it.
    remote: BTreeMap<Rank, PairSum>,
}

impl Sums {
    /// Returns `true` if the stars of the owned points agree on all pairs of two owned vertices.
    pub(super) fn agree_within(&self) -> bool {
        self.from_smallest == self.from_other
    }

    /// Returns the sums of pairs with a ghost, by the rank that owns it.
    pub(super) fn remote(&self) -> &BTreeMap<Rank, PairSum> {
        &self.remote
    }

    /// Removes ranks whose sums are zero.
    pub(super) fn drop_zeros(&mut self) {
        self.remote.retain(|_, sum| !sum.is_zero());
    }

    /// Adds pairs of two owned vertices.
    pub(super) fn add_owned(&mut self, from_smallest: PairSum, from_other: PairSum) {
        self.from_smallest.add(from_smallest);
        self.from_other.add(from_other);
    }

    /// Adds pairs with a ghost that `rank` owns.
    pub(super) fn add_remote(&mut self, rank: Rank, sum: PairSum) {
        if !sum.is_zero() {
            self.remote.entry(rank).or_default().add(sum);
        }
    }

    /// Adds other sums.
    pub(super) fn add(&mut self, other: Sums) {
        self.add_owned(other.from_smallest, other.from_other);
        for (rank, sum) in other.remote {
            self.add_remote(rank, sum);
        }
    }

    /// Subtracts other sums.
    pub(super) fn subtract(&mut self, other: Sums) {
        self.from_smallest.subtract(other.from_smallest);
        self.from_other.subtract(other.from_other);
        for (rank, sum) in other.remote {
            self.remote.entry(rank).or_default().subtract(sum);
        }
    }
}

/// Adds pairs with ghosts to [`Sums`]. Consecutive pairs often have the same owner, so they are summed before the map is
/// changed.
#[derive(Default)]
pub(super) struct RemoteSums {
    rank: Rank,
    sum: PairSum,
}

impl RemoteSums {
    /// Adds a pair with a ghost that `rank` owns.
    #[inline]
    pub(super) fn add_pair(&mut self, sums: &mut Sums, rank: Rank, hash: u128) {
        if rank != self.rank {
            sums.add_remote(self.rank, std::mem::take(&mut self.sum));
            self.rank = rank;
        }
        self.sum.add_pair(hash);
    }

    /// Adds the pairs that are not in `sums` yet.
    pub(super) fn finish(self, sums: &mut Sums) {
        sums.add_remote(self.rank, self.sum);
    }
}

/// For each owned vertex `v`, the sums over the pairs whose smallest vertex is `v` and whose other vertex is owned.
/// Pairs in the star of `v` count positively, and pairs in the star of the other vertex count negatively. All sums
/// are zero if the stars agree.
///
/// The hash of the cell assigns each pair to one of [`BUCKETS`] sums. They have 64 bits: they locate disagreements and certify
/// nothing.
pub(crate) struct VertexSums {
    sums: Vec<AtomicU64>,
    /// Whether one thread alone adds to the sums. It then needs no atomic additions.
    single_thread: bool,
}

/// Number of sums per vertex.
pub(super) const BUCKETS: usize = 4;

/// Returns the index of the sum to which a cell belongs.
#[inline]
pub(super) fn bucket_of(cell_hash: u128) -> usize {
    (cell_hash >> 64) as usize % BUCKETS
}

impl VertexSums {
    /// Creates zero sums for all owned points.
    pub(super) fn new(owned: u32, single_thread: bool) -> Self {
        let sums = (0..BUCKETS * owned as usize).map(|_| AtomicU64::new(0)).collect();
        VertexSums { sums, single_thread }
    }

    #[inline]
    fn add_to(&self, sum: &AtomicU64, term: u64) {
        if self.single_thread {
            sum.store(sum.load(Ordering::Relaxed).wrapping_add(term), Ordering::Relaxed);
        } else {
            sum.fetch_add(term, Ordering::Relaxed);
        }
    }

    /// Adds the sums of the pairs in the star of their smallest vertex.
    pub(super) fn add(&self, smallest: u32, terms: [u64; BUCKETS]) {
        let first = BUCKETS * smallest as usize;
        for (sum, term) in self.sums[first..first + BUCKETS].iter().zip(terms) {
            self.add_to(sum, term);
        }
    }

    /// Subtracts a pair that the star of its other vertex contains.
    #[inline]
    pub(super) fn subtract(&self, smallest: u32, cell_hash: u128) {
        let sum = &self.sums[BUCKETS * smallest as usize + bucket_of(cell_hash)];
        self.add_to(sum, (cell_hash as u64).wrapping_neg());
    }

    /// Returns the sums that are not zero.
    pub(super) fn into_differing(self) -> DifferingBuckets {
        let sums: Vec<u64> = self.sums.into_iter().map(AtomicU64::into_inner).collect();
        let mask = |sums: &[u64]| sums.iter().rev().fold(0, |mask, &sum| mask << 1 | u8::from(sum != 0));
        let masks = sums.chunks_exact(BUCKETS).map(mask);
        DifferingBuckets(masks.chain([0]).collect())
    }
}

/// For each owned vertex, a bit for each of its sums that is not zero. The last entry, 0, represents all other vertices.
pub(super) struct DifferingBuckets(Vec<u8>);

impl DifferingBuckets {
    /// Returns the bits of a vertex, owned or not.
    #[inline]
    pub(super) fn of(&self, vertex: u32) -> u8 {
        self.0[(vertex as usize).min(self.0.len() - 1)]
    }

    /// Returns `true` if the sum to which the cell belongs is not zero.
    #[inline]
    pub(super) fn contain(&self, smallest: u32, cell_hash: u128) -> bool {
        self.of(smallest) >> bucket_of(cell_hash) & 1 != 0
    }
}

/// A set of keys of pairs.
pub(super) type KeySet = HashSet<u64, BuildHasherDefault<KeyHasher>>;

/// Returns a key as its own hash, because keys are hashes already.
#[derive(Default)]
pub(super) struct KeyHasher(u64);

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

/// Returns the hash of a point's id and coordinate bits, and those of its weight if it has one.
pub(super) fn point_hash<P: Point>(id: u64, x: P) -> u128 {
    let mut h = u128::from(id) | 1 << 64;
    for i in 0..P::DIM {
        h = mix(h ^ u128::from(x.coord(i).to_bits()).rotate_left(i as u32 * 29));
    }
    if P::IS_WEIGHTED {
        h = mix(h ^ u128::from(hash_of_site(x)));
    }
    mix(h)
}

/// Mixes 128 bits. The multiplier comes from the 128-bit PCG generators.
pub(super) fn mix(h: u128) -> u128 {
    let h = (h ^ (h >> 67)).wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645);
    let h = (h ^ (h >> 59)).wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645);
    h ^ (h >> 64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_differs_if_only_one_of_two_stars_has_a_cell() {
        sums_differ_if_only_one_star_has_a_cell(true);
        sums_differ_if_only_one_star_has_a_cell(false);
    }

    fn sums_differ_if_only_one_star_has_a_cell(single_thread: bool) {
        let sums = VertexSums::new(3, single_thread);
        let cells: Vec<u128> = (0..40).map(|i| mix(i + 1)).collect();
        let mut terms = [0u64; BUCKETS];
        for &cell in &cells {
            terms[bucket_of(cell)] = terms[bucket_of(cell)].wrapping_add(cell as u64);
        }
        sums.add(1, terms);
        for &cell in &cells[1..] {
            sums.subtract(1, cell);
        }
        // The other vertex of vertex 1 lacks the first cell. Vertex 2 lacks a cell that its other vertex has.
        sums.subtract(2, cells[5]);
        let differing = sums.into_differing();
        let expected = [0, 1 << bucket_of(cells[0]), 1 << bucket_of(cells[5]), 0, 0];
        assert_eq!([0, 1, 2, 3, u32::MAX].map(|v| differing.of(v)), expected);
        assert!(differing.contain(1, cells[0]) && differing.contain(2, cells[5]));
        assert!(!differing.contain(0, cells[0]));
        assert!((0..BUCKETS).all(|bucket| cells.iter().any(|&cell| bucket_of(cell) == bucket)));
    }

    #[test]
    fn subtraction_undoes_addition() {
        let mut sums = Sums::default();
        let (mut few, mut remote) = (Sums::default(), RemoteSums::default());
        for (rank, hash) in [(2, 5), (2, u128::MAX), (3, 7), (2, 9)] {
            remote.add_pair(&mut few, rank, hash);
        }
        remote.finish(&mut few);
        few.add_owned(PairSum::new(u128::MAX - 1, 2), PairSum::new(4, 1));
        assert_eq!(few.remote()[&2], PairSum::new(13, 3));
        sums.add(few.clone());
        sums.add(few.clone());
        sums.subtract(few.clone());
        assert_eq!(sums, few);
        sums.subtract(few);
        sums.drop_zeros();
        assert_eq!(sums, Sums::default());
        assert!(sums.agree_within());
    }
}
