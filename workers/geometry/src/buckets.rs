//! Short lists of numbers in order, and the `k`-th of one, by buckets.
//!
//! **Statement.** Numbers from `low` to `high` go to the bucket `(x - low) >> s`, with the smallest `s` that leaves no more
//! than 256 of them. Buckets are in the order of the numbers: so the numbers are in order once those of each bucket
//! are, and the `k`-th is in the first bucket up to which there are `k`.
//!
//! **Source.** Distribution counting, with insertion at the end (Knuth 1998, Sections 5.2 and 5.2.1). **Departure.** Counts
//! are bytes, eight of which one multiplication adds up: lists of more than 255 numbers, or with many in one bucket, are
//! left to the standard library.
//!
//! **Work.** Linear where numbers are spread evenly, as the bits of the squared distances of nearest points nearly are:
//! insertion moves none beyond its bucket.

#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

use crate::simd::widest;

/// Number of buckets.
const BUCKETS: usize = 256;

/// Longer lists cannot be counted in bytes.
const LONGEST: usize = 255;

/// In shorter ones comparing is as good.
const SHORTEST: usize = 12;

/// A fuller bucket is none that insertion should sort.
const FULL: usize = 16;

/// A one in each byte.
const ONES: u64 = 0x0101_0101_0101_0101;

/// Sorts the numbers.
pub(crate) fn sort(numbers: &mut [u64]) {
    if (SHORTEST..=LONGEST).contains(&numbers.len()) && distribute(numbers) {
        insert_all(numbers);
    } else {
        numbers.sort_unstable();
    }
}

/// The `k`-th smallest, counted from 1, of at least `k` numbers, which are left in some order.
pub(crate) fn kth(numbers: &mut [u64], k: usize) -> u64 {
    if (SHORTEST..=LONGEST).contains(&numbers.len())
        && let Some(found) = find(numbers, k)
    {
        return found;
    }
    *numbers.select_nth_unstable(k - 1).1
}

/// The buckets of a list's numbers, and how many each holds.
struct Buckets {
    of: [u8; BUCKETS],
    counts: [u8; BUCKETS],
}

impl Buckets {
    /// Of no more numbers than [`LONGEST`].
    #[inline(always)]
    fn of(numbers: &[u64]) -> Self {
        let mut buckets = Buckets { of: [0; BUCKETS], counts: [0; BUCKETS] };
        let low = numbers.iter().fold(u64::MAX, |low, &x| if x < low { x } else { low });
        let high = numbers.iter().fold(0, |high, &x| if x > high { x } else { high });
        let digits = u64::BITS - high.wrapping_sub(low).leading_zeros();
        let shift = digits.saturating_sub(BUCKETS.trailing_zeros());
        for (bucket, &x) in buckets.of.iter_mut().zip(numbers) {
            *bucket = (x.wrapping_sub(low) >> shift) as u8;
        }
        for &bucket in &buckets.of[..numbers.len()] {
            let count = &mut buckets.counts[usize::from(bucket)];
            *count = count.wrapping_add(1);
        }
        buckets
    }

    /// The counts of eight buckets after each other.
    #[inline(always)]
    fn words(&self) -> impl DoubleEndedIterator<Item = u64> + ExactSizeIterator {
        self.counts.as_chunks().0.iter().map(|&eight| u64::from_le_bytes(eight))
    }
}

/// Puts the numbers in the order of their buckets, unless one is full.
fn distribute(numbers: &mut [u64]) -> bool {
    widest(
        #[inline(always)]
        || {
            let buckets = Buckets::of(numbers);
            let fullest = buckets.counts.iter().fold(0, |most, &n| if n > most { n } else { most });
            if usize::from(fullest) > FULL {
                return false;
            }
            let (mut places, mut before) = ([0u8; BUCKETS], 0u64);
            for (word, places) in buckets.words().zip(places.as_chunks_mut().0) {
                // Its bytes: how many there are up to each bucket, at most 255.
                let up_to = word.wrapping_mul(ONES);
                *places = (up_to - word + before * ONES).to_le_bytes();
                before += up_to >> 56;
            }
            let mut given = [0; BUCKETS];
            given[..numbers.len()].copy_from_slice(numbers);
            for (&x, &bucket) in given[..numbers.len()].iter().zip(&buckets.of) {
                let place = &mut places[usize::from(bucket)];
                numbers[usize::from(*place)] = x;
                *place = place.wrapping_add(1);
            }
            true
        },
    )
}

