//! Real point sets, fetched by `tests/run`.

use std::path::Path;

use septet_core::model::Points;
use septet_io::read::{ReadOptions, read};

const FILES: [&str; 9] = [
    "bunny00.off",
    "elephant.off",
    "fandisk.off",
    "rotor.off",
    "armadillo.off",
    "camel.off",
    "dino.off",
    "hand.off",
    "example.node",
];

/// The vertices of all files that are there; all have to be if `SEPTET_REQUIRE_DATA=1`.
pub fn all() -> Vec<(String, Points)> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data");
    let required = std::env::var_os("SEPTET_REQUIRE_DATA").is_some_and(|v| v == "1");
    let mut sets = Vec::new();
    for name in FILES {
        let path = directory.join(name);
        if path.is_file() {
            let file = read(&path, &ReadOptions::default(), &mut |_, _| {}).unwrap_or_else(|e| panic!("{e}"));
            sets.push((name.to_string(), file.points));
        } else {
            assert!(!required, "{} is missing: run tests/run --setup", path.display());
            eprintln!("not run: {} is missing (tests/run --setup fetches it)", path.display());
        }
    }
    sets
}
