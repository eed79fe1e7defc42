//! A 64-bit hash that detects changes of bytes: frames, encoded values, parts of the ledger, rows of cells.
//!
//! **Statement.** Each step multiplies two words and adds the halves of the product without carry. A change of the input
//! therefore leaves the hash unchanged with a probability of about `2^-64`. The hash is no defence against a sender that
//! chooses its bytes.
//!
//! **Work.** One multiplication for each 16 bytes, in four independent chains.

use bincode::Encode;
use bincode::enc::write::Writer;
use bincode::error::EncodeError;

use crate::codec;

/// Odd numbers with about as many ones as zeros: the primes of xxHash (Collet) and the increments of splitmix64.
const KEYS: [u64; 4] =
    [0x9e37_79b1_85eb_ca87, 0xc2b2_ae3d_27d4_eb4f, 0x1656_67b1_9e37_79f9, 0x85eb_ca77_c2b2_ae63];

/// Number of bytes that the four chains read in a step.
const STEP: usize = 64;

/// Multiplies two words and joins the halves of the product.
#[inline]
fn fold(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    product as u64 ^ (product >> 64) as u64
}

/// Returns the hash of some bytes.
pub fn checksum(bytes: &[u8]) -> u64 {
    let (steps, rest) = bytes.as_chunks::<STEP>();
    // The first factors of a product have other keys than the second, so the order of two words matters.
    let mut chains = KEYS.map(|key| key.rotate_left(32));
    for step in steps {
        advance(&mut chains, step);
    }
    if !rest.is_empty() {
        let mut last = [0; STEP];
        last[..rest.len()].copy_from_slice(rest);
        advance(&mut chains, &last);
    }
    chains.iter().zip(KEYS).fold(bytes.len() as u64, |hash, (&chain, key)| fold(hash ^ chain, key))
}

#[inline]
fn advance(chains: &mut [u64; 4], step: &[u8; STEP]) {
    let words = step.as_chunks::<8>().0;
    for (i, chain) in chains.iter_mut().enumerate() {
        let [a, b] = [2 * i, 2 * i + 1].map(|at| u64::from_le_bytes(words[at]));
        *chain = fold(a ^ KEYS[i], b ^ *chain);
    }
}

/// Returns the hash of a cell: a row of at most four vertices, in their order. Sums of these hashes do not depend on the
/// order of the cells.
///
/// If all vertices are below `2^32`, different rows give different factors. Larger vertices overlap: some pairs of such
/// rows have the same hash. No such row occurs in a run of fewer than `2^32` points.
#[inline]
pub fn row_hash<T: Copy + Into<u64>>(row: &[T]) -> u64 {
    let mut words = [0; 4];
    for (word, &v) in words.iter_mut().zip(row) {
        *word = v.into();
    }
    let [a, b, c, d] = words;
    // Each factor holds two vertices of 32 bits.
    let (low, high) = (a ^ b.rotate_left(32), c ^ d.rotate_left(32));
    fold(low ^ KEYS[0], high ^ KEYS[1])
}

/// A writer that hashes what it receives, without a buffer.
struct Hasher(u64);

impl Writer for Hasher {
    fn write(&mut self, bytes: &[u8]) -> Result<(), EncodeError> {
        let hash = match bytes.len() {
            0..=8 => {
                let mut word = [0; 8];
                word[..bytes.len()].copy_from_slice(bytes);
                u64::from_le_bytes(word)
            }
            _ => checksum(bytes),
        };
        self.0 = fold(self.0 ^ hash, KEYS[1] ^ bytes.len() as u64).wrapping_add(KEYS[2]);
        Ok(())
    }
}

/// Returns a hash of the encoded form of a value. Equal values have equal hashes on all ranks.
pub fn hash_of<T: Encode>(value: &T) -> u64 {
    let mut hasher = Hasher(KEYS[0]);
    // The writer accepts everything, so encoding cannot fail.
    let _ = codec::encode_into(value, &mut hasher);
    hasher.0
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::codec::Bulk;

    #[test]
    fn every_flip_and_every_length_changes_the_hash() {
        let bytes: Vec<u8> = (0..200u32).map(|i| (i * i % 251) as u8).collect();
        let mut seen = BTreeSet::new();
        for length in 0..bytes.len() {
            assert!(seen.insert(checksum(&bytes[..length])));
        }
        assert!(seen.insert(checksum(&bytes)));
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(seen.insert(checksum(&flipped)), "bit {bit}");
        }
        // The first two of these are prefixes of `bytes`.
        let zeros = [0; 130];
        assert!((2..zeros.len()).all(|length| seen.insert(checksum(&zeros[..length]))));
    }

    #[test]
    fn every_exchange_of_words_changes_the_hash() {
        let words: Vec<u64> = (10..40).collect();
        let mut seen = BTreeSet::from([checksum(bytemuck::cast_slice(&words))]);
        for a in 0..words.len() {
            for b in a + 1..words.len() {
                let mut swapped = words.clone();
                swapped.swap(a, b);
                assert!(seen.insert(checksum(bytemuck::cast_slice(&swapped))), "{a} and {b}");
            }
        }
    }

    #[test]
    fn values_differ_by_every_part() {
        let value = |a: u32, b: Vec<u64>, c: Vec<u32>| hash_of(&(a, Bulk(b), Bulk(c)));
        let hashes = [
            value(1, vec![2, 3], vec![4]),
            value(2, vec![2, 3], vec![4]),
            value(1, vec![3, 2], vec![4]),
            value(1, vec![2, 3], vec![5]),
            value(1, vec![2, 3], vec![]),
            value(1, vec![], vec![2, 0, 3, 0, 4]),
        ];
        assert_eq!(BTreeSet::from(hashes).len(), hashes.len());
        assert_eq!(hashes[0], value(1, vec![2, 3], vec![4]));
    }

    #[test]
    fn rows_differ_by_vertices_and_order() {
        let row = [7u32, 8, 9, 10];
        let mut seen = BTreeSet::from([row_hash(&row), row_hash(&row[..3])]);
        assert!(seen.insert(row_hash(&[8u32, 7, 9, 10])) && seen.insert(row_hash(&[7u32, 8, 10, 9])));
        for bit in 0..128 {
            let mut flipped = row;
            flipped[bit / 32] ^= 1 << (bit % 32);
            assert!(seen.insert(row_hash(&flipped)), "bit {bit}");
        }
        let wide = row.map(u64::from);
        assert_eq!(row_hash(&wide), row_hash(&row));
        for bit in 32..64 {
            for at in 0..4 {
                let mut flipped = wide;
                flipped[at] ^= 1 << bit;
                assert_ne!(row_hash(&flipped), row_hash(&wide));
            }
        }
    }
}
