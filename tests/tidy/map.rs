//! The map: ARCHITECTURE.md names every crate and every room.

use std::collections::BTreeSet;
use std::fs;

use crate::cycles::{CRATES as FOLDERS, TABLE as MACHINE};
use crate::source::root;

/// Folders of crates whose rooms the map lists.
const CRATES: [&str; 6] = ["workers/src", "src/core", "src/io", "src/lab", "src/cli", "src/meshing"];

/// The heading of the table in ARCHITECTURE.md that lists the crates with their rooms, except the rooms of the machine.
const CRATE_TABLE: &str = "| crate | folder | uses | rooms | content |";

/// The largest numbers of lines and words of the documents that a newcomer reads first.
const MOST: [(&str, usize, usize); 2] = [("ARCHITECTURE.md", 150, 2_200), ("README.md", 200, 2_200)];

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
    let cells = |line: &str| -> Vec<Vec<String>> { line.trim_matches('|').split('|').map(words).collect() };
    let all: Vec<_> = table.lines().skip(2).take_while(|line| line.starts_with('|')).map(cells).collect();
    let columns = heading.matches('|').count() - 1;
    assert!(!all.is_empty(), "the table {heading} in ARCHITECTURE.md is empty");
    assert!(all.iter().all(|row| row.len() == columns), "the table {heading} in ARCHITECTURE.md is uneven");
    all
}

/// The rooms of all crates that the map does not list, and the rows of rooms that do not exist.
fn differences(map: &str, rooms: &[(&str, Vec<String>)]) -> (BTreeSet<String>, BTreeSet<String>) {
    let of = |(folder, rooms): &(&str, Vec<String>)| -> Vec<String> {
        rooms.iter().map(|room| format!("{folder}/{room}")).collect()
    };
    let found: BTreeSet<String> = rooms.iter().flat_map(of).collect();
    let machine = rows(map, MACHINE).into_iter().map(|row| format!("workers/src/{}", row[0][0]));
    let others = rows(map, CRATE_TABLE).into_iter().filter(|row| row[1] != ["workers"]).flat_map(|row| {
        let folder = row[1][0].clone();
        row[3].iter().map(|room| format!("{folder}/{room}")).collect::<Vec<_>>()
    });
    let listed = machine.chain(others).collect();
    (&found - &listed, &listed - &found)
}

#[test]
fn the_map_names_every_crate_and_room() {
    let map = text();
    let rooms = CRATES.map(|folder| (folder, rooms(folder)));
    let empty: Vec<_> = rooms.iter().filter(|(_, rooms)| rooms.is_empty()).collect();
    assert!(empty.is_empty(), "these crates have no rooms: {empty:?}");
    let (missing, unknown) = differences(&map, &rooms);
    assert!(missing.is_empty(), "ARCHITECTURE.md does not name these rooms: {missing:#?}");
    assert!(unknown.is_empty(), "ARCHITECTURE.md names rooms that do not exist: {unknown:#?}");
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let paths = manifest.lines().filter_map(|line| line.split_once(" = { path = "));
    let crates: Vec<_> = paths.filter(|(name, _)| name.starts_with("septet")).collect();
    assert!(!crates.is_empty(), "no crate was found in Cargo.toml");
    for (name, _) in crates {
        assert!(map.contains(name), "ARCHITECTURE.md does not name the crate {name}");
    }
}

/// The crates of septet in the section `dependencies` of a manifest, without the prefix.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let section = manifest.split_once("\n[dependencies]\n").map_or("", |(_, rest)| rest);
    let lines = section.lines().take_while(|line| !line.starts_with('['));
    let names = lines.filter_map(|line| line.strip_prefix("septet-")?.split(['.', ' ']).next());
    names.map(str::to_string).collect()
}

#[test]
fn the_map_lists_the_dependencies_of_every_crate() {
    for row in rows(&text(), CRATE_TABLE) {
        let folder = &row[1][0];
        let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap();
        let listed: BTreeSet<String> = row[2].iter().cloned().collect();
        let found = dependencies(&manifest);
        assert_eq!(found, listed, "ARCHITECTURE.md lists other crates in `uses` than {folder}/Cargo.toml");
    }
}

#[test]
fn the_dependencies_of_a_planted_manifest_are_read() {
    let manifest = "[package]\n\n[dependencies]\nglam = \"1\"\nseptet-a.workspace = true\nseptet-b = { path = \"b\" }\n\n[dev-dependencies]\nseptet-c.workspace = true\n";
    assert!(dependencies(manifest).iter().eq(["a", "b"]));
}

