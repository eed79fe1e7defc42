//! The tables of phases in the documents, and the lists of phases in the scripts of `bench`, against the table of the code.

use std::collections::BTreeSet;
use std::fs;

use septet_protocol::ids::{Group, Phase};

use crate::source::root;

fn text(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap()
}

/// The names in a column of a table, without remarks in parentheses. `heading` is the first row of the table.
fn named(text: &str, heading: &str, column: &str) -> BTreeSet<String> {
    let cells =
        |row: &str| row.trim_matches('|').split('|').map(str::trim).map(str::to_owned).collect::<Vec<_>>();
    let at = cells(heading).iter().position(|cell| cell == column).unwrap();
    let table = text.split_once(heading).unwrap_or_else(|| panic!("no table {heading}")).1;
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let names = |row: &str| -> Vec<String> {
        let cell = cells(row)[at].clone();
        let plain = cell.split('(').map(|part| part.rsplit(')').next().unwrap_or("")).collect::<String>();
        plain
            .split(',')
            .map(|name| name.trim().to_owned())
            .filter(|name| !["", "-"].contains(&name.as_str()))
            .collect()
    };
    rows.flat_map(names).collect()
}

fn names(phases: impl Iterator<Item = Phase>) -> BTreeSet<String> {
    phases.map(|phase| phase.name().to_owned()).collect()
}

#[test]
fn the_documents_list_every_phase() {
    let all = names(Phase::ALL.into_iter().filter(|phase| *phase != Phase::Done));
    let charging = names(Phase::ALL.into_iter().filter(|phase| phase.group().counts_work()));
    let machine = text("src/guide/machine.md");
    for (what, found, expected) in [
        (
            "the flow in ARCHITECTURE.md",
            named(
                &text("ARCHITECTURE.md"),
                "| stage | mathematics (`workers/geometry`) | runs in (`workers/src`) | phases |",
                "phases",
            ),
            &all,
        ),
        ("the rounds in src/guide/machine.md", named(&machine, "| phase | rounds |", "phase"), &all),
        (
            "the charges in src/guide/machine.md",
            named(&machine, "| phase | charge at an inner node | charge at a leaf |", "phase"),
            &charging,
        ),
    ] {
        let (missing, unknown) = (expected - &found, &found - expected);
        assert!(missing.is_empty(), "{what} lack these phases: {missing:?}");
        assert!(unknown.is_empty(), "{what} have these names, which are not such phases: {unknown:?}");
    }
}

/// The words of a list in a script: the first text in quotes after `name`, or all texts up to the end of the statement.
fn words(script: &str, name: &str) -> Vec<String> {
    let rest = script.split_once(name).unwrap_or_else(|| panic!("no list {name}")).1;
    let list = rest.split_once(".split()").map_or(rest, |(list, _)| list);
    let quoted = list.split(']').next().unwrap_or("").split('"').skip(1).step_by(2);
    quoted.flat_map(str::split_whitespace).map(str::to_owned).collect()
}

#[test]
fn the_scripts_name_the_phases_of_the_table() {
    let faults = words(&text("bench/accept/faults.py"), "\nPAPER = (");
    assert_eq!(faults.into_iter().collect::<BTreeSet<_>>(), names(Group::Paper.phases()));
    let all = names(Phase::ALL.into_iter());
    for (script, list) in [
        ("bench/accept/faults.py", "\nPAPER = ("),
        ("bench/accept/ends.py", "\"triangulate\": "),
        ("bench/accept/ends.py", "\"simulate\": "),
        ("bench/accept/bounds.py", "\nLEVELS = "),
        ("bench/work-instructions", "\nENTRIES = "),
    ] {
        let words = words(&text(script), list);
        let unknown: Vec<&String> = words.iter().filter(|word| !all.contains(*word)).collect();
        assert!(words.len() > 3 && unknown.is_empty(), "{script}{list}: {unknown:?} in {words:?}");
    }
}

#[test]
fn planted_rows_are_read() {
    let table = "# T\n\n| phase | rounds |\n|---|---|\n| a, b | 1 |\n| c (with d) | 2 |\n\ntext";
    assert_eq!(named(table, "| phase | rounds |", "phase").into_iter().collect::<Vec<_>>(), ["a", "b", "c"]);
    assert_eq!(words("\nX = (\"a b \"\n \"c\").split()\ny = \"z\"", "\nX = "), ["a", "b", "c"]);
    assert_eq!(words("\nX = [\"a\", \"b\"]\ny = \"z\"", "\nX = "), ["a", "b"]);
}
