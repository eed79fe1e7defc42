//! In every round of partitioning, all workers hold about the same number of points, whatever the order of the input.

use glam::DVec3;

use crate::common::sets::space;
use crate::common::with_workers;
use septet_core::generate::Kind;
use septet_core::spec::Workers;
use septet_core::{Outcome, triangulate};
use septet_protocol::ids::Phase;

const POINTS: u64 = 40_000;

/// Interleaves the binary digits of the coordinates.
fn morton(p: &DVec3) -> u64 {
    let digits = |x: f64| (0..16).map(|bit| ((x * 65_536.0) as u64 >> bit & 1) << (3 * bit)).sum::<u64>();
    digits(p.x) | digits(p.y) << 1 | digits(p.z) << 2
}

/// The rows of a set in four orders.
fn orders() -> [(&'static str, Vec<DVec3>); 4] {
    let random = space(Kind::Uniform, POINTS, 5);
    let sorted = |key: fn(&DVec3) -> f64| {
        let mut rows = random.clone();
        rows.sort_by(|a, b| key(a).total_cmp(&key(b)));
        rows
    };
    [
        ("random", random.clone()),
        ("by x", sorted(|p| p.x)),
        ("by radius", sorted(|p| (*p - 0.5).length())),
        ("Morton", sorted(|p| morton(p) as f64)),
    ]
}

/// Returns the largest loads after the moves of each level.
fn loads(run: &Outcome) -> Vec<u64> {
    let rounds = run.ledger.part.rounds.iter().filter(|(key, _)| key.phase == Phase::Partition);
    rounds.map(|(_, tally)| tally.largest_load).filter(|&load| load > 0).collect()
}

#[test]
fn workers_hold_equal_shares_after_every_move() {
    for (order, rows) in orders() {
        for workers in [8, 64] {
            let run = triangulate(&rows, &with_workers(Workers::Count(workers), 1000)).unwrap();
            let loads = loads(&run);
            let what = format!("{order}, {workers} workers: {loads:?}");
            let share = POINTS as f64 / f64::from(workers);
            let (last, before) = loads.split_last().expect("moves");
            assert!(loads.len() as u32 >= workers.ilog2(), "{what}");
            assert!(before.iter().all(|&load| load as f64 <= 1.1 * share + 100.0), "{what}");
            assert!(*last as f64 <= 1.3 * share + 100.0, "{what}");
        }
    }
}
