//! What the whole-system tests share.

#[path = "../../common/mod.rs"]
mod machines;

pub mod data;

pub mod sets;

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use septet::config::{Transport, Workers};
use septet::geometry::point::Point;
use septet::protocol::ledger::Ledger;
use septet::verify::{VerifyOptions, verify};
use septet::{Config, Run, simulate, triangulate};

pub use machines::{assert_same_counts, base, combinations, simulated, with_graph};

/// The coordinates of points, one after the other.
pub fn coordinates<P: Point>(points: &[P]) -> Vec<f64> {
    points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i)).collect::<Vec<_>>()).collect()
}

/// Panics unless the cells are septet's canonical triangulation, by exact arithmetic of its own.
pub fn assert_verified<P: Point>(points: &[P], run: &Run) {
    let coordinates = coordinates(points);
    let options = VerifyOptions { perturbed: true, any_order: false, ..VerifyOptions::default() };
    let report = verify(&run.view(&coordinates), &options, &mut |_, _, _| {});
    assert!(report.passed(), "{report:#?}");
    assert_eq!(report.hull_facets, run.hull_facets);
    assert_eq!(report.dimension_of_points, run.dimension as i32);
}

/// Triangulates and verifies.
pub fn check<P: Point>(points: &[P], config: &Config) -> Run {
    let run = triangulate(points, config).unwrap_or_else(|e| panic!("{config:?}: {e}"));
    assert_verified(points, &run);
    run
}

/// Simulates and verifies.
pub fn check_counted<P: Point>(points: &[P], config: &Config) -> Run {
    let run = simulate(points, config).unwrap_or_else(|e| panic!("{config:?}: {e}"));
    assert_verified(points, &run);
    run
}

/// `workers` in `threads` threads.
pub fn threaded(workers: Workers, threads: usize, leaf: u64) -> Config {
    Config { workers, threads, leaf: Some(leaf), transport: Transport::Channel { threads }, ..base() }
}

/// Levels below the root.
pub fn levels(ledger: &Ledger) -> u32 {
    ledger.part.nodes.keys().map(|node| node.level()).max().unwrap_or(0)
}

/// Runs `f`, and panics if it takes longer than any run of its size may.
pub fn within<T: Send + 'static>(seconds: u64, what: &str, f: impl FnOnce() -> T + Send + 'static) -> T {
    let (done, result) = channel();
    let thread = std::thread::spawn(move || {
        let _ = done.send(f());
    });
    match result.recv_timeout(Duration::from_secs(seconds)) {
        Ok(value) => value,
        Err(RecvTimeoutError::Timeout) => panic!("{what}: no end after {seconds} seconds"),
        Err(RecvTimeoutError::Disconnected) => match thread.join() {
            Ok(()) => unreachable!("it sends before it ends"),
            Err(panic) => {
                eprintln!("in {what}:");
                std::panic::resume_unwind(panic)
            }
        },
    }
}
