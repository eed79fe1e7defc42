//! Neighbourhood systems: a ball for every point.
//!
//! **Statement** (paper, Section 2). A `k`-ply neighbourhood system of `p_1..p_n` is a set of closed balls
//! `B_i` centred at `p_i` such that no point lies strictly inside more than `k` of them. The balls that
//! reach to the `k`-th nearest neighbour have ply at most `tau_d k`, `tau_d` the kissing number (Miller,
//! Teng, Thurston and Vavasis 1997).
//!
//! Balls are kept by their squared radius, computed by [`dist2`] and nothing else, so that a point at
//! the very distance of the radius is inside on every worker. Lists of nearest neighbours keep *all*
//! points no farther than the `k`-th: then they do not depend on how ties are numbered, and lists of
//! parts can be merged in any order.
//!
//! **Work and depth.** Direct: `m^2` pairs, O(1) vector steps and segmented scans.

use crate::cost::Cost;
use crate::point::{Point, dist2};

/// A neighbour found: squared distance and position in the caller's table.
pub type Found = (f64, u32);

/// Keeps the entries no farther than the `k`-th nearest (ties included) and no farther than `limit2`.
/// Returns the `k`-th squared distance, or infinity if there are fewer than `k`.
pub fn keep_nearest(list: &mut Vec<Found>, k: usize, limit2: f64) -> f64 {
    list.retain(|e| e.0 <= limit2);
    if k == 0 || list.len() < k {
        return f64::INFINITY;
    }
    let kth = list.select_nth_unstable_by(k - 1, |a, b| a.0.total_cmp(&b.0)).1.0;
    list.retain(|e| e.0 <= kth);
    kth
}

/// For every row point, the columns within the `k`-th nearest other column (ties included), at most
/// `limit2(row)` away, by all pairs. A column equal to its row's own position `own` is left out.
pub fn nearest_direct<P: Point>(
    table: &[P],
    rows: &[u32],
    cols: &[u32],
    k: usize,
    limit2: impl Fn(usize) -> f64,
    cost: &mut Cost,
) -> Vec<Vec<Found>> {
    let mut row_number = 0;
    let limits: Vec<f64> = (0..rows.len()).map(limit2).collect();
    cost.pairs(
        rows,
        cols,
        |_| {
            row_number += 1;
            Candidates::new(k, limits[row_number - 1])
        },
        |state, &row, _, &col| {
            if row != col {
                state.offer(dist2(table[row as usize], table[col as usize]), col);
            }
        },
    )
    .into_iter()
    .map(Candidates::finish)
    .collect()
}

/// A running list of the `k` nearest with ties: pruned when it grows, so that it stays short.
struct Candidates {
    k: usize,
    limit2: f64,
    list: Vec<Found>,
}

impl Candidates {
    fn new(k: usize, limit2: f64) -> Self {
        Candidates { k, limit2, list: Vec::new() }
    }

    #[inline]
    fn offer(&mut self, d2: f64, col: u32) {
        if d2 > self.limit2 {
            return;
        }
        if self.k == 1 && d2 < self.limit2 {
            self.list.clear();
            self.limit2 = d2;
        }
        self.list.push((d2, col));
        if self.k > 1 && self.list.len() >= 4 * self.k + 16 {
            self.prune();
        }
    }

    fn prune(&mut self) {
        let kth = keep_nearest(&mut self.list, self.k, self.limit2);
        self.limit2 = self.limit2.min(kth);
    }

    fn finish(mut self) -> Vec<Found> {
        self.prune();
        // Arrival order is the canonical one; pruning permutes, so restore it.
        self.list.sort_unstable_by_key(|e| e.1);
        // A copy of its own size: a large block that shrinks in place leaves a hole that nothing fills.
        self.list.as_slice().into()
    }
}

/// Squared distance of `x` to an axis-aligned box, by the expression of [`dist2`]: never larger than
/// the distance computed to a point of the box, because rounding is monotone.
pub fn box_dist2<P: Point>(x: P, low: P, high: P) -> f64 {
    let mut d = P::splat(0.0);
    for i in 0..P::DIM {
        let gap = (low.coord(i) - x.coord(i)).max(x.coord(i) - high.coord(i)).max(0.0);
        d.set_coord(i, gap);
    }
    d.norm2()
}

/// The largest number of balls (squared radii) strictly containing one of the centres: a lower bound
/// of the system's ply that is within a factor of a constant of it. O(n^2); for measurements.
pub fn ply_at_centres<P: Point>(points: &[P], radii2: &[f64]) -> usize {
    let inside = |&x: &P| points.iter().zip(radii2).filter(|&(&c, &r2)| dist2(x, c) < r2).count();
    points.iter().map(inside).max().unwrap_or(0)
}
