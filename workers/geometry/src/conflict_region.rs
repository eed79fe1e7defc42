//! Conflict regions of cells, rounded outwards, and whether they meet a box or one side of a separator.
//!
//! **Statement.** A point `q` conflicts with a finite cell iff it lies in the cell's closed circumball; on the sphere
//! the perturbation decides. It conflicts with an infinite cell only if it lies in the closed half-space beyond the
//! hull facet (Bowyer 1981, Watson 1981). A [`ConflictRegion`] contains all conflicting points in spite of rounding.
//! An answer "does not meet" is therefore certain. An answer "meets" may be wrong because of rounding. A wrong answer
//! costs time but never affects the result.
//!
//! **Derivation.** Let `u = 2^-53`. The differences `e_i = p_i - p_0` have relative errors of at most `u`. The centre
//! relative to `p_0` is `N / (2 D)`. Here `D` is the determinant of the `e_i`, and `N` is the sum of cofactors times
//! the squares `|e_i|^2` ([`Point::sphere_plane`]).
//!
//! 1. A sum of products of at most three differences and one square is within `20 u` of the sum of the absolute values
//!    of its terms. The roundings are three for differences, five for the square, five for products and five for sums.
//!    The bound includes second-order terms.
//! 2. Let `m_k` be the largest `|e_ik|` and `S` the largest square. The absolute values of the `d!` terms add up to at
//!    most `A(D) = d! prod m_k` and `A(N_k) = d! S prod_(l /= k) m_l`.
//! 3. Let `|D| > 64 u A(D)`. By 1 and 2, coordinate `k` of the centre has an error of at most
//!    `20 u (A(N_k) + 2 |c_k| A(D)) / (2 (|D| - 20 u A(D)))`. The roundings of a reciprocal, of a product and of the
//!    sum with `p_0` add to this error.
//! 4. With `64 u` instead of the last `20 u`, the bound grows by more than its own roundings.
//!
//! **Weights** ([`crate::site`]). The region contains every conflicting site of weight at most `m`. Its squared radius is
//! `|p - c|^2 + m - w` for any corner. The squares `|e_i|^2` become `|e_i|^2 - (w_i - w_0)`. These have two more roundings,
//! and `S` is the largest sum of a square and an absolute difference of weights. Differences of images have errors of
//! `4 u` if no low part is more than half the largest difference on an axis; otherwise the region is all of space. So
//! `20 u` becomes `40 u`. The high part of an image at `x` is within `u |x|` of it, so regions and boxes grow by that.
//!
//! If `|D| <= 64 u A(D)`, the region is all of space.
//!
//! **Work and depth.** O(1).

use crate::neighbourhood::box_dist2;
use crate::point::{Point, dist2};
use crate::separator::{Separator, Side};
use crate::site::largest_low;

/// The unit roundoff.
const U: f64 = f64::EPSILON / 2.0;

/// A set that contains every point in conflict with a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConflictRegion<P> {
    /// A closed ball.
    Ball {
        /// Centre of the ball.
        centre: P,
        /// Radius of the ball.
        radius: f64,
    },
    /// A half-space with a margin for rounding: `{ x : normal . (x - anchor) + slack . |x - anchor| >= 0 }`.
    HalfSpace {
        /// A vertex of the hull facet.
        anchor: P,
        /// Normal vector that points away from the hull.
        normal: P,
        /// Bound on the error of each coordinate of the normal.
        slack: P,
    },
    /// All of space, for a cell that is too flat for a bound.
    Everywhere,
}

