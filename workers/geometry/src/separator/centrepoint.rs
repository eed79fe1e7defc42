//! The stereographic lift, centrepoints by iterated Radon points, and the pull-back of great circles.
//!
//! **Statement.** Any `D + 2` points of `R^D` are affinely dependent. The convex hull of the points with positive
//! coefficients and the convex hull of the points with negative ones intersect in a *Radon point* (Radon 1921). In a
//! `(D + 2)`-ary tree over random samples, let each node be the Radon point of its children. Then the root is an
//! approximate centrepoint with high probability.
//!
//! **Source.** Clarkson, Eppstein, Miller, Sturtivant and Teng (1996).
//!
//! **Work and depth.** Work `O(m)` and depth `O(log m)` for `m` samples in constant dimension. One iteration of the
//! elimination processes one pivot.
//!
//! **Departures.** The leaves are not independent draws. They are concatenated random permutations of all samples, so
//! that every sample has the same weight.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

use super::surface::Quadric;
use crate::cost::Cost;
use crate::point::{Point, Vector};

/// Pivots below this count as zero. The points are in the unit ball, and the first pivot is at least 1.
const PIVOT_FLOOR: f64 = 1e-12;
/// Largest distance between the two convex combinations of a Radon point.
const AGREEMENT: f64 = 1e-6;
/// Points with at least this squared length are lifted to the pole.
const POLE: f64 = 1e40;
/// Smallest `1 - |z|^2` of a centrepoint `z` for which great circles are pulled back.
const DEPTH_FLOOR: f64 = 1e-12;

/// Lifts `y` to the unit sphere one dimension higher, by the stereographic projection from the pole.
pub(super) fn lift<P: Point>(y: P) -> P::Lifted {
    let square = y.norm2();
    let mut p = P::Lifted::splat(0.0);
    if square < POLE {
        let inverse = 1.0 / (1.0 + square);
        for i in 0..P::DIM {
            p.set_coord(i, 2.0 * y.coord(i) * inverse);
        }
        p.set_coord(P::DIM, (square - 1.0) * inverse);
    } else {
        p.set_coord(P::DIM, 1.0);
    }
    p
}

/// Computes an approximate centrepoint of at least one point of the unit ball. Also returns the number of groups whose
/// mean replaced the Radon point, because their affine dependence was numerically unreliable.
pub(super) fn centrepoint<V: Vector>(
    points: &[V],
    stream: impl Fn(u64) -> ChaCha8Rng,
    cost: &mut Cost,
) -> (V, u32) {
    let arity = V::LEN + 2;
    let mut leaves = arity;
    while leaves * arity <= 4 * points.len() {
        leaves *= arity;
    }
    let copies: Vec<u64> = (0..leaves.div_ceil(points.len()) as u64).collect();
    let shuffled = cost.map_nested(&copies, |&copy, own| {
        let mut rng = stream(copy);
        let mut keyed = own.map(points, |p| (rng.next_u64(), *p));
        own.sort(&mut keyed, |a, b| a.0.cmp(&b.0));
        keyed
    });
    let shuffled = shuffled.concat();
    let mut level = cost.map(&shuffled[..leaves], |&(_, p)| (p, 0));
    while level.len() > 1 {
        let groups: Vec<&[(V, u32)]> = level.chunks_exact(arity).collect();
        level = cost.map_nested(&groups, |group, own| radon_point(group, own));
    }
    level[0]
}

/// Computes the Radon point of `V::LEN + 2` points. Also returns the number of means that replaced Radon points at
/// and below this node.
fn radon_point<V: Vector>(group: &[(V, u32)], cost: &mut Cost) -> (V, u32) {
    if V::LEN > 4 { radon_point_of::<V, 8, 9>(group, cost) } else { radon_point_of::<V, 5, 6>(group, cost) }
}

/// Computes [`radon_point`] with room for a linear system of `D + 1` equations in `D + 2` unknowns.
#[inline(always)]
fn radon_point_of<V: Vector, const ROWS: usize, const COLS: usize>(
    group: &[(V, u32)],
    cost: &mut Cost,
) -> (V, u32) {
    let dependence = affine_dependence::<V, ROWS, COLS>(group, cost);
    let zero = V::splat(0.0);
    let mut halves = [(zero, 0.0), (zero, 0.0)];
    let (mut sum, mut means) = (zero, 0);
    for (&(p, below), &l) in group.iter().zip(&dependence) {
        let half = &mut halves[usize::from(l < 0.0)];
        *half = (half.0 + p * l.abs(), half.1 + l.abs());
        sum = sum + p;
        means += below;
    }
    let [(positive, up), (negative, down)] = halves;
    let (point, other) = (positive / up, negative / down);
    if (point - other).norm2() <= AGREEMENT * AGREEMENT {
        ((point * up + other * down) / (up + down), means)
    } else {
        (sum / group.len() as f64, means + 1)
    }
}

