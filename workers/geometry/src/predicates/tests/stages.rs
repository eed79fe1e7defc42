//! Each stage alone, and all stages together, compared with big integers.

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::samples::{KINDS, Kind, Samples, two_to};
use super::*;
use crate::predicates::lattice::{integer, is_exact, largest_unit, quick_integer, quick_unit, width};

fn all<P: Point>(cell: &[P], q: P) -> Vec<P> {
    let mut points = cell.to_vec();
    points.push(q);
    points
}

/// Number of calls that each stage could decide: filter, exact doubles, narrow, single, double, expansion.
type Decided = [usize; 6];

fn check_orientation<P: Point>(cell: &[P], decided: &mut Decided) {
    let expected = exact::orientation(cell);
    let rounded = P::rounded_orientation(cell);
    let (others, base) = (&cell[..P::DIM], cell[P::DIM]);
    if rounded.is_certain() {
        decided[0] += 1;
        assert_eq!(Sign::of(rounded.det), expected, "filter: {cell:?}");
    }
    if is_exact(cell, rounded.reach, EXACT_ORIENTATION[P::DIM - 2]) {
        decided[1] += 1;
        assert_eq!(Sign::of(rounded.det), expected, "exact doubles: {cell:?}");
    }
    let unit = quick_unit(cell);
    if width(rounded.reach, unit) <= 62 {
        decided[2] += 1;
        let rows = integer::rows(others, base, |x| quick_integer(x, unit));
        assert_eq!(integer::orient::<1, 2, 3>(&rows, P::DIM), expected, "quick: {cell:?}");
    }
    let unit = largest_unit(cell);
    if width(rounded.reach, unit) <= 62 {
        decided[3] += 1;
        let rows = integer::rows(others, base, |x| integer(x, unit));
        assert_eq!(integer::orient::<1, 2, 3>(&rows, P::DIM), expected, "single: {cell:?}");
    }
    if width(rounded.reach, unit) <= 126 {
        decided[4] += 1;
        let rows = integer::rows(others, base, |x| integer(x, unit));
        assert_eq!(integer::orient::<2, 4, 6>(&rows, P::DIM), expected, "double: {cell:?}");
    }
    decided[5] += 1;
    assert_eq!(expansion::orientation(cell), expected, "expansion: {cell:?}");
    assert_eq!(orientation(cell), expected, "{cell:?}");
    let mut turned = cell.to_vec();
    turned.swap(0, 1);
    assert_eq!(orientation(&turned), expected.opposite(), "{turned:?}");
}

fn check_in_sphere<P: Point>(cell: &[P], q: P, decided: &mut Decided) {
    let replaced = |i: usize| exact::orientation(&exact::replaced(cell, i, q));
    let mut expected = Signs { det: exact::in_sphere(cell, q), cofactors: [Sign::Zero; 4] };
    for i in 0..=P::DIM {
        expected.cofactors[i] = replaced(i);
    }
    let rounded = P::rounded_in_sphere(cell, q);
    let points = all(cell, q);
    if rounded.is_certain() {
        decided[0] += 1;
        assert_eq!(Sign::of(rounded.det), expected.det, "filter: {points:?}");
    }
    if is_exact(&points, rounded.reach, EXACT_IN_SPHERE[P::DIM - 2]) {
        decided[1] += 1;
        let signs = Signs { det: Sign::of(rounded.det), cofactors: rounded.cofactors.map(Sign::of) };
        assert_eq!(signs, expected, "exact doubles: {points:?}");
    }
    check_integers(cell, q, rounded.reach, expected, decided);
    decided[5] += 1;
    let signs = expansion::conflict(cell, q);
    assert_eq!(signs.det, expected.det, "expansion: {points:?}");
    if signs.det == Sign::Zero {
        assert_eq!(signs.cofactors, expected.cofactors, "expansion: {points:?}");
    }
    if exact::orientation(cell) == Sign::Positive {
        assert_eq!(in_sphere(cell, q), exact::conflicts(cell, q), "{points:?}");
        let mut turned = cell.to_vec();
        turned[..3].rotate_left(1);
        assert_eq!(in_sphere(&turned, q), in_sphere(cell, q), "{points:?}");
    }
}

fn check_integers<P: Point>(cell: &[P], q: P, reach: f64, expected: Signs, decided: &mut Decided) {
    let points = all(cell, q);
    let narrow = if P::DIM == 2 { 30 } else { 24 };
    let unit = largest_unit(&points);
    let bits = width(reach, unit);
    if bits <= narrow {
        decided[2] += 1;
        let rows = integer::rows(cell, q, |x| integer(x, unit));
        assert_eq!(integer::conflict_narrow::<P>(&rows), expected, "narrow: {points:?}");
    }
    if bits <= 62 {
        decided[3] += 1;
        let rows = integer::rows(cell, q, |x| integer(x, unit));
        assert_eq!(integer::conflict_single::<P>(&rows), expected, "single: {points:?}");
    }
    if bits <= 126 {
        decided[4] += 1;
        let rows = integer::rows(cell, q, |x| integer(x, unit));
        assert_eq!(integer::conflict_double::<P>(&rows), expected, "double: {points:?}");
        assert_eq!(integer::conflict(cell, q, reach), Some(expected), "chosen width: {points:?}");
    }
}