impl<P: Point> ConflictRegion<P> {
    /// Computes the region of a finite, positively oriented cell of `DIM + 1` points, for points of weight at most
    /// `heaviest`: 0 without weights.
    pub fn of_cell(cell: &[P], heaviest: f64) -> Self {
        let (rel, largest) = differences(cell);
        let (det, numerator) = P::sphere_plane(&rel[..P::DIM]);
        let factorial = if P::DIM == 3 { 6.0 } else { 2.0 };
        let terms = factorial * (0..P::DIM).map(|k| largest.coord(k)).product::<f64>();
        let margin = det.abs() - 64.0 * U * terms;
        if margin.is_nan() || margin <= 0.0 || !is_wide(cell, largest) {
            return ConflictRegion::Everywhere;
        }
        let square = rel.iter().fold(0.0, |largest: f64, e| largest.max(e.norm2() + e.weight().abs()));
        let (roundings, of_size) = if P::IS_WEIGHTED { (40.0, 16.0) } else { (20.0, 4.0) };
        let offset = numerator * (0.5 / det);
        let centre = cell[0] + offset;
        let (mut error, mut size) = (0.0, 0.0);
        for k in 0..P::DIM {
            let (along, cofactor) = (offset.coord(k).abs(), factorial * square * product_without(largest, k));
            error += cofactor + 2.0 * along * terms;
            size += centre.coord(k).abs() + along;
        }
        let slack = roundings * U * error / (2.0 * margin) + of_size * U * size;
        // Every vertex is on the sphere. So the radius is at most the distance of the farthest vertex from the rounded
        // centre, plus the error of the centre. With weights, a vertex has a height above the sphere's space.
        let above2 = |p: P| if P::IS_WEIGHTED { heaviest - p.weight() } else { 0.0 };
        let farthest2 =
            cell[..=P::DIM].iter().fold(0.0, |largest: f64, &p| largest.max(dist2(p, centre) + above2(p)));
        let radius = (farthest2.sqrt() + 2.0 * slack) * (1.0 + 16.0 * U);
        if radius.is_finite() { ConflictRegion::Ball { centre, radius } } else { ConflictRegion::Everywhere }
    }

    /// Computes the region of an infinite cell. `facet` has the `DIM` points of its hull facet, ordered so that
    /// `(facet.., q)` is positive for a point `q` beyond it.
    pub fn of_facet(facet: &[P]) -> Self {
        let mut corners = [facet[0]; 4];
        corners[..P::DIM].copy_from_slice(&facet[..P::DIM]);
        let (rel, largest) = differences(&corners[..=P::DIM]);
        if !is_wide(&facet[..P::DIM], largest) {
            return ConflictRegion::Everywhere;
        }
        let mut slack = P::default();
        for k in 0..P::DIM {
            slack.set_coord(k, 32.0 * U * product_without(largest, k));
        }
        ConflictRegion::HalfSpace { anchor: facet[0], normal: P::hull_normal(&rel[..P::DIM - 1]), slack }
    }

    /// Returns `true` if the region may contain a point of the box with the corners `low` and `high`.
    pub fn meets_box(&self, low: P, high: P) -> bool {
        match *self {
            ConflictRegion::Everywhere => true,
            ConflictRegion::Ball { centre, radius } => {
                // A comparison with NaN is false, so NaN counts as "meets".
                let clear = box_dist2(centre, low, high) > radius * radius * (1.0 + 16.0 * U);
                !clear
            }
            ConflictRegion::HalfSpace { anchor, normal, slack } => {
                let (mut largest, mut size) = (0.0, 0.0);
                for i in 0..P::DIM {
                    let (n, a) = (normal.coord(i), anchor.coord(i));
                    let mut ends = [low.coord(i) - a, high.coord(i) - a];
                    if P::IS_WEIGHTED {
                        let wide = 8.0 * U * low.coord(i).abs().max(high.coord(i).abs()).max(a.abs());
                        ends = [ends[0] - wide, ends[1] + wide];
                    }
                    let side = |x: f64| n * x + slack.coord(i) * x.abs();
                    largest += side(ends[0]).max(side(ends[1]));
                    size += n.abs() * ends[0].abs().max(ends[1].abs());
                }
                let clear = largest < -(32.0 * U) * size;
                !clear
            }
        }
    }

    /// Returns `true` if the region may contain a point of the box on the given side of the separator.
    pub fn meets(&self, separator: &Separator<P>, side: Side, low: P, high: P) -> bool {
        if !self.meets_box(low, high) {
            return false;
        }
        match *self {
            ConflictRegion::Ball { centre, radius } => separator.reaches(centre, radius, side),
            ConflictRegion::HalfSpace { .. } | ConflictRegion::Everywhere => true,
        }
    }
}

