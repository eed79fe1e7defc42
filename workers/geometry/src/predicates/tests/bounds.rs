//! The error bounds of the filter, near their limits.

use glam::{DVec2, DVec3};

use super::samples::{Kind, Samples};
use super::*;

/// Counts the wrong signs of a filter whose bound is multiplied by `scale`, for determinants near zero.
fn wrong<P: Point>(calls: usize, scale: f64) -> (usize, usize) {
    let mut samples = Samples::new(3);
    let mut wrong = (0, 0);
    let differs = |rounded: &Rounded, exact: Sign| {
        rounded.det.abs() > rounded.bound * scale && Sign::of(rounded.det) != exact
    };
    for i in 0..calls {
        let kind = if i % 2 == 0 { Kind::Cospherical } else { Kind::Coplanar };
        let (cell, q) = samples.call::<P>(kind);
        let rounded = P::rounded_orientation(&cell);
        wrong.0 += usize::from(differs(&rounded, exact::orientation(&cell)));
        let rounded = P::rounded_in_sphere(&cell, q);
        wrong.1 += usize::from(differs(&rounded, exact::in_sphere(&cell, q)));
    }
    wrong
}

#[test]
fn no_sign_beyond_the_bound_is_wrong() {
    assert_eq!(wrong::<DVec3>(60_000, 1.0), (0, 0));
    assert_eq!(wrong::<DVec2>(60_000, 1.0), (0, 0));
}

/// These calls detect a wrong bound: a much smaller bound fails.
#[test]
fn a_bound_too_small_would_show() {
    let (orientations, in_spheres) = wrong::<DVec3>(4_000, 1.0 / 256.0);
    assert!(orientations > 0 && in_spheres > 0, "{orientations} {in_spheres}");
    let (orientations, in_spheres) = wrong::<DVec2>(4_000, 1.0 / 64.0);
    assert!(orientations > 0 && in_spheres > 0, "{orientations} {in_spheres}");
}

/// The bound depends on the call: near a corner of a graded set, the filter decides as often as elsewhere.
#[test]
fn graded_calls_keep_the_filter() {
    let mut samples = Samples::new(9);
    for depth in [0, 20, 40] {
        let size = super::samples::two_to(-depth);
        let certain = (0..2000)
            .filter(|_| {
                let (cell, q) = samples.call::<DVec3>(Kind::Random);
                let cell: Vec<DVec3> = cell.iter().map(|&p| p * size).collect();
                DVec3::rounded_in_sphere(&cell, q * size).is_certain()
            })
            .count();
        assert!(certain > 1990, "{certain} at 2^-{depth}");
    }
}
