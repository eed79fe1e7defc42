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

/// The text of the map.
pub fn text() -> String {
    fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap()
}

/// The rows below the heading of a table. Each cell is a list of words, without backquotes. A dash is an empty list.
pub fn rows(map: &str, heading: &str) -> Vec<Vec<Vec<String>>> {
    let table = map.split_once(heading).unwrap_or_else(|| panic!("ARCHITECTURE.md has no table {heading}")).1;
    let words = |cell: &str| -> Vec<String> {
        let all = cell.split(',').map(|word| word.trim().trim_matches('`').to_string());
        all.filter(|word| word != "-").collect()
    };
    let cells = |line: &str| line.trim_matches('|').split('|').map(words).collect();
    table.lines().skip(2).take_while(|line| line.starts_with('|')).map(cells).collect()
}

fn missing(map: &str, folder: &str, rooms: &[String]) -> Vec<String> {
    let row = |room: &&String| !map.contains(&format!("| `{folder}` | `{room}` |"));
    rooms.iter().filter(row).map(|room| format!("{folder}/{room}")).collect()
}

#[test]
fn the_map_names_every_crate_and_room() {
    let map = text();
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

#[test]
fn the_rows_of_a_table_are_read() {
    let map = "text\n| a | b |\n| --- | --- |\n| `x` | `y`, `z` |\n| `w` | - |\n\n| `not` | here |\n";
    assert_eq!(rows(map, "| a | b |"), [[vec!["x"], vec!["y", "z"]], [vec!["w"], vec![]]]);
}
