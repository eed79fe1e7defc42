//! Rounded spheres compared with the exact predicate, for points almost on them.

use super::super::cells::Cell;
use super::super::cells::NO_SPHERE;
use super::*;
use crate::incremental::sphere::Frame;
use crate::point::Point;
use crate::point::Simplex;
use crate::predicates::Sign;
use crate::predicates::orientation;

/// Counts of the decisions of spheres.
#[derive(Debug, Default)]
struct Said {
    decided: usize,
    /// Undecided tests that rounding without a bound would have decided wrongly.
    saved: usize,
    asked: usize,
}

fn ask<P: Point>(random: &mut Draw, offset: f64, size: f64, off: f64, said: &mut Said) {
    let point = |random: &mut Draw| {
        let coords = [random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5];
        P::from_coords(&coords[..P::DIM]) * size + P::splat(offset)
    };
    let n = P::DIM + 1;
    let mut corners: Vec<P> = (0..n).map(|_| point(random)).collect();
    match orientation(&corners) {
        Sign::Positive => {}
        Sign::Negative => corners.swap(0, 1),
        Sign::Zero => return,
    }
    let mut around: Vec<P> = (0..7).map(|_| P::splat(0.0)).collect();
    around.push(P::splat(1.0));
    let frame = Frame::over(&around, 0.0);
    let ends: Vec<_> = (1..4).map(|i| frame.inverse(corners[0], corners[i.min(P::DIM)])).collect();
    let sphere = frame.query(corners[0]).sphere([&ends[0], &ends[1], &ends[2]]);
    if sphere.as_ref()[P::DIM] == NO_SPHERE {
        return;
    }
    let cell = Cell::new(sphere, P::Cell::splat(0), P::Cell::splat(0));
    // The point is placed on the sphere, as accurately as its centre is known, and moved off it by at most `off / 2`
    // radii.
    let (centre, _) = frame.ball(&sphere).unwrap();
    let rel = point(random) - P::splat(offset);
    let radius = crate::point::dist2(centre, corners[0]).sqrt();
    let q = centre + rel * (radius / rel.norm2().sqrt()) * (1.0 + off * (random.unit() - 0.5));
    if corners.contains(&q) {
        return;
    }
    let inside = in_sphere(&corners, q);
    let power = frame.query(q).power(&cell);
    said.asked += 1;
    if power.is_inside() || power.is_outside() {
        said.decided += 1;
        assert_eq!(power.is_inside(), inside, "{corners:?} {q:?}");
    } else if (power.value < 0.0) != inside {
        said.saved += 1;
    }
}

fn no_decided_sign_is_wrong<P: Point>() {
    let mut random = Draw::new(77);
    for offset in [0.0, 1e-3, 0.7, 40.0] {
        for size in [1.0, 1e-2, 1e-4, 1e-7] {
            // Errors are proportional to the distance from the origin, relative to the radius.
            let scale = 1.2e-7 * (1.0 + offset / size);
            for off in [0.1, 1.0, 4.0, 20.0, 1000.0] {
                let mut said = Said::default();
                for _ in 0..700 {
                    ask::<P>(&mut random, offset, size, off * scale, &mut said);
                }
                let place = format!("{offset} {size} {off} {said:?}");
                assert!(said.asked > 500, "{place}");
                assert!(off > 1.0 || said.saved > 10, "the test is too easy: {place}");
                assert!(off < 1000.0 || said.decided > said.asked / 2, "the bound is too wide: {place}");
            }
        }
    }
}

#[test]
fn spheres_of_space_decide_nothing_wrong() {
    no_decided_sign_is_wrong::<DVec3>();
}

#[test]
fn circles_of_the_plane_decide_nothing_wrong() {
    no_decided_sign_is_wrong::<DVec2>();
}

/// Cells have spheres even in very fine sets.
#[test]
fn fine_sets_have_spheres() {
    for size in [1.0, 1e-3, 1e-6, 1e-9] {
        let mut random = Draw::new(4);
        let mut points: Vec<DVec2> =
            (0..300).map(|_| DVec2::new(random.unit(), random.unit()) * size).collect();
        points.push(DVec2::ONE);
        points.push(-DVec2::ONE);
        let dt = Incremental::new(points).unwrap();
        let finite: Vec<u32> = dt.complex().live_cells().filter(|&c| !dt.complex().is_infinite(c)).collect();
        let known = finite.iter().filter(|&&c| dt.ball(c).is_some()).count();
        assert!(known * 10 > finite.len() * 9, "{size}: {known} of {}", finite.len());
    }
}

/// Every radius up to a threshold satisfies the distance bound, and the threshold admits nearly all such radii. This
/// holds at any scale, and for cells far smaller than the set.
fn check_radius_thresholds<P: Point>() {
    let mut random = Draw::new(19);
    for size in [1e-300, 1e-20, 1.0, 1e20, 1e300] {
        let mut draw = || P::from_coords(&[0; 3].map(|_: i32| random.unit() * size)[..P::DIM]);
        let wide: Vec<P> = (0..400).map(|_| draw()).collect();
        let fine = (0..400).map(|_| P::splat(size) + draw() * 1e-6);
        let points: Vec<P> = wide.into_iter().chain(fine).collect();
        let dt = Incremental::new(points).unwrap();
        let (mut within, mut smaller) = (0, 0);
        let bounds = dt.complex().live_cells().map(|c| (dt.rounded_radius(c), 2.0 * dt.radius_bound(c)));
        for (radius, across) in bounds {
            let holds = |part: f64| radius <= dt.radius_within(across * part);
            if across.is_nan() {
                assert!(radius.is_nan());
                // No threshold admits a cell without a sphere.
                assert!([0.5, 1.0].iter().all(|&part| !holds(part)));
                continue;
            }
            for part in [0.0, 0.5, 1.0 - 1e-9, 1.0 - f64::EPSILON] {
                assert!(!holds(part), "{radius} within {part} of {across}");
            }
            assert!(holds(f64::INFINITY), "{radius} within nothing");
            if across < 1e-3 * size {
                smaller += 1;
            } else {
                assert!(holds(1.0 + 1e-6), "{radius} not within {across}");
                within += 1;
            }
        }
        assert!(within > 400 && smaller > 400, "{size}: {within} {smaller}");
        assert_eq!([f64::NAN, -1.0, 0.0].map(|across| dt.radius_within(across)), [0.0; 3]);
    }
}

#[test]
fn radius_thresholds_are_valid_and_tight() {
    check_radius_thresholds::<DVec3>();
    check_radius_thresholds::<DVec2>();
}
