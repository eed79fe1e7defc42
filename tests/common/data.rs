//! Real point sets, fetched by `tests/run`.

use std::path::Path;

use septet_core::model::Points;
use septet_io::read::{ReadOptions, read};

const FILES: [&str; 10] = [
    "bunny00.off",
    "elephant.off",
    "fandisk.off",
    "rotor.off",
    "rotor_small.off",
    "armadillo.off",
    "camel.off",
    "dino.off",
    "hand.off",
    "example.node",
];

/// Returns the vertices of all files.
///
/// # Panics
/// Panics if a file is missing.
pub fn all() -> Vec<(String, Points)> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data");
    let vertices = |name: &str| {
        let path = directory.join(name);
        assert!(path.is_file(), "{} is missing: run tests/run --setup", path.display());
        read(&path, &ReadOptions::default(), &mut |_, _| {}).unwrap_or_else(|e| panic!("{e}")).points
    };
    FILES.map(|name| (name.to_string(), vertices(name))).into()
}