/// Returns `true` if the low parts of points are so small that the differences of the points are accurate on each axis.
fn is_wide<P: Point>(points: &[P], largest: P) -> bool {
    let low = largest_low(points);
    low == 0.0 || (0..P::DIM).all(|i| 2.0 * low <= largest.coord(i))
}

/// Returns the vectors from the first corner to the others, and the largest absolute value of each of their
/// coordinates.
fn differences<P: Point>(cell: &[P]) -> ([P; 3], P) {
    let mut rel = [P::default(); 3];
    let mut largest = P::default();
    for (e, &p) in rel.iter_mut().zip(&cell[1..]) {
        *e = p - cell[0];
        for k in 0..P::DIM {
            largest.set_coord(k, largest.coord(k).max(e.coord(k).abs()));
        }
    }
    (rel, largest)
}

/// Computes the product of all coordinates except coordinate `k`.
fn product_without<P: Point>(largest: P, k: usize) -> f64 {
    (0..P::DIM).filter(|&l| l != k).map(|l| largest.coord(l)).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicates::{Sign, in_sphere, orientation};
    use glam::{DVec2, DVec3};
    use rand::{Rng, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn draw<P: Point>(rng: &mut impl Rng, flat: f64) -> P {
        let mut p = P::default();
        for i in 0..P::DIM {
            let scale = if i + 1 == P::DIM { flat } else { 1.0 };
            p.set_coord(i, (rng.random::<f64>() - 0.5) * scale + 1.0);
        }
        p
    }

    fn check_regions<P: Point>(seed: u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut met = 0;
        for round in 0..40_000 {
            let flat = 0.1f64.powi(round % 17);
            let mut cell: Vec<P> = (0..=P::DIM).map(|_| draw(&mut rng, flat)).collect();
            match orientation(&cell) {
                Sign::Zero => continue,
                Sign::Negative => cell.swap(0, 1),
                Sign::Positive => {}
            }
            let q: P = draw(&mut rng, flat);
            if in_sphere(&cell, q) {
                assert!(ConflictRegion::of_cell(&cell, 0.0).meets_box(q, q), "{cell:?} {q:?}");
                met += 1;
            }
            let mut beyond = cell.clone();
            beyond[P::DIM] = q;
            if orientation(&beyond) != Sign::Negative {
                assert!(ConflictRegion::of_facet(&cell[..P::DIM]).meets_box(q, q), "{cell:?} {q:?}");
                met += 1;
            }
        }
        assert!(met > 4_000, "{met}");
    }

    #[test]
    fn regions_contain_all_conflicts() {
        check_regions::<DVec3>(1);
        check_regions::<DVec2>(2);
    }

    #[test]
    fn distant_boxes_do_not_meet() {
        let cell = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let region = ConflictRegion::of_cell(&cell, 0.0);
        assert!(!region.meets_box(DVec3::splat(1.1), DVec3::splat(2.0)));
        assert!(region.meets_box(DVec3::splat(1.0), DVec3::splat(2.0)), "the corner lies on the sphere");
        let below = ConflictRegion::of_facet(&[DVec3::ZERO, DVec3::Y, DVec3::X]);
        assert!(below.meets_box(DVec3::new(0., 0., -1.), DVec3::new(0., 0., -0.5)));
        assert!(!below.meets_box(DVec3::new(0., 0., 0.5), DVec3::ONE));
        assert!(below.meets_box(DVec3::new(4., 4., 0.0), DVec3::new(4., 4., 1.0)), "coplanar counts");
        let flat = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE - DVec3::Z];
        assert_eq!(ConflictRegion::of_cell(&flat, 0.0), ConflictRegion::Everywhere);
    }

    #[test]
    fn separators_cut_conflict_regions() {
        let cell = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let cut = Separator::plane(0, 3.0);
        let (low, high) = (DVec3::splat(-9.0), DVec3::splat(9.0));
        let region = ConflictRegion::of_cell(&cell, 0.0);
        assert!(
            region.meets(&cut, Side::Interior, low, high) && !region.meets(&cut, Side::Exterior, low, high)
        );
    }
}
