//! Rules of the source that no compiler checks.

use std::fs;
use std::path::{Path, PathBuf};

/// No file may be longer, but for those named with their reasons.
const MOST_LINES: usize = 540;
const LONGER: [(&str, usize, &str); 2] = [
    ("workers/protocol/src/ledger.rs", 640, "the ledger and its clocks, with their tests"),
    ("workers/src/partition.rs", 510, "one phase: leader and member side by side"),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sources(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

fn all(under: &str) -> Vec<(String, String)> {
    let mut paths = Vec::new();
    sources(&root().join(under), &mut paths);
    let read = |path: PathBuf| {
        let name = path.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
        (name, fs::read_to_string(&path).unwrap())
    };
    paths.into_iter().map(read).collect()
}

#[test]
fn files_are_short() {
    for (name, text) in all("") {
        let known = LONGER.iter().find(|l| l.0 == name);
        let limit = known.map_or(MOST_LINES, |l| l.1);
        let lines = text.lines().count();
        assert!(lines < limit, "{name} has {lines} lines: split it");
    }
}

/// The transports are the workers' business; the library gets one from `launch` or from its caller.
#[test]
fn the_library_names_no_transport_type() {
    let concrete = ["channel::Channel", "sim::Sim", "pipe::Pipes", "Pipes", "Channel::launch", "Sim::new"];
    for (name, text) in all("src").into_iter().filter(|(name, _)| name != "src/main.rs") {
        for line in text.lines() {
            let found = concrete.iter().find(|c| line.contains(**c));
            assert!(found.is_none(), "{name} names {found:?}: {line}");
        }
    }
}

/// The mathematics has no clock, threads, files, or maps whose order is left to chance.
#[test]
fn geometry_is_pure() {
    let forbidden = ["std::time", "std::thread", "std::fs", "std::net", "HashMap", "HashSet", "println!"];
    for (name, text) in
        all("workers/geometry/src").into_iter().filter(|(name, _)| !name.ends_with("tests.rs"))
    {
        for word in forbidden {
            assert!(!text.contains(word), "{name} uses {word}");
        }
    }
}

/// An oracle that shares code shares bugs.
#[test]
fn the_verifier_uses_no_crate_of_ours_and_no_predicates() {
    let manifest = fs::read_to_string(root().join("src/verify/Cargo.toml")).unwrap();
    let (_, rest) = manifest.split_once("[dependencies]").unwrap();
    let (dependencies, _) = rest.split_once("\n[").unwrap();
    assert!(dependencies.contains("num-bigint"), "the verifier's dependencies were not found");
    for word in ["septet", "robust"] {
        assert!(!dependencies.contains(word), "the verifier depends on {word}");
    }
}
