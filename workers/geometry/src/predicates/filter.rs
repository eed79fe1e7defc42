//! Stage 1: determinants in rounded arithmetic, with a bound from the differences of this call.
//!
//! **Statement.** Let `u = 2^-53`, `n` the number of products in a determinant written out, `P` a bound of
//! each product and `k` the most roundings that any product passes through, the last addition or
//! subtraction of all not counted. Then the rounded determinant has the sign of the exact one wherever
//! its size exceeds `1.05 k n u P`: every product is scaled by at most `k` factors `1 + e`, `|e| <= u`,
//! so the operands of the last addition are off by at most `((1 + u)^k - 1) n P` together, and rounding
//! that addition's result changes no sign (Higham 2002, section 3.1; Shewchuk 1997).
//!
//! | determinant | products `n` | bound `P` of one | roundings `k` |
//! | --- | --- | --- | --- |
//! | orientation in the plane | - | `abs(l) + abs(r)`, the two products themselves | 2 differences + 1 |
//! | orientation in space | 6 | `x y z` | 3 differences, 2 products, 1 + 1 additions |
//! | in-circle | 6 | `x y (x^2 + y^2)` | minor 4, lift 4, their product 1, 1 addition |
//! | in-sphere | 24 | `x y z (x^2 + y^2 + z^2)` | cofactor 8, lift 5, their product 1, 1 addition |
//!
//! Here `x`, `y`, `z` are the largest rounded differences of the call on each axis. (A minor: 2
//! differences, a product, a subtraction. A cofactor: 3 differences, 2 products, a subtraction, 2
//! additions. A lift: twice a difference, a square, 1 addition in the plane and 2 in space. For in-circle
//! and in-sphere the first of the two additions outside the cofactors counts, the last does not.)
//!
//! The bound is computed from differences that are themselves rounded, in at most 8 operations of
//! relative error `u`, and `(1 + u)^k - 1 < 1.0001 k u`: the factor 1.05 covers both. Within
//! [`crate::range`] no determinant loses anything to underflow, since every product is a multiple of the
//! smallest subnormal, 2^-1074; of 2^-1070 in fact. If the *bound* falls among the subnormals, rounding
//! it loses at most `2^-1075`, less than the 5 % of any error that is not zero: errors too are multiples
//! of 2^-1070.
//!
//! **Work and depth.** O(1). The bound depends on this call alone, so that graded sets keep the filter.
//!
//! **Departures.** Shewchuk sums the sizes of all products, which is tighter (by about 4) and costs as
//! much as the determinant again; the largest difference per axis costs little.

use glam::{DVec2, DVec3};

/// A determinant in rounded arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct Rounded {
    /// The determinant: its sign is exact if its size is larger than `bound`.
    pub det: f64,
    /// The bound of its error.
    pub bound: f64,
    /// Of an in-sphere determinant `sum_i |p_i - q|^2 o_i`: the factors `o_i`, the orientations of the cell
    /// with corner `i` replaced by the query.
    pub cofactors: [f64; 4],
    /// The largest difference of coordinates in the determinant, rounded.
    pub reach: f64,
}

impl Rounded {
    /// Is the sign of `det` exact?
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

#[inline]
fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - b.x * a.y
}

#[inline]
fn minor(a: DVec3, b: DVec3) -> f64 {
    a.x * b.y - b.x * a.y
}

/// Orientation of three points of the plane.
#[inline]
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

/// Orientation of four points of space.
#[inline]
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

/// The in-circle determinant of a triangle and a point of the plane.
#[inline]
pub fn in_circle(c: &[DVec2], q: DVec2) -> Rounded {
    let (a, b, e) = (c[0] - q, c[1] - q, c[2] - q);
    let m = a.abs().max(b.abs()).max(e.abs());
    let cofactors = [cross(b, e), cross(e, a), cross(a, b), 0.0];
    Rounded {
        det: (a.dot(a) * cofactors[0] + b.dot(b) * cofactors[1]) + e.dot(e) * cofactors[2],
        bound: IN_CIRCLE * (m.x * m.y * m.dot(m)),
        cofactors,
        reach: m.max_element(),
    }
}

/// The in-sphere determinant of a tetrahedron and a point of space.
#[inline]
pub fn in_sphere(c: &[DVec3], q: DVec3) -> Rounded {
    let (a, b, e, d) = (c[0] - q, c[1] - q, c[2] - q, c[3] - q);
    let m = a.abs().max(b.abs()).max(e.abs()).max(d.abs());
    let (ab, be, ed) = (minor(a, b), minor(b, e), minor(e, d));
    let (da, ae, bd) = (minor(d, a), minor(a, e), minor(b, d));
    let abe = a.z * be - b.z * ae + e.z * ab;
    let bed = b.z * ed - e.z * bd + d.z * be;
    let eda = e.z * da + d.z * ae + a.z * ed;
    let dab = d.z * ab + a.z * bd + b.z * da;
    Rounded {
        det: (e.dot(e) * dab - d.dot(d) * abe) + (a.dot(a) * bed - b.dot(b) * eda),
        bound: IN_SPHERE * (m.x * m.y * m.z * m.dot(m)),
        cofactors: [bed, -eda, dab, -abe],
        reach: m.max_element(),
    }
}
