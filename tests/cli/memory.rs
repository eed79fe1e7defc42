//! The limit of the memory: forecasts, counts of what grows, and nothing left behind. Each thread needs memory, so the number
//! of threads is given.

use std::fmt::Write as _;
use std::fs;
use std::time::{Duration, Instant};

use super::Place;

/// Points whose forecast is low: a moment curve behind many grid points. No probe of the forecast is on the curve, which
/// has a million cells.
fn hidden_curve() -> String {
    let mut text = String::new();
    for i in 0..36_000u32 {
        let _ = writeln!(text, "{} {} {}", i % 33, i / 33 % 33, i / 33 / 33);
    }
    for t in 1..1400u64 {
        let _ = writeln!(text, "{} {} {}", 100 + t, t * t, t * t * t);
    }
    text
}

/// Checks that a run ends with exit code 5 within a time, and leaves nothing behind.
fn stops(place: &Place, line: &str, seconds: u64) {
    let start = Instant::now();
    place.fails(line, 5, &["of memory", "--max-memory"]);
    let spent = start.elapsed();
    assert!(spent < Duration::from_secs(seconds), "{line}: {spent:?}");
}

#[test]
fn a_curve_with_many_cells_is_refused_before_it_starts() {
    let place = Place::new();
    place.good("generate moment-curve -n 4000 -o curve.npy");
    for command in ["triangulate", "simulate"] {
        for way in ["--workers 1", "--workers 5", "--transport processes --processes 3"] {
            stops(&place, &format!("{command} curve.npy -o out.vtu --threads 2 --max-memory 60M {way}"), 10);
        }
    }
}

#[test]
fn growing_cells_stop_at_the_limit() {
    let place = Place::new();
    place.file("hidden.xyz", hidden_curve());
    for command in ["triangulate hidden.xyz --max-memory 48M", "simulate hidden.xyz --max-memory 70M"] {
        for way in [
            "--threads 2 --workers 1",
            "--threads 2 --workers 3",
            "--threads 1 --workers 16",
            "--threads 2 --transport sim --workers 3",
            "--threads 2 --transport processes --processes 3",
        ] {
            stops(&place, &format!("{command} -o out.vtu {way}"), 60);
        }
    }
    place.good("triangulate hidden.xyz -o out.vtu --threads 2 --max-memory 400M");
}

#[test]
fn a_limit_above_the_peak_changes_nothing() {
    let place = Place::new();
    for command in ["triangulate", "simulate"] {
        place.good(&format!("{command} sample:uniform:4000 -o free.vtu --threads 2"));
        for way in ["", "--transport processes --processes 2"] {
            let limit = "--threads 2 --max-memory 128M";
            place.good(&format!("{command} sample:uniform:4000 -o out.vtu {limit} {way}"));
            let [free, limited] = ["free.vtu", "out.vtu"].map(|name| fs::read(place.path(name)).unwrap());
            assert!(free == limited, "{command} {way}");
        }
    }
}
