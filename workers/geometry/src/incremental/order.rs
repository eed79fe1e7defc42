//! The order of insertion: random rounds, each along a Hilbert curve.
//!
//! **Statement.** In a biased randomized insertion order, every point is in the last round with probability
//! `1 - 1/8`, each remaining point is in the round before with probability `7/8`, and so on. For any order inside the
//! rounds, the expected work is the same as for a random order. If every round follows a space-filling curve, the
//! walks are also short.
//!
//! **Curve.** The Hilbert curve is followed two levels at a time ([`crate::curve`]).
//!
//! **Source.** Amenta, Choi and Rote, "Incremental constructions con BRIO" (2003).
//!
//! **Work.** O(n log n). The leading bits of 64-bit keys assign points to buckets, and each bucket is sorted.
//!
//! **Departures.** The random choice for a point is a hash of its coordinates, so the order depends on the coordinates
//! only. A few points that are far from all others ([`far`]) come last, in an order of their own: before them, few cells
//! have a far vertex, and such cells need exact tests. In a set of several scales, many points can share a cell of the
//! curve's grid. The points of a cell follow a curve over their own box, again and again. Up to 8 points, and points that
//! coincide, are ordered lexicographically.

mod far;

use crate::curve::{STATES, TWO_PLANE, TWO_SPACE};
use crate::hash::mix;
use crate::point::{Point, lex_cmp};
pub use far::FarPoints;
use far::far_points;

/// Number of key bits for the round. The other bits are the position on the curve.
const ROUND_BITS: u32 = 4;
const CURVE_BITS: u32 = 64 - ROUND_BITS;

/// The number of rounds.
const ROUNDS: u64 = 1 << ROUND_BITS;

/// Returns the number of bits of one coordinate on the curve.
const fn bits(dimension: usize) -> u32 {
    CURVE_BITS / dimension as u32
}

/// Returns the positions of `points` in the order of insertion, which depends only on the coordinates. Permuted input
/// yields the same sequence of points; coincident points are ordered by position.
pub fn insertion_order<P: Point>(points: &[P]) -> Vec<u32> {
    let keys: Vec<u64> = points.iter().map(|p| insertion_round(p) << CURVE_BITS).collect();
    let far = far_points(points, |i| keys[i] >> CURVE_BITS);
    if far.is_empty() {
        return along_curve(points, keys);
    }
    let mut is_far = vec![false; points.len()];
    for &i in &far {
        is_far[i as usize] = true;
    }
    let near: Vec<u32> = (0u32..).zip(&is_far).filter(|(_, is_far)| !**is_far).map(|(i, _)| i).collect();
    let at = |of: &[u32]| of.iter().map(|&i| points[i as usize]).collect::<Vec<P>>();
    let near_keys = near.iter().map(|&i| keys[i as usize]).collect();
    let first = along_curve(&at(&near), near_keys).into_iter().map(|i| near[i as usize]);
    let last = insertion_order(&at(&far)).into_iter().map(|i| far[i as usize]);
    first.chain(last).collect()
}

