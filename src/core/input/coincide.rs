//! Coincident points.
//!
//! **Statement.** Points are coincident iff their coordinates are equal. Equal coordinates have equal hashes. The leading
//! bits of its hash assign a point to a bin. A table of bits finds the points of a bin whose remaining hash bits may be
//! equal, and only these are sorted and compared.
//!
//! **Work and depth.** Two vector steps over all points, one by blocks and one by bins, on all cores. The tables of a bin
//! fit into the caches of a core, and cores share no table. Without coincidences, a few percent of the points are sorted.

use rayon::prelude::*;

use septet_geometry::point::{Point, lex_cmp};
use septet_workers::view::shown_hash;

/// Number of points that are assigned to bins together.
const BLOCK: usize = 1 << 15;

/// Approximate number of points in a bin.
const BIN: usize = 1 << 14;
/// Largest number of bins. A block has more points than this.
const MOST_BINS: usize = 1 << 12;

/// Number of bits per point in the table of a bin.
const BITS: usize = 16;

/// The last 32 bits of a point's hash, and the index of the point.
type Key = (u32, u32);

/// Points by bins: the end of each bin, and the keys bin by bin.
struct Binned {
    ends: Vec<u32>,
    keys: Vec<Key>,
}

impl Binned {
    /// Assigns points to `1 << bits` bins. The first point has the index `first`.
    fn of<P: Point>(points: &[P], first: u32, bits: u32) -> Self {
        let hashes: Vec<u64> = points.iter().map(|p| shown_hash(*p)).collect();
        // Two shifts, because a shift by 64 bits overflows.
        let bin = |hash: u64| (hash >> 32 >> (32 - bits)) as usize;
        let mut ends = vec![0u32; (1 << bits) + 1];
        for &hash in &hashes {
            ends[bin(hash) + 1] += 1;
        }
        for at in 1..ends.len() {
            ends[at] += ends[at - 1];
        }
        let mut keys = vec![(0, 0); points.len()];
        for (&hash, number) in hashes.iter().zip(first..) {
            let next = &mut ends[bin(hash)];
            keys[*next as usize] = (hash as u32, number);
            *next += 1;
        }
        ends.pop();
        Binned { ends, keys }
    }

    fn bin(&self, at: usize) -> &[Key] {
        let start = if at == 0 { 0 } else { self.ends[at - 1] };
        &self.keys[start as usize..self.ends[at] as usize]
    }
}

/// A set of hashes as a table of bits. Different hashes may share a bit.
struct Bits(Vec<u64>);

impl Bits {
    /// Adds a hash. Returns `true` if its bit was already set.
    #[inline]
    fn add(&mut self, number: u32) -> bool {
        let place = number as usize & (64 * self.0.len() - 1);
        let (word, bit) = (&mut self.0[place / 64], 1 << (place % 64));
        let was = *word & bit != 0;
        *word |= bit;
        was
    }

    #[inline]
    fn has(&self, number: u32) -> bool {
        let place = number as usize & (64 * self.0.len() - 1);
        self.0[place / 64] >> (place % 64) & 1 == 1
    }
}

/// Returns all coincident points in order, each with the first point that has the same coordinates.
pub(crate) fn coincidences<P: Point>(points: &[P]) -> Vec<(u32, u32)> {
    by_bins(points, (points.len() / BIN).next_power_of_two().min(MOST_BINS).ilog2())
}

/// Finds coincident points as [`coincidences`] does, with `1 << bits` bins.
fn by_bins<P: Point>(points: &[P], bits: u32) -> Vec<(u32, u32)> {
    let blocks: Vec<Binned> = points
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, points)| Binned::of(points, (block * BLOCK) as u32, bits))
        .collect();
    let of_bin = |bin: usize| in_bin(points, &blocks.iter().map(|b| b.bin(bin)).collect::<Vec<_>>());
    let mut found: Vec<(u32, u32)> = (0..1 << bits).into_par_iter().flat_map_iter(of_bin).collect();
    found.par_sort_unstable();
    found
}

/// Returns the coincident points of one bin, which is given in parts.
fn in_bin<P: Point>(points: &[P], parts: &[&[Key]]) -> Vec<(u32, u32)> {
    let keys = || parts.iter().copied().flatten();
    let words = (parts.iter().map(|part| part.len()).sum::<usize>() * BITS / 64).next_power_of_two();
    let (mut met, mut again) = (Bits(vec![0; words]), Bits(vec![0; words]));
    for &(hash, _) in keys() {
        if met.add(hash) {
            again.add(hash);
        }
    }
    let mut alike: Vec<Key> = keys().copied().filter(|key| again.has(key.0)).collect();
    alike.sort_unstable();
    let mut found = Vec::new();
    for alike in alike.chunk_by_mut(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
        let order = |a: u32, b: u32| lex_cmp(&points[a as usize], &points[b as usize]);
        alike.sort_unstable_by(|a, b| order(a.1, b.1).then(a.1.cmp(&b.1)));
        for group in alike.chunk_by(|a, b| order(a.1, b.1).is_eq()) {
            found.extend(group[1..].iter().map(|key| (key.1, group[0].1)));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// Finds coincident points by sorting all points.
    fn expected(points: &[DVec3]) -> Vec<(u32, u32)> {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let compare = |a: &u32, b: &u32| lex_cmp(&points[*a as usize], &points[*b as usize]);
        order.sort_by(|a, b| compare(a, b).then(a.cmp(b)));
        let groups = order.chunk_by(|a, b| compare(a, b).is_eq());
        let mut all: Vec<(u32, u32)> =
            groups.flat_map(|group| group[1..].iter().map(|&i| (i, group[0]))).collect();
        all.sort_unstable();
        all
    }

    /// Point `i` has the coordinates of `i % distinct`. The cases have no, few, many or only coincident points, in one
    /// or several bins and in one or several blocks.
    #[test]
    fn each_is_found_with_the_first() {
        for count in [0, 1, 2, 100, BLOCK - 1, BLOCK + 1, 3 * BIN + 7, 5 * BLOCK] {
            for distinct in [1, 2, count / 2 + 1, count.saturating_sub(3).max(1), count.max(1)] {
                let at = |i: usize| ((i % distinct) as u32).wrapping_mul(2_654_435_769);
                let points: Vec<DVec3> =
                    (0..count).map(|i| DVec3::new(f64::from(at(i) % 64), f64::from(at(i)), 0.5)).collect();
                let found = coincidences(&points);
                assert!(found == expected(&points), "{count} points, {distinct} of them distinct");
                assert_eq!(found.len(), count.saturating_sub(distinct));
            }
        }
    }

    /// The result does not depend on the number of bins.
    #[test]
    fn any_number_of_bins_finds_them() {
        let points: Vec<DVec3> = (0..1000u32).map(|i| DVec3::splat(f64::from(i % 900))).collect();
        for bits in 0..=MOST_BINS.ilog2() {
            assert_eq!(by_bins(&points, bits), expected(&points), "{bits}");
        }
    }

    /// Equal keys do not make points coincident.
    #[test]
    fn points_with_equal_keys_are_compared() {
        let points: Vec<DVec3> = [1.0, 2.0, 1.0, 3.0].map(DVec3::splat).to_vec();
        let keys = [(7, 0), (7, 1), (7, 2), (9, 3)];
        assert_eq!(in_bin(&points, &[&keys[..1], &keys[1..]]), [(2, 0)]);
    }
}
