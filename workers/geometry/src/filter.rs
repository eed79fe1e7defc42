//! Stage 1: determinants in rounded arithmetic, with an error bound from the differences of the call.
//!
//! **Statement.** Let `u = 2^-53`, and let `n` be the number of products in the expanded determinant. Let `P` bound
//! each product. Let `k` be the largest number of roundings that a product passes through, not counting the last
//! addition or subtraction. Then the rounded determinant has the sign of the exact one if its absolute value exceeds
//! `1.05 k n u P`.
//!
//! *Proof.* Every product is scaled by at most `k` factors `1 + e` with `|e| <= u`. So the operands of the last
//! addition have a total error of at most `((1 + u)^k - 1) n P`. Rounding the result of that addition changes no sign
//! (Higham 2002, section 3.1; Shewchuk 1997). QED.
//!
//! | determinant | products `n` | bound `P` of one | roundings `k` |
//! | --- | --- | --- | --- |
//! | orientation in the plane | - | `abs(l) + abs(r)`, the two products themselves | 2 differences + 1 |
//! | orientation in space | 6 | `x y z` | 3 differences, 2 products, 1 + 1 additions |
//! | in-circle | 6 | `x y (x^2 + y^2)` | minor 4, lift 4, their product 1, 1 addition |
//! | in-sphere | 24 | `x y z (x^2 + y^2 + z^2)` | cofactor 8, lift 5, their product 1, 1 addition |
//!
//! Here `x`, `y`, `z` are the largest rounded differences of the call on each axis. The counts of the table are sums:
//!
//! - a minor has 2 differences, a product and a subtraction;
//! - a cofactor has 3 differences, 2 products, a subtraction and 2 additions;
//! - a lift has a difference that counts twice, a square, and 1 addition in the plane or 2 in space.
//!
//! For in-circle and in-sphere, the first of the two additions outside the cofactors counts; the last does not.
//!
//! **Weights.** A drop `w_i - w_q` lowers the lift of corner `i`. Let `w` be the largest absolute drop. Then `w` is added
//! to the sum of squares in `P`. A drop has one rounding, and its subtraction another. A squared term of the lift also
//! passes through that subtraction, so `k` grows by 1.
//!
//! **The factor 1.05.** The bound is computed from rounded differences, in at most 8 operations of relative error
//! `u`. Moreover, `(1 + u)^k - 1 < 1.0001 k u`. The factor covers both errors.
//!
//! **Underflow.** Within [`crate::range`], every product is a multiple of `2^-1070`. The smallest subnormal is
//! `2^-1074`, so underflow changes no determinant. If the *bound* is subnormal, rounding it loses at most `2^-1075`.
//! That is less than 5 % of any nonzero error, because errors are also multiples of `2^-1070`.
//!
//! **Work and depth.** O(1). The bound depends on this call alone, so the filter remains effective on graded sets.
//!
//! **Departures.** Shewchuk adds the absolute values of all products. That bound is tighter by a factor of about 4, but
//! computing it costs as much as the determinant. The largest difference on each axis is cheap.

#![expect(clippy::inline_always, reason = "callers that need no more than the sign skip the rest")]

use glam::{DVec2, DVec3};

/// A determinant in rounded arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct Rounded {
    /// The rounded determinant. Its sign is exact if its absolute value is larger than `bound`.
    pub det: f64,
    /// Bound on the error of `det`.
    pub bound: f64,
    /// The factors `o_i` of an in-sphere determinant `sum_i |p_i - q|^2 o_i`: the orientations of the cell with corner
    /// `i` replaced by the query.
    pub cofactors: [f64; 4],
    /// The largest absolute difference of coordinates in the determinant, rounded.
    pub reach: f64,
}

impl Rounded {
    /// Returns `true` if the sign of `det` is certainly exact.
    #[inline]
    pub fn is_certain(&self) -> bool {
        self.det.abs() > self.bound
    }
}

/// `1.05 u`.
const SLACK: f64 = 1.05 * (f64::EPSILON / 2.0);
const ORIENT_PLANE: f64 = 3.0 * SLACK;
const ORIENT_SPACE: f64 = 7.0 * 6.0 * SLACK;
const IN_CIRCLE: f64 = 10.0 * 6.0 * SLACK;
const IN_SPHERE: f64 = 15.0 * 24.0 * SLACK;
const POWER_PLANE: f64 = 11.0 * 6.0 * SLACK;
const POWER_SPACE: f64 = 16.0 * 24.0 * SLACK;

#[inline]
fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - b.x * a.y
}

