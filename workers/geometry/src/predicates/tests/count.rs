//! The number of exact tests, compared with the calls that the filter leaves undecided.

use glam::{DVec2, DVec3};

use super::*;
use crate::cost::Cost;
use crate::hull::StarBuilder;
use crate::incremental::Incremental;
use crate::incremental::tests::nasty::{KINDS, set};

/// Calls both predicates for every cell of consecutive points and every further point. Returns the exact tests that the
/// thread counted, and the number of calls that the filter did not decide.
fn counted_and_undecided<P: Point>(points: &[P]) -> [u64; 2] {
    let mut undecided = 0;
    let before = ExactTests::so_far();
    for (at, cell) in points.windows(P::DIM + 1).enumerate() {
        let mut cell = cell.to_vec();
        undecided += u64::from(!P::rounded_orientation(&cell).is_certain());
        match orientation(&cell) {
            Sign::Zero => continue,
            Sign::Negative => cell.swap(0, 1),
            Sign::Positive => {}
        }
        for &q in points[..at].iter().chain(&points[at + P::DIM + 1..]) {
            undecided += u64::from(!P::rounded_in_sphere(&cell, q).is_certain());
            in_sphere(&cell, q);
        }
    }
    [before.since().count(), undecided]
}

fn of_every_kind<P: Point>() {
    let mut found = Vec::new();
    for kind in KINDS {
        let [counted, undecided] = counted_and_undecided(&set::<P>(kind, 40, 5));
        assert_eq!(counted, undecided, "{kind}");
        found.push((kind, counted));
    }
    let of = |kind| found.iter().find(|(of, _)| *of == kind).map(|(_, count)| *count);
    assert_eq!(of("random"), Some(0));
    assert!(of("grid") > Some(0), "{found:?}");
}

#[test]
fn undecided_calls_are_exact_tests() {
    of_every_kind::<DVec2>();
    of_every_kind::<DVec3>();
}

/// The meters of the kernels have all exact tests of the thread.
fn kernels_charge_them<P: Point>() {
    for (kind, has_some) in [("random", false), ("grid", true), ("sphere", true)] {
        let points = set::<P>(kind, 60, 5);
        let everyone: Vec<u32> = (0..points.len() as u32).collect();
        let (mut builder, mut stars) = (StarBuilder::default(), Cost::default());
        let before = ExactTests::so_far();
        for &v in &everyone {
            builder.build(&points, v, &everyone[..points.len() / 2], &mut stars);
            let mut link = Vec::new();
            builder.facets(&mut link);
            builder.extend(&points, v, &link, &everyone, &mut stars);
        }
        let of_stars = before.since().count();
        let before = ExactTests::so_far();
        let mut insertion = Cost::default();
        Incremental::new(points).unwrap().charge(&mut insertion);
        let counted = [of_stars, before.since().count()];
        assert_eq!([stars, insertion].map(|cost| cost.price().exact_tests()), counted, "{kind}");
        assert_eq!(counted.map(|count| count > 0), [has_some; 2], "{kind}: {counted:?}");
    }
}

#[test]
fn meters_have_the_exact_tests_of_kernels() {
    kernels_charge_them::<DVec2>();
    kernels_charge_them::<DVec3>();
}
