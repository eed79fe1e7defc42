//! The set does not depend on the machine, and the callback may cancel the generation.

use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::DVec3;
use septet_meshing::generate::Alone;

use super::super::sizing::Centre;
use super::*;

/// Generates a set on one processor without messages, on machines of one and three workers, and through the public
/// function. All four are equal.
fn is_the_same_for_every_machine<P: Unit>(sizing: Sizing, seed: u64) -> usize {
    let domain = P::domain().unwrap();
    let alone: Vec<P> = set(&domain, sizing, seed, &mut Alone { seed }).unwrap();
    for workers in [1, 3] {
        let mut counted = CountedMachine::new(machine(seed, workers, Arc::default()));
        let made: Vec<P> = set(&domain, sizing, seed, &mut counted).unwrap();
        assert!(made == alone, "{workers} workers, {sizing:?}");
    }
    let mut last = 0;
    let made: Vec<P> = build(sizing, seed, &mut |points| last = points).unwrap();
    assert!(made == alone && last <= made.len() as u64);
    made.len()
}

#[test]
fn the_set_is_the_same_for_every_machine() {
    for (slope, least) in [(0.0, 0.09), (0.25, 0.01), (0.5, 0.003)] {
        for centre in [Centre::Point, Centre::Line] {
            let sizing = Sizing { centre, slope, least };
            let count = is_the_same_for_every_machine::<DVec3>(sizing, 7);
            assert!(count > 200, "{sizing:?}: {count}");
            let count = is_the_same_for_every_machine::<DVec2>(sizing, 7);
            assert!(count > 50, "{sizing:?}: {count}");
        }
    }
}

#[test]
fn a_callback_that_unwinds_cancels_the_generation() {
    let sizing = Sizing { centre: Centre::Point, slope: 0.0, least: 0.02 };
    let mut calls = 0;
    let ended = catch_unwind(AssertUnwindSafe(|| {
        build::<DVec3>(sizing, 1, &mut |points| {
            calls += 1;
            if points > 8 {
                resume_unwind(Box::new(points));
            }
        })
    }));
    let points = *ended.unwrap_err().downcast::<u64>().unwrap();
    // Sizes of 0.02 give some 100,000 points.
    assert!(calls > 0 && (9..50_000).contains(&points), "{points} points after {calls} calls");
}
