//! Dimensions 4 to 6 against big integers.

use super::samples::{KINDS, Samples};
use super::*;
use crate::higher::VecN;
use crate::point::dist2;
use crate::predicates::general::{plane, sphere_plane};

/// All signs are exact, and ties follow the statement.
fn signs_are_exact<P: Point>(calls: usize) {
    let mut samples = Samples::new(31);
    let (mut ties, mut flat) = (0, 0);
    for kind in KINDS {
        for _ in 0..calls {
            let (cell, q) = samples.call::<P>(kind);
            let sign = exact::orientation(&cell);
            assert_eq!(orientation(&cell), sign, "{kind:?} {cell:?}");
            let n = 1 + samples.below(P::DIM as u64) as usize;
            if n == 1 || exact::is_outside(&cell[..n - 1], cell[n - 1]) {
                let expected = exact::is_outside(&cell[..n], q);
                assert_eq!(raises_dimension(&cell[..n], q), expected, "{kind:?} {cell:?} {q:?}");
            }
            if sign == Sign::Zero {
                flat += 1;
                continue;
            }
            ties += usize::from(exact::in_sphere(&cell, q) == Sign::Zero);
            assert_eq!(in_sphere(&cell, q), exact::conflicts(&cell, q), "{kind:?} {cell:?} {q:?}");
        }
    }
    assert!(ties > 0 && ties + flat > calls / 10, "{ties} ties and {flat} flat cells");
}

#[test]
fn signs_of_dimension_4_are_exact() {
    signs_are_exact::<VecN<4>>(300);
}

#[test]
fn signs_of_dimension_5_are_exact() {
    signs_are_exact::<VecN<5>>(150);
}

#[test]
fn signs_of_dimension_6_are_exact() {
    signs_are_exact::<VecN<6>>(60);
}

/// The rounded forms have the signs of the predicates.
fn forms_agree<P: Point>() {
    let mut draw = crate::hash::Draw::new(8);
    for _ in 0..200 {
        let origin = P::default();
        let mut rel: Vec<P> = (0..P::DIM).map(|_| draw.point::<P>() - P::splat(0.4)).collect();
        let cell = |rel: &[P]| [&[origin], rel].concat();
        if orientation(&cell(&rel)) == Sign::Negative {
            rel.swap(0, 1);
        }
        let q = draw.point::<P>() - P::splat(0.3);
        let (w, v) = sphere_plane(&rel);
        assert_eq!(w * q.norm2() - v.dot(q) < 0.0, in_sphere(&cell(&rel), q));
        let centre = v / (2.0 * w);
        assert!(rel.iter().all(|&p| (dist2(p, centre) / centre.norm2() - 1.0).abs() < 1e-6));
        let mut beyond = rel.clone();
        beyond[P::DIM - 1] = q;
        let normal = P::hull_normal(&rel[..P::DIM - 1]);
        assert_eq!(normal.dot(q) > 0.0, orientation(&cell(&beyond)) == Sign::Positive);
        // Infinity is the vector 0 with the lift 1.
        let slot = draw.below(P::DIM);
        let (w, normal) = plane(|i| if i == slot { (origin, 1.0) } else { (rel[i], rel[i].norm2()) });
        let along: f64 = normal.as_ref().iter().enumerate().map(|(axis, m)| m.value * q.coord(axis)).sum();
        let mut replaced = rel.clone();
        replaced[slot] = q;
        assert_eq!((w.value, along > 0.0), (0.0, orientation(&cell(&replaced)) == Sign::Positive));
    }
}

#[test]
fn forms_agree_with_the_predicates() {
    forms_agree::<VecN<4>>();
    forms_agree::<VecN<5>>();
    forms_agree::<VecN<6>>();
}