/// Returns the positions of `points` in the order of their keys, which hold the rounds, and along a curve within a round.
fn along_curve<P: Point>(points: &[P], mut keys: Vec<u64>) -> Vec<u32> {
    let curve = Curve::over(points);
    for (key, p) in keys.iter_mut().zip(points) {
        *key |= curve.key(p);
    }
    let mut keyed = by_key(&keys);
    drop(keys);
    for run in keyed.chunk_by_mut(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        order_cell(points, run);
    }
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// The largest number of points of a cell that are in lexicographic order.
const FEW: usize = 8;

/// Orders points of one cell of a curve's grid along a curve over these points alone, and the points of each of its cells
/// in the same way. The longest side of their box is divided, so every call separates some points that differ. As the grid
/// has at least `2^20` cells along a side, the range of coordinates ([`crate::range`]) permits 21 nested calls.
fn order_cell<P: Point>(points: &[P], run: &mut [(u64, u32)]) {
    let by_coordinates = |&(_, a): &(u64, u32), &(_, b): &(u64, u32)| {
        lex_cmp(&points[a as usize], &points[b as usize]).then_with(|| a.cmp(&b))
    };
    if run.len() <= FEW {
        run.sort_unstable_by(by_coordinates);
        return;
    }
    let members: Vec<P> = run.iter().map(|&(_, i)| points[i as usize]).collect();
    let curve = Curve::over(&members);
    if curve.scale == 0.0 {
        run.sort_unstable_by(by_coordinates);
        return;
    }
    for ((key, _), p) in run.iter_mut().zip(&members) {
        *key = curve.key(p);
    }
    drop(members);
    run.sort_unstable_by_key(|&(key, _)| key);
    for cell in run.chunk_by_mut(|a, b| a.0 == b.0).filter(|cell| cell.len() > 1) {
        order_cell(points, cell);
    }
}

/// Returns the positions of `points` along a Hilbert curve over their bounding cube. Points of one cell of the curve's grid
/// are in no particular order.
pub fn curve_order<P: Point>(points: &[P]) -> Vec<u32> {
    let curve = Curve::over(points);
    let keys: Vec<u64> = points.iter().map(|p| curve.key(p) << ROUND_BITS).collect();
    by_key(&keys).into_iter().map(|(_, i)| i).collect()
}

/// Number of points in a bucket if they are evenly spread along the curve.
const BUCKET: usize = 64;
/// Largest number of bits of a bucket index.
const MOST_BUCKET_BITS: u32 = 16;

/// Sorts the keys, each with its position.
fn by_key(keys: &[u64]) -> Vec<(u64, u32)> {
    let bits = (keys.len() / BUCKET + 1).ilog2() + ROUND_BITS;
    let shift = 64 - bits.min(MOST_BUCKET_BITS);
    let mut ends = vec![0u32; (1 << (64 - shift)) + 1];
    for key in keys {
        ends[(key >> shift) as usize + 1] += 1;
    }
    for i in 1..ends.len() {
        ends[i] += ends[i - 1];
    }
    // `ends` holds the position of the next key of each bucket, and finally the end of each bucket.
    let mut keyed = vec![(0, 0); keys.len()];
    for (&key, i) in keys.iter().zip(0u32..) {
        let next = &mut ends[(key >> shift) as usize];
        keyed[*next as usize] = (key, i);
        *next += 1;
    }
    let mut rest = &mut keyed[..];
    let mut start = 0;
    for &end in &ends[..ends.len() - 1] {
        let (bucket, behind) = std::mem::take(&mut rest).split_at_mut((end - start) as usize);
        bucket.sort_unstable_by_key(|&(key, _)| key);
        (rest, start) = (behind, end);
    }
    keyed
}

/// Returns the round, from 0 to 15, in which a point is inserted. The last round has `7/8` of all points.
pub fn insertion_round<P: Point>(p: &P) -> u64 {
    let mut hash = 0x243F_6A88_85A3_08D3_u64;
    for i in 0..P::DIM {
        hash = mix(hash, p.coord(i).to_bits());
    }
    let last = ROUNDS - 1;
    last - u64::from(hash.trailing_zeros() / 3).min(last)
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

    /// Returns the position of `p` along the curve.
    #[inline]
    fn key(&self, p: &P) -> u64 {
        let mut octants = 0;
        for i in 0..P::DIM {
            // The cast saturates, so rounding cannot produce an invalid position.
            let at = ((p.coord(i) - self.low.coord(i)) * self.scale) as u32;
            octants |= spread(P::DIM, at.min((1 << bits(P::DIM)) - 1)) << i;
        }
        let table = if P::DIM == 2 { &TWO_PLANE } else { &TWO_SPACE };
        let (mut key, mut state) = (0, 0);
        let two = 2 * P::DIM as u32;
        for pair in (0..bits(P::DIM) / 2).rev() {
            let octants = octants >> (pair * two) & ((1 << two) - 1);
            let step = table[state << 6 | octants as usize];
            key = key << two | u64::from(step & 63);
            state = usize::from(step >> 6) % STATES;
        }
        key
    }
}

/// Inserts `dimension - 1` zeros between the bits of a coordinate.
#[inline]
fn spread(dimension: usize, x: u32) -> u64 {
    let x = u64::from(x);
    if dimension == 2 {
        let x = (x | x << 16) & 0x0000_FFFF_0000_FFFF;
        let x = (x | x << 8) & 0x00FF_00FF_00FF_00FF;
        let x = (x | x << 4) & 0x0F0F_0F0F_0F0F_0F0F;
        let x = (x | x << 2) & 0x3333_3333_3333_3333;
        (x | x << 1) & 0x5555_5555_5555_5555
    } else {
        let x = (x | x << 32) & 0x001F_0000_0000_FFFF;
        let x = (x | x << 16) & 0x001F_0000_FF00_00FF;
        let x = (x | x << 8) & 0x100F_00F0_0F00_F00F;
        let x = (x | x << 4) & 0x10C3_0C30_C30C_30C3;
        (x | x << 2) & 0x1249_2492_4924_9249
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

    /// Far points do not change the order of the others: each step is short, in the scale of the others.
    #[test]
    fn far_points_leave_short_steps() {
        let near: Vec<DVec2> = (0..1000u32)
            .map(|i| DVec2::new(f64::from(i * 37 % 1009), f64::from(i * 619 % 997)) / 1009.0)
            .collect();
        let length = |points: &[DVec2]| {
            let order = insertion_order(points);
            let last_round = order.iter().map(|&i| points[i as usize]).filter(|p| insertion_round(p) == 15);
            let near: Vec<DVec2> =
                last_round.filter(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0).collect();
            near.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>()
        };
        let alone = length(&near);
        for far in [1e3, 1e9, 1e20, -3.4e38] {
            let mut points = near.clone();
            points.extend([DVec2::new(far, 0.5), DVec2::new(0.5, -far), DVec2::splat(far * far)]);
            let with = length(&points);
            assert!(with < 1.3 * alone, "{far}: {with} and {alone}");
        }
    }

    /// Coincident points, and clusters in clusters, end the recursion.
    #[test]
    fn nested_clusters_have_an_order() {
        let mut points = vec![DVec3::ONE; 40];
        points.extend((0..300i32).map(|i| DVec3::new(2f64.powi(-i % 200), f64::from(i % 7), 0.0)));
        let mut order = insertion_order(&points);
        let of_ones: Vec<u32> = order.iter().copied().filter(|&i| points[i as usize] == DVec3::ONE).collect();
        assert!(of_ones.is_sorted());
        order.sort_unstable();
        assert!(order.into_iter().eq(0..points.len() as u32));
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