/// Returns coefficients, not all zero, such that their sum and the sum of the points with these weights are zero up to
/// rounding. Gauss-Jordan elimination with full pivoting computes them as a null vector. If the system has lower rank
/// (coincident, collinear or coplanar points), it has several free columns, and the first is used.
fn affine_dependence<V: Vector, const ROWS: usize, const COLS: usize>(
    group: &[(V, u32)],
    cost: &mut Cost,
) -> [f64; COLS] {
    let (rows, cols) = (V::LEN + 1, V::LEN + 2);
    let mut m = [[0.0; COLS]; ROWS];
    for (j, (p, _)) in group.iter().enumerate().take(cols) {
        for (i, row) in m.iter_mut().enumerate().take(V::LEN) {
            row[j] = p.coord(i);
        }
        m[V::LEN][j] = 1.0;
    }
    let mut owner = [usize::MAX; COLS];
    cost.sequential(rows, 0, |rank, trip| {
        if rank < trip {
            return rank;
        }
        let (mut best, mut at) = (PIVOT_FLOOR, None);
        for (i, row) in m.iter().enumerate().take(rows).skip(rank) {
            for (j, &entry) in row.iter().enumerate().take(cols) {
                if owner[j] == usize::MAX && entry.abs() > best {
                    (best, at) = (entry.abs(), Some((i, j)));
                }
            }
        }
        let Some((i, j)) = at else { return rank };
        m.swap(rank, i);
        owner[j] = rank;
        let pivot = m[rank];
        for (r, row) in m.iter_mut().enumerate().take(rows) {
            if r != rank {
                let factor = row[j] / pivot[j];
                for (entry, p) in row.iter_mut().zip(&pivot) {
                    *entry -= factor * p;
                }
                row[j] = 0.0;
            }
        }
        rank + 1
    });
    let mut out = [0.0; COLS];
    let free = (0..cols).find(|&j| owner[j] == usize::MAX).unwrap_or(0);
    for (j, l) in out.iter_mut().enumerate().take(cols) {
        if owner[j] != usize::MAX {
            *l = -m[owner[j]][free] / m[owner[j]][j];
        }
    }
    out[free] = 1.0;
    out
}

/// Draws a unit vector, uniform on the sphere, by rejection from the cube. One vector step draws the trial points, and
/// one scan finds the first one inside the ball. Returns `None` if all trials fail (probability below `1e-5`).
pub(super) fn unit_vector<V: Vector>(rng: &mut ChaCha8Rng, cost: &mut Cost) -> Option<V> {
    let trials = cost.map(&[(); 32], |()| {
        let mut v = V::splat(0.0);
        for i in 0..V::LEN {
            // 53 bits times 2^-52, exactly: [-1, 1).
            v.set_coord(i, (rng.next_u64() >> 11) as f64 * f64::EPSILON - 1.0);
        }
        v
    });
    let inside = |v: &V| (1e-4..=1.0).contains(&v.norm2());
    let first = cost.reduce(&trials, None, |found, v| found.or(inside(v).then_some(*v)));
    first.map(|v| v / v.norm2().sqrt())
}

/// Computes the surface of a great circle with unit normal `n` in the frame `(origin, unit)`, where the conformal map
/// moves `z` to the centre. The plane `w . (p - z) = 0` cuts the unit sphere in a circle. The substitution
/// `p = (2 y, |y|^2 - 1) / (|y|^2 + 1)` turns its equation into `a |y|^2 + b . y + c = 0`.
pub(super) fn pull_back<P: Point>(origin: P, unit: f64, z: P::Lifted, n: P::Lifted) -> Option<Quadric<P>> {
    let room = 1.0 - z.norm2();
    if room < DEPTH_FLOOR {
        return None;
    }
    let (s, along) = (room.sqrt(), n.dot(z));
    let w = n * s + z * (along / (1.0 + s));
    let (vertical, constant) = (w.coord(P::DIM), -along);
    let mut b = P::splat(0.0);
    for i in 0..P::DIM {
        b.set_coord(i, 2.0 * w.coord(i));
    }
    Quadric::from_coefficients(origin, unit, vertical + constant, b, constant - vertical)
}

/// Returns `true` if the centrepoint is far enough inside the sphere to pull back great circles.
pub(super) fn has_room<V: Vector>(z: V) -> bool {
    1.0 - z.norm2() >= DEPTH_FLOOR
}