/// Sorts numbers of which each is near its place.
fn insert_all(numbers: &mut [u64]) {
    for at in 1..numbers.len() {
        let (x, mut place) = (numbers[at], at);
        while place > 0 && numbers[place - 1] > x {
            numbers[place] = numbers[place - 1];
            place -= 1;
        }
        numbers[place] = x;
    }
}

/// The `k`-th, unless its bucket is full.
fn find(numbers: &[u64], k: usize) -> Option<u64> {
    let mut few = [0; 2 * FULL];
    let (rank, count) = widest(
        #[inline(always)]
        || {
            let buckets = Buckets::of(numbers);
            let mut after = numbers.len() - k;
            // From the last: the k-th is mostly one of the last.
            let (mut at, mut here) = (BUCKETS / 8, 0);
            for word in buckets.words().rev() {
                (at, here) = (at - 1, word);
                let of_word = (word.wrapping_mul(ONES) >> 56) as usize;
                if of_word > after {
                    break;
                }
                after -= of_word;
            }
            let (mut bucket, mut count) = (8 * at + 8, 0);
            for n in here.to_be_bytes().map(usize::from) {
                (bucket, count) = (bucket - 1, n);
                if n > after {
                    break;
                }
                after -= n;
            }
            if count > FULL {
                return (0, 0);
            }
            let mut found = 0;
            for (&x, &of) in numbers.iter().zip(&buckets.of) {
                few[found & (2 * FULL - 1)] = x;
                found += usize::from(usize::from(of) == bucket);
            }
            (count - after, count)
        },
    );
    insert_all(&mut few[..count]);
    few[..count].get(rank.wrapping_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use rand::{Rng, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Lists of all kinds: spread, crowded, equal, of few digits, with extremes.
    fn list(rng: &mut impl Rng, kind: usize, len: usize) -> Vec<u64> {
        let mut number = |at: usize| match kind {
            0 => rng.random(),
            1 => rng.random_range(0.01f64..5.0).to_bits(),
            2 => rng.random_range(0..7),
            3 => 9,
            4 => u64::MAX - at as u64,
            5 if at == 0 => u64::MAX,
            5 => rng.random_range(0..300),
            6 => f64::INFINITY.to_bits() - rng.random_range(0..2) * (1 << 60),
            _ => at as u64 * 1_000_003 % 257,
        };
        (0..len).map(&mut number).collect()
    }

    #[test]
    fn lists_are_sorted_and_every_place_is_found() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for kind in 0..8 {
            for len in [0, 1, 2, 11, 12, 13, 40, 53, 64, 100, 200, 254, 255, 256, 300] {
                let given = list(&mut rng, kind, len);
                let mut expected = given.clone();
                expected.sort_unstable();
                let mut sorted = given.clone();
                sort(&mut sorted);
                assert_eq!(sorted, expected, "kind {kind}, {len} numbers");
                for k in 1..=len {
                    assert_eq!(kth(&mut given.clone(), k), expected[k - 1], "kind {kind}, {k} of {len}");
                }
            }
        }
    }

    #[test]
    fn buckets_are_used_where_numbers_are_spread_and_not_where_they_are_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for kind in [0, 1, 4] {
            let mut spread = list(&mut rng, kind, 60);
            assert!(find(&spread, 48).is_some() && distribute(&mut spread), "kind {kind}");
        }
        for kind in [2, 3, 5] {
            let mut crowded = list(&mut rng, kind, 200);
            assert!(find(&crowded, 100).is_none() && !distribute(&mut crowded), "kind {kind}");
        }
    }
}
