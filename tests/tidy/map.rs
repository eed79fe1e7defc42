//! The map: ARCHITECTURE.md names every crate and every room.

use std::fs;

use crate::source::root;

/// Folders of crates whose rooms the map lists.
const CRATES: [&str; 6] = ["workers/src", "src/core", "src/io", "src/lab", "src/cli", "src/meshing"];

/// Rooms of a crate: the folders beside its root file that hold modules.
fn rooms(folder: &str) -> Vec<String> {
    let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let modules = entries.filter(|path| path.is_dir() && !path.join("Cargo.toml").exists());
    let names = modules.map(|path| path.file_name().unwrap().to_string_lossy().into_owned());
    names.filter(|name| name != "tests" && name != "target").collect()
}

fn missing(map: &str, folder: &str, rooms: &[String]) -> Vec<String> {
    let row = |room: &&String| !map.contains(&format!("| `{folder}` | `{room}` |"));
    rooms.iter().filter(row).map(|room| format!("{folder}/{room}")).collect()
}

#[test]
fn the_map_names_every_crate_and_room() {
    let map = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let rooms: Vec<_> = CRATES.iter().flat_map(|folder| missing(&map, folder, &rooms(folder))).collect();
    assert!(rooms.is_empty(), "ARCHITECTURE.md does not name these rooms: {rooms:#?}");
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let listed = manifest.lines().filter_map(|line| line.split_once(" = { path = "));
    for (name, _) in listed.filter(|(name, _)| name.starts_with("septet")) {
        assert!(map.contains(name), "ARCHITECTURE.md does not name the crate {name}");
    }
}

#[test]
fn a_planted_room_is_missed() {
    let map = "| `src/io` | `read` | readers |";
    let rooms = ["read", "attic"].map(str::to_string);
    assert_eq!(missing(map, "src/io", &rooms), ["src/io/attic"]);
}
