//! Phase `load` on machines of several workers.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::hash::{finalise, hash_of_place};
use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::range::RangeError;
use septet_protocol::ids::Phase;

use super::{Loaded, Rows, Source};
use crate::config::{Task, WorkerConfig};
use crate::hosts::host::{Job, Unwatched};
use crate::hosts::transport::{TransportKind, machine};
use crate::partition::leader::Plan;

struct Whole<'a, P>(&'a [P]);

impl<P: Point> Source<P> for Whole<'_, P> {
    fn block(&self, block: u32, blocks: u32) -> Rows<P> {
        Rows::of_whole(0, self.0, &[], block, blocks)
    }
}

/// Loads points on some workers. Returns the description of the input, with the lists of all ranks.
fn loaded<P: Point>(points: &[P], skips_invalid: bool, workers: u32) -> Loaded {
    let task = Task::Delaunay { skips_invalid };
    let until = Some(Phase::Partition);
    let config = WorkerConfig { workers, task, until, counted: false, ..WorkerConfig::plain() };
    let job = Job { config: Arc::new(config), source: &Whole(points), plan: &Plan::new() };
    let kind = TransportKind::Channel { threads: 2 };
    let shares = machine::<P>(kind).run(&job, &mut Unwatched).expect("a machine without faults");
    let mut all = Loaded { refused: Vec::new(), repeated: Vec::new(), ..shares[0].loaded.clone() };
    for share in shares {
        let Loaded { survey, population, dimension, mut refused, mut repeated, .. } = share.loaded;
        assert_eq!((survey, population, dimension), (all.survey, all.population, all.dimension));
        all.refused.append(&mut refused);
        all.repeated.append(&mut repeated);
    }
    all.repeated.sort_unstable();
    all
}

/// Finds repeated rows by sorting all points.
fn expected(points: &[DVec3]) -> Vec<[u64; 2]> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let compare = |a: usize, b: usize| lex_cmp(&points[a], &points[b]);
    order.sort_by(|&a, &b| compare(a, b).then(a.cmp(&b)));
    let groups = order.chunk_by(|&a, &b| compare(a, b).is_eq());
    let mut all: Vec<[u64; 2]> =
        groups.flat_map(|group| group[1..].iter().map(|&i| [i as u64, group[0] as u64])).collect();
    all.sort_unstable();
    all
}

/// Point `i` has the coordinates of `i % distinct`. The cases have no, few, many or only repeated rows, in one or several
/// bins and in one or several chunks. The points lie in a plane, so the machine ends after the phase.
#[test]
fn each_repeated_row_is_found_with_the_first() {
    for count in [0_usize, 1, 2, 100, (1 << 15) - 1, (1 << 15) + 1, 3 * (1 << 14) + 7, 5 << 15] {
        for distinct in [1, 2, count / 2 + 1, count.saturating_sub(3).max(1), count.max(1)] {
            let at = |i: usize| ((i % distinct) as u32).wrapping_mul(2_654_435_769);
            let points: Vec<DVec3> =
                (0..count).map(|i| DVec3::new(f64::from(at(i) % 64), f64::from(at(i)), 0.5)).collect();
            for workers in [1, 5, 40] {
                let found = loaded(&points, false, workers);
                let what = format!("{count} points, {distinct} of them distinct, {workers} workers");
                assert!(found.repeated == expected(&points), "{what}");
                assert_eq!(found.population.count, count.min(distinct) as u64, "{what}");
            }
        }
    }
}

/// Two points of the plane with different coordinates and the same hash.
fn points_with_equal_hashes() -> [DVec2; 2] {
    let first = DVec2::new(1.0, 0.75);
    // The hash after the first coordinate.
    let of_x = |x: f64| finalise(0x5E97_E75E_97E7_5E97 ^ x.to_bits());
    for i in 2..10_000_u32 {
        let x = f64::from(i);
        let y = f64::from_bits(of_x(first.x) ^ first.y.to_bits() ^ of_x(x));
        if (1e-20..1e20).contains(&y.abs()) {
            return [first, DVec2::new(x, y)];
        }
    }
    panic!("no pair of points");
}

#[test]
fn points_with_equal_hashes_are_compared() {
    let [a, b] = points_with_equal_hashes();
    assert_eq!(hash_of_place(a), hash_of_place(b));
    for workers in [1, 3] {
        let found = loaded(&[a, b, DVec2::ZERO, b, a], false, workers);
        assert_eq!((found.population.count, found.repeated), (3, vec![[3, 1], [4, 0]]));
    }
}

#[test]
fn zeros_of_both_signs_coincide() {
    let p = |x: f64| DVec2::new(x, 0.5);
    let points = [p(1.0), p(0.0), p(1.0), p(-0.0), p(2.0), DVec2::new(0.0, 1.0), p(1.0)];
    for workers in [1, 2, 5, 9] {
        let found = loaded(&points, false, workers);
        assert_eq!(found.repeated, [[2, 0], [3, 1], [6, 0]]);
        assert_eq!((found.population.count, found.dimension), (4, 2));
    }
}

#[test]
fn rows_that_are_not_finite_are_refused_or_removed() {
    let points = [DVec2::ZERO, DVec2::new(f64::NAN, 0.0), DVec2::ONE, DVec2::INFINITY, DVec2::X];
    for workers in [1, 2, 5, 9] {
        let found = loaded(&points, false, workers);
        assert!(matches!(found.survey.exponent(false), Err(RangeError::NotFinite { index: 1, .. })));
        assert_eq!(found.population.count, 0);
        let found = loaded(&points, true, workers);
        assert_eq!((found.refused, found.population.count, found.dimension), (vec![1, 3], 3, 2));
    }
}

#[test]
fn digits_that_spread_too_far_are_named_by_rows() {
    let points = [DVec2::NAN, DVec2::ONE, DVec2::new(1e-150, 1.0), DVec2::new(1e150, 3.0)];
    for workers in [1, 2, 4] {
        let found = loaded(&points, true, workers);
        assert!(matches!(found.survey.exponent(true), Err(RangeError::Spread { low: 2, high: 3, .. })));
    }
}

/// The dimension of the set does not depend on the blocks, even if each block spans less.
#[test]
fn frames_of_blocks_span_the_set() {
    let line = |t: f64| DVec3::new(t, 2.0 * t, -t);
    let mut points = Vec::new();
    for (dimension, next) in [(0, line(1.0)), (1, line(-3.0)), (2, DVec3::X), (3, DVec3::Z)] {
        points.push(next);
        for workers in [1, 2, 4, 40] {
            let scaled: Vec<DVec3> = points.iter().map(|&x| x * 1e-100).collect();
            assert_eq!(loaded(&points, false, workers).dimension, dimension, "{workers} workers");
            assert_eq!(loaded(&scaled, false, workers).dimension, dimension, "{workers} workers, scaled");
        }
    }
    assert_eq!(loaded::<DVec3>(&[], false, 3).dimension, -1);
}
