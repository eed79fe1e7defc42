//! Bodies: a closed surface with limbs and a little noise, like the scan of a figure.
//!
//! **Statement.** A body is the union of *limbs*. A limb is all that lies within a radius of a segment. A candidate is a uniform
//! point that lies near the surface of the limb that is nearest to it. It moves to this surface, and is dropped if it then lies in
//! another limb. A quadratic map bends the body, so that no cross section is round: on a round one, all points would have one
//! circumcentre. Noise moves each point along the normal, by at most [`NOISE`].
//!
//! Cells of the interior have circumspheres that touch opposite sides of the body. Nearest neighbours all lie on one side.
//!
//! **Work.** O(1) expected per point.

use septet_geometry::point::Point;

use super::draw::Draw;

/// A limb: the two ends of its segment and its radius.
type Limb = ([f64; 3], [f64; 3], f64);

/// Trunk, head, two arms, two legs and a tail.
const LIMBS: [Limb; 7] = [
    ([0.50, 0.50, 0.42], [0.50, 0.50, 0.62], 0.17),
    ([0.54, 0.50, 0.84], [0.60, 0.50, 0.86], 0.09),
    ([0.40, 0.40, 0.66], [0.16, 0.26, 0.60], 0.055),
    ([0.62, 0.60, 0.64], [0.84, 0.74, 0.54], 0.05),
    ([0.42, 0.46, 0.32], [0.36, 0.40, 0.09], 0.07),
    ([0.58, 0.56, 0.32], [0.64, 0.62, 0.09], 0.065),
    ([0.44, 0.56, 0.34], [0.26, 0.80, 0.26], 0.035),
];

/// The largest distance of a candidate from the surface of its limb.
const NEAR: f64 = 0.02;

/// The largest distance by which noise moves a point.
const NOISE: f64 = 2e-4;

/// Generates `n` points of a body.
pub(super) fn points<P: Point>(n: u64, draw: &mut Draw) -> Vec<P> {
    (0..n).map(|_| bent(on_surface(draw))).collect()
}

/// Draws a point of the surface of the union of all limbs.
fn on_surface<P: Point>(draw: &mut Draw) -> P {
    let limbs = LIMBS
        .map(|(from, to, radius)| (P::from_coords(&from[..P::DIM]), P::from_coords(&to[..P::DIM]), radius));
    // In the plane, the last axis is dropped and limbs may overlap, but some surface remains.
    loop {
        let x: P = draw.point();
        let above = limbs.map(|limb| height(x, limb));
        let (mut nearest, mut least) = (0, f64::INFINITY);
        for (at, &height) in above.iter().enumerate() {
            if height < least {
                (nearest, least) = (at, height);
            }
        }
        let (from, to, radius) = limbs[nearest];
        let foot = foot(x, from, to);
        let away = (x - foot).norm2().sqrt();
        if least.abs() > NEAR || away < radius / 2.0 {
            continue;
        }
        let normal = (x - foot) / away;
        let surface = foot + normal * radius;
        let is_free = |at: usize| at == nearest || height(surface, limbs[at]) > 0.0;
        if (0..limbs.len()).all(is_free) {
            return surface + normal * (NOISE * (2.0 * draw.unit() - 1.0));
        }
    }
}

/// Returns the height of a point above the surface of a limb, negative inside.
fn height<P: Point>(x: P, (from, to, radius): (P, P, f64)) -> f64 {
    (x - foot(x, from, to)).norm2().sqrt() - radius
}

/// Returns the point of a segment nearest to `x`.
fn foot<P: Point>(x: P, from: P, to: P) -> P {
    let (along, across) = (to - from, x - from);
    let length2 = along.norm2();
    let share = if length2 > 0.0 { along.dot(across) / length2 } else { 0.0 };
    from + along * share.clamp(0.0, 1.0)
}

/// Bends a point of the unit cube, within the unit cube.
fn bent<P: Point>(x: P) -> P {
    let (u, v, last) = (x.coord(0) - 0.5, x.coord(1) - 0.5, x.coord(P::DIM - 1) - 0.5);
    let mut bent = x;
    bent.set_coord(0, 0.5 + u + 0.3 * last * last - 0.04);
    bent.set_coord(1, 0.5 + 0.7 * v + 0.4 * u * u + 0.2 * u * last - 0.03);
    bent
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::generate::draw::Purpose;

    fn check<P: Point>() {
        let points = points::<P>(2000, &mut Draw::new(3, Purpose::Points));
        assert_eq!(points.len(), 2000);
        let inside = |x: &P| (0..P::DIM).all(|axis| (0.0..=1.0).contains(&x.coord(axis)));
        assert!(points.iter().all(inside));
        // The map changes the first two coordinates by functions of the others, so distinct points stay distinct.
        let again = super::points::<P>(2000, &mut Draw::new(3, Purpose::Points));
        assert!(points == again);
    }

    #[test]
    fn bodies_lie_in_the_unit_cube() {
        check::<DVec3>();
        check::<DVec2>();
    }
}
