//! The order of insertion: random rounds, each along a Hilbert curve.
//!
//! **Statement.** A biased randomized insertion order (Amenta, Choi and Rote, "Incremental
//! constructions con BRIO", 2003) puts every point into the last round with probability `1 - 1/8`, of
//! the others again `7/8` into the round before, and so on. Whatever the order inside the rounds, the
//! expected work is that of a random order; along a space-filling curve the walks are short as well.
//! The curve is Hilbert's, by the transposed bits of Skilling ("Programming the Hilbert curve", 2004).
//!
//! **Work.** O(n log n), by one comparison sort.
//!
//! **Departures.** The coin of a point is a hash of its coordinates, so the order depends on nothing
//! but the coordinates. Points in one cell of the curve's grid follow each other lexicographically.

use crate::point::{Point, lex_cmp};

/// Bits of one coordinate on the curve: `DIM * BITS` fit into 63 bits.
const fn bits(dimension: usize) -> u32 {
    63 / dimension as u32
}

/// The positions of `points` in order of insertion. A function of the coordinates only: permuted
/// input gives the same sequence of points (coincident points in the order of their numbers).
pub fn insertion_order<P: Point>(points: &[P]) -> Vec<u32> {
    let curve = Curve::over(points);
    let mut keyed: Vec<(u8, u64, u32)> =
        (0u32..).zip(points).map(|(i, p)| (round(p), curve.key(p), i)).collect();
    keyed.sort_unstable_by(|a, b| {
        let by_key = (a.0, a.1).cmp(&(b.0, b.1));
        by_key.then_with(|| lex_cmp(&points[a.2 as usize], &points[b.2 as usize])).then_with(|| a.2.cmp(&b.2))
    });
    keyed.into_iter().map(|(_, _, i)| i).collect()
}

/// The round of a point, 0 the first: `7/8` of all points are in the last.
fn round<P: Point>(p: &P) -> u8 {
    let mut hash = 0x243F_6A88_85A3_08D3_u64;
    for i in 0..P::DIM {
        hash = mix(hash ^ p.coord(i).to_bits());
    }
    21 - ((hash | 1 << 63).trailing_zeros() / 3) as u8
}

/// A bijective mixing of 64 bits (the finalizer of `SplitMix64`).
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// A Hilbert curve over the bounding cube of a point set.
struct Curve<P> {
    low: P,
    scale: f64,
}

impl<P: Point> Curve<P> {
    fn over(points: &[P]) -> Self {
        let mut low = points.first().copied().unwrap_or_default();
        let mut high = low;
        for p in points {
            for i in 0..P::DIM {
                low.set_coord(i, low.coord(i).min(p.coord(i)));
                high.set_coord(i, high.coord(i).max(p.coord(i)));
            }
        }
        let extent = (0..P::DIM).map(|i| high.coord(i) - low.coord(i)).fold(0.0, f64::max);
        let scale = ((1u64 << bits(P::DIM)) - 1) as f64 / extent;
        Curve { low, scale: if scale.is_finite() { scale } else { 0.0 } }
    }

    /// The position of `p` along the curve.
    fn key(&self, p: &P) -> u64 {
        let mut x = [0u32; 3];
        let x = &mut x[..P::DIM];
        for (i, xi) in x.iter_mut().enumerate() {
            // A cast saturates: whatever the rounding, the value stays a position.
            let cell = (p.coord(i) - self.low.coord(i)) * self.scale;
            *xi = (cell as u32).min((1 << bits(P::DIM)) - 1);
        }
        hilbert_transpose(x, bits(P::DIM));
        let mut key = 0;
        for bit in (0..bits(P::DIM)).rev() {
            for xi in x.iter() {
                key = key << 1 | u64::from(*xi >> bit & 1);
            }
        }
        key
    }
}

/// Turns coordinates of `bits` bits into the transposed Hilbert index, in place (Skilling 2004).
fn hilbert_transpose(x: &mut [u32], bits: u32) {
    let n = x.len();
    let mut q = 1u32 << (bits - 1);
    while q > 1 {
        let p = q - 1;
        for i in 0..n {
            if x[i] & q != 0 {
                x[0] ^= p;
            } else {
                let t = (x[0] ^ x[i]) & p;
                x[0] ^= t;
                x[i] ^= t;
            }
        }
        q >>= 1;
    }
    for i in 1..n {
        x[i] ^= x[i - 1];
    }
    let mut t = 0;
    let mut q = 1u32 << (bits - 1);
    while q > 1 {
        if x[n - 1] & q != 0 {
            t ^= q - 1;
        }
        q >>= 1;
    }
    for xi in x.iter_mut() {
        *xi ^= t;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    #[test]
    fn the_curve_visits_neighbours_in_turn() {
        let side = 16u32;
        let points: Vec<DVec3> = (0..side.pow(3))
            .map(|i| DVec3::new((i % side).into(), (i / side % side).into(), (i / side / side).into()))
            .collect();
        let curve = Curve { low: DVec3::ZERO, scale: f64::from(1u32 << (bits(3) - 4)) };
        let mut along = points.clone();
        along.sort_by_key(|p| curve.key(p));
        assert!(along.windows(2).all(|w| (w[1] - w[0]).length_squared() == 1.0));
        let plane: Vec<DVec2> = points.iter().filter(|p| p.z == 0.0).map(|p| p.truncate()).collect();
        let curve = Curve { low: DVec2::ZERO, scale: f64::from(1u32 << (bits(2) - 4)) };
        let mut along = plane.clone();
        along.sort_by_key(|p| curve.key(p));
        assert!(along.windows(2).all(|w| (w[1] - w[0]).length_squared() == 1.0));
    }

    #[test]
    fn the_order_is_a_function_of_the_coordinates() {
        let points: Vec<DVec2> =
            (0..200u32).map(|i| DVec2::new((i * 37 % 101).into(), (i * 61 % 97).into())).collect();
        let reversed: Vec<DVec2> = points.iter().rev().copied().collect();
        let first: Vec<DVec2> = insertion_order(&points).iter().map(|&i| points[i as usize]).collect();
        let second: Vec<DVec2> = insertion_order(&reversed).iter().map(|&i| reversed[i as usize]).collect();
        assert_eq!(first, second);
        assert!(insertion_order::<DVec2>(&[]).is_empty());
        assert_eq!(insertion_order(&[DVec2::ONE, DVec2::ONE]), [0, 1]);
    }
}
