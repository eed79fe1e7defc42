//! Hashes of points and cells, and the sums of them that a certificate compares ([`crate::check`]).

use std::collections::{BTreeMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

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

/// A set of keys.
pub(crate) type KeySet = HashSet<u128, BuildHasherDefault<KeyHasher>>;

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
    fn write_u128(&mut self, key: u128) {
        self.0 = key as u64;
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

/// Mixes 128 bits (the multiplier is that of the 128-bit PCG family).
pub(crate) fn mix(h: u128) -> u128 {
    let h = (h ^ (h >> 67)).wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645);
    let h = (h ^ (h >> 59)).wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645);
    h ^ (h >> 64)
}