#[test]
fn the_first_documents_are_short() {
    for (name, most_lines, most_words) in MOST {
        let text = fs::read_to_string(root().join(name)).unwrap();
        let (lines, words) = (text.lines().count(), text.split_whitespace().count());
        assert!(lines <= most_lines, "{name} has {lines} lines, more than {most_lines}: shorten it");
        assert!(words <= most_words, "{name} has {words} words, more than {most_words}: shorten it");
    }
}

/// Members of the workspace whose code only tests and measures.
const INSTRUMENTS: [&str; 2] = ["tests/common", "bench"];

#[test]
fn the_rules_cover_every_crate() {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let list = manifest.split_once("\nmembers = [").unwrap().1.split_once(']').unwrap().0;
    let members: Vec<&str> = list.split('"').skip(1).step_by(2).collect();
    let code = |member: &&str| !INSTRUMENTS.contains(member);
    let folder = |member: &str| match member {
        "." => "src".to_string(),
        _ if root().join(member).join("src").is_dir() => format!("{member}/src"),
        _ => member.to_string(),
    };
    let folders: BTreeSet<String> = members.into_iter().filter(code).map(folder).collect();
    let covered: BTreeSet<String> = FOLDERS.map(str::to_string).into();
    assert_eq!(folders, covered, "the tidy tests read other folders than those of the workspace");
}

/// The packages of a lock file that depend on a package.
fn users<'a>(lock: &'a str, package: &str) -> Vec<&'a str> {
    let uses = |text: &&str| {
        let names = text.lines().filter_map(|line| line.strip_prefix(" \"")?.split(['"', ' ']).next());
        names.into_iter().any(|name| name == package)
    };
    let name = |text: &'a str| text.split('"').nth(1);
    lock.split("[[package]]").skip(1).filter(uses).filter_map(name).collect()
}

/// Commands at the root that select no package build the default members. These need no MPI library.
#[test]
fn the_default_members_need_no_mpi() {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let list = manifest.split_once("\ndefault-members = [").unwrap().1.split_once(']').unwrap().0;
    assert!(!list.contains("src/mpi"), "src/mpi is a default member");
    let lock = fs::read_to_string(root().join("Cargo.lock")).unwrap();
    assert_eq!(users(&lock, "mpi-sys"), ["mpi"]);
    assert_eq!(users(&lock, "mpi"), ["septet-mpi"]);
    assert!(users(&lock, "septet-mpi").is_empty(), "a crate depends on septet-mpi");
}

#[test]
fn the_users_of_a_package_of_a_planted_lock_are_found() {
    let lock = "[[package]]\nname = \"a\"\ndependencies = [\n \"b\",\n]\n\n[[package]]\nname = \"b\"\n\n[[package]]\nname = \"c\"\ndependencies = [\n \"bb\",\n \"b 1.0.0\",\n]\n";
    assert_eq!(users(lock, "b"), ["a", "c"]);
    assert!(users(lock, "c").is_empty());
}

#[test]
fn a_planted_room_and_a_planted_row_are_found() {
    let machine = format!("{MACHINE}\n| --- | --- | --- |\n| `hall` | chairs, tables | - |\n");
    let map =
        format!("{machine}\n{CRATE_TABLE}\n| --- |\n| io | `src/io` | - | `read`, `cellar` | files |\n");
    let (missing, unknown) = differences(&map, &[("src/io", ["read", "attic"].map(str::to_string).to_vec())]);
    assert!(missing.iter().eq(["src/io/attic"]));
    assert!(unknown.iter().eq(["src/io/cellar", "workers/src/hall"]));
}

#[test]
fn the_rows_of_a_table_are_read() {
    let map = "text\n| a | b |\n| --- | --- |\n| `x` | `y`, `z` |\n| `w` | - |\n\n| `not` | here |\n";
    assert_eq!(rows(map, "| a | b |"), [[vec!["x"], vec!["y", "z"]], [vec!["w"], vec![]]]);
}

#[test]
#[should_panic(expected = "is empty")]
fn an_empty_table_is_refused() {
    rows("| a | b |\n| --- | --- |\n\n| `not` | here |\n", "| a | b |");
}

#[test]
#[should_panic(expected = "has no table")]
fn a_missing_table_is_refused() {
    rows("| a | c |\n| --- | --- |\n| `x` | `y` |\n", "| a | b |");
}