/// Checks all stages on calls of a kind. Counts the calls that each stage could decide: orientations, then in-sphere
/// tests.
fn check_kind<P: Point>(kind: Kind, calls: usize) -> (Decided, Decided) {
    let mut samples = Samples::new(11);
    let (mut orientations, mut in_spheres) = ([0; 6], [0; 6]);
    for _ in 0..calls {
        let (cell, q) = samples.call::<P>(kind);
        check_orientation(&cell, &mut orientations);
        check_in_sphere(&cell, q, &mut in_spheres);
    }
    (orientations, in_spheres)
}

/// Checks every kind. Each kind must supply enough calls to its stages for a meaningful test.
fn check_kinds<P: Point>() {
    let calls = 1500;
    for kind in KINDS {
        let (orientations, in_spheres) = check_kind::<P>(kind, calls);
        for decided in [orientations, in_spheres] {
            let [filter, exact, narrow, single, double, _] = decided;
            match kind {
                Kind::Random => assert!(filter > calls * 9 / 10 && double == calls, "{decided:?}"),
                Kind::Cospherical | Kind::Highest => assert!(double == calls, "{decided:?}"),
                Kind::Coplanar => assert!(double > calls * 9 / 10, "{decided:?}"),
                Kind::Grid | Kind::Lowest => assert!(exact == calls && narrow == calls, "{decided:?}"),
                Kind::FarGrid | Kind::Decimal => assert!(single == calls, "{kind:?} {decided:?}"),
                Kind::Single => assert!(single > calls * 9 / 10, "{decided:?}"),
                Kind::Spread => assert!(single < double && double == calls, "{decided:?}"),
                Kind::Wild => assert!(double < calls / 2, "{decided:?}"),
            }
        }
        if kind == Kind::Cospherical {
            assert!(in_spheres[0] < calls * 3 / 4, "the filter should fail: {in_spheres:?}");
        }
        if kind == Kind::Coplanar {
            assert!(orientations[0] < calls * 3 / 4, "the filter should fail: {orientations:?}");
        }
    }
}

#[test]
fn every_stage_is_exact_in_space() {
    check_kinds::<DVec3>();
}

#[test]
fn every_stage_is_exact_in_the_plane() {
    check_kinds::<DVec2>();
}

#[test]
fn scaled_sets_keep_their_signs() {
    let mut samples = Samples::new(5);
    for factor in [1e-120, 1e120, 1e-300] {
        for kind in [Kind::Cospherical, Kind::Coplanar, Kind::Decimal, Kind::Random] {
            for _ in 0..60 {
                let (cell, q) = samples.call::<DVec3>(kind);
                let points: Vec<DVec3> = all(&cell, q).into_iter().map(|p| p * factor).collect();
                let exponent = crate::range::scale_exponent(&points).unwrap();
                let points: Vec<DVec3> = points.iter().map(|&p| crate::range::scale(p, exponent)).collect();
                let mut decided = [0; 6];
                check_orientation(&points[..4], &mut decided);
                if points[..4].iter().all(|p| *p != points[4]) {
                    check_in_sphere(&points[..4], points[4], &mut decided);
                }
                assert!(decided[4] > 0);
            }
        }
    }
}

/// A coordinate with a significand of few or many bits, and an exponent.
fn coordinate() -> impl Strategy<Value = f64> {
    let bits = prop_oneof![Just(1u32), 2..12u32, Just(24), Just(53)];
    (any::<i64>(), bits, -60..60i32).prop_map(|(digits, bits, e)| (digits >> (64 - bits)) as f64 * two_to(e))
}

fn distinct<P: PartialEq>(points: &[P]) -> bool {
    (0..points.len()).all(|i| !points[..i].contains(&points[i]))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_points_of_space(x in proptest::collection::vec(coordinate(), 15)) {
        let mut points: Vec<DVec3> = x.chunks(3).map(DVec3::from_coords).collect();
        if distinct(&points) {
            if exact::orientation(&points[..4]) == Sign::Negative {
                points.swap(0, 1);
            }
            check_orientation(&points[..4], &mut [0; 6]);
            check_in_sphere(&points[..4], points[4], &mut [0; 6]);
        }
    }

    #[test]
    fn any_points_of_the_plane(x in proptest::collection::vec(coordinate(), 8)) {
        let mut points: Vec<DVec2> = x.chunks(2).map(DVec2::from_coords).collect();
        if distinct(&points) {
            if exact::orientation(&points[..3]) == Sign::Negative {
                points.swap(0, 1);
            }
            check_orientation(&points[..3], &mut [0; 6]);
            check_in_sphere(&points[..3], points[3], &mut [0; 6]);
        }
    }
}
