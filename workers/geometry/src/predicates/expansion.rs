//! Stage 3, the last stage: adaptive expansions of doubles, by the crate `robust` (Shewchuk 1997).
//!
//! **Statement.** Signs are exact if nothing underflows or overflows, which [`crate::range`] guarantees. The stage
//! decides calls whose differences spread over more than 126 binary digits, and takes microseconds for each.

use super::integer::Signs;
use super::sign::Sign;
use crate::point::Point;

fn planar<P: Point>(p: &P) -> robust::Coord<f64> {
    robust::Coord { x: p.coord(0), y: p.coord(1) }
}

fn spatial<P: Point>(p: &P) -> robust::Coord3D<f64> {
    robust::Coord3D { x: p.coord(0), y: p.coord(1), z: p.coord(2) }
}

/// Computes the exact orientation of `DIM + 1` points.
pub(super) fn orientation<P: Point>(c: &[P]) -> Sign {
    Sign::of(if P::DIM == 2 {
        robust::orient2d(planar(&c[0]), planar(&c[1]), planar(&c[2]))
    } else {
        // Shewchuk's `orient3d` has the opposite sign: it is positive if the fourth point lies below.
        -robust::orient3d(spatial(&c[0]), spatial(&c[1]), spatial(&c[2]), spatial(&c[3]))
    })
}

/// Computes the exact in-sphere sign of a cell and a query. The signs of the cofactors are computed only if it is zero.
pub(super) fn conflict<P: Point>(c: &[P], q: P) -> Signs {
    let det = Sign::of(if P::DIM == 2 {
        robust::incircle(planar(&c[0]), planar(&c[1]), planar(&c[2]), planar(&q))
    } else {
        -robust::insphere(spatial(&c[0]), spatial(&c[1]), spatial(&c[2]), spatial(&c[3]), spatial(&q))
    });
    let mut cofactors = [Sign::Zero; 4];
    if det == Sign::Zero {
        for (i, cofactor) in cofactors.iter_mut().enumerate().take(P::DIM + 1) {
            let mut replaced = [q; 4];
            replaced[..=P::DIM].copy_from_slice(c);
            replaced[i] = q;
            *cofactor = orientation(&replaced[..=P::DIM]);
        }
    }
    Signs { det, cofactors }
}