#[inline]
fn pair(x: f64, y: f64) -> DVec2 {
    DVec2::new(x, y)
}

#[inline]
fn swapped(v: DVec2) -> DVec2 {
    DVec2::new(v.y, v.x)
}

/// Computes the orientation determinant of three points of the plane.
#[inline(always)]
pub fn orient_plane(c: &[DVec2]) -> Rounded {
    let (a, b) = (c[0] - c[2], c[1] - c[2]);
    let (left, right) = (a.x * b.y, b.x * a.y);
    Rounded {
        det: left - right,
        bound: ORIENT_PLANE * (left.abs() + right.abs()),
        cofactors: [0.0; 4],
        reach: a.abs().max(b.abs()).max_element(),
    }
}

/// Computes the orientation determinant of four points of space.
#[inline(always)]
pub fn orient_space(c: &[DVec3]) -> Rounded {
    let (a, b, e) = (c[0] - c[3], c[1] - c[3], c[2] - c[3]);
    let m = a.abs().max(b.abs()).max(e.abs());
    Rounded {
        det: -a.dot(b.cross(e)),
        bound: ORIENT_SPACE * (m.x * m.y * m.z),
        cofactors: [0.0; 4],
        reach: m.max_element(),
    }
}

/// Computes the in-circle determinant of a triangle and a point of the plane. If `W` is set, `drops` lowers the lifts of
/// the corners.
#[inline(always)]
pub fn in_circle<const W: bool>(c: &[DVec2], q: DVec2, drops: [f64; 4]) -> Rounded {
    let (a, b, e) = (c[0] - q, c[1] - q, c[2] - q);
    let m = a.abs().max(b.abs()).max(e.abs());
    let cofactors = [cross(b, e), cross(e, a), cross(a, b), 0.0];
    let lift = |p: DVec2, i: usize| if W { p.dot(p) - drops[i] } else { p.dot(p) };
    let (factor, highest) = if W { (POWER_PLANE, m.dot(m) + largest(drops)) } else { (IN_CIRCLE, m.dot(m)) };
    Rounded {
        det: (lift(a, 0) * cofactors[0] + lift(b, 1) * cofactors[1]) + lift(e, 2) * cofactors[2],
        bound: factor * (m.x * m.y * highest),
        cofactors,
        reach: m.max_element(),
    }
}

/// Computes the in-sphere determinant of a tetrahedron and a point of space. If `W` is set, `drops` lowers the lifts of
/// the corners.
#[inline(always)]
pub fn in_sphere<const W: bool>(c: &[DVec3], q: DVec3, drops: [f64; 4]) -> Rounded {
    let (a, b, e, d) = (c[0] - q, c[1] - q, c[2] - q, c[3] - q);
    let m = a.abs().max(b.abs()).max(e.abs()).max(d.abs());
    // Corners are processed in pairs: 0 with 2, and 1 with 3.
    let (ax, ay, az) = (pair(a.x, e.x), pair(a.y, e.y), pair(a.z, e.z));
    let (bx, by, bz) = (pair(b.x, d.x), pair(b.y, d.y), pair(b.z, d.z));
    let (ea_x, ea_y, ea_z) = (swapped(ax), swapped(ay), swapped(az));
    let ab_ed = ax * by - bx * ay;
    let be_da = bx * ea_y - ea_x * by;
    let (ae, bd) = (a.x * e.y - e.x * a.y, b.x * d.y - d.x * b.y);
    let bed_dab = bz * swapped(ab_ed) + swapped(bz) * be_da - pair(e.z, -a.z) * bd;
    let eda_abe = ea_z * swapped(be_da) + az * swapped(ab_ed) + pair(d.z, -b.z) * ae;
    let mut lift_ae = ax * ax + ay * ay + az * az;
    let mut lift_bd = bx * bx + by * by + bz * bz;
    let (mut factor, mut highest) = (IN_SPHERE, m.dot(m));
    if W {
        lift_ae -= pair(drops[0], drops[2]);
        lift_bd -= pair(drops[1], drops[3]);
        (factor, highest) = (POWER_SPACE, highest + largest(drops));
    }
    let cofactors = [bed_dab.x, -eda_abe.x, bed_dab.y, -eda_abe.y];
    let det = lift_ae * bed_dab - lift_bd * eda_abe;
    Rounded {
        det: det.x + det.y,
        bound: factor * (m.x * m.y * m.z * highest),
        cofactors,
        reach: m.max_element(),
    }
}

/// Returns the largest absolute value.
#[inline(always)]
fn largest(numbers: [f64; 4]) -> f64 {
    numbers.into_iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}
