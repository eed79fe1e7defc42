//! Import cycles: none across rooms, and none within a room, except that a file and its child may import each other.

use std::collections::{BTreeMap, BTreeSet};

use crate::map::{rows, text as map};
use crate::source::{COMMON, Crate, room};

/// Folders of the crates' root files.
pub const CRATES: [&str; 15] = [
    "src",
    "src/core",
    "workers/src",
    "src/io",
    "src/verify",
    "src/meshing",
    "src/queries",
    "src/lab",
    "src/cli",
    "src/mpi",
    "src/doors",
    "src/c",
    "src/python",
    "workers/geometry/src",
    "workers/protocol/src",
];

type Graph = BTreeMap<String, BTreeSet<String>>;

/// Sets of nodes that reach each other, of at least two nodes.
fn cycles(graph: &Graph) -> Vec<Vec<String>> {
    let reach: BTreeMap<&String, BTreeSet<&String>> = graph.keys().map(|n| (n, reached(graph, n))).collect();
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for node in graph.keys() {
        let own: Vec<String> = reach[node]
            .iter()
            .filter(|other| reach.get(**other).is_some_and(|back| back.contains(node)))
            .map(|other| (*other).clone())
            .collect();
        if own.len() > 1 && seen.insert(own.clone()) {
            found.push(own);
        }
    }
    found
}

fn reached<'a>(graph: &'a Graph, from: &'a String) -> BTreeSet<&'a String> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(node) = open.pop() {
        for next in graph.get(node).into_iter().flatten() {
            if found.insert(next) {
                open.push(next);
            }
        }
    }
    found
}

/// Cycles of a graph, each as the edges that make it.
fn described(graph: &Graph) -> Vec<Vec<String>> {
    let edges = |cycle: Vec<String>| {
        let inside = |to: &&String| cycle.contains(to);
        let of = |from: &String| {
            format!("{from} -> {}", graph[from].iter().filter(inside).cloned().collect::<Vec<_>>().join(", "))
        };
        cycle.iter().map(of).collect()
    };
    cycles(graph).into_iter().filter(|cycle| !is_parent_and_child(cycle)).map(edges).collect()
}

/// Whether a cycle consists of a module and a module directly below it. A module may re-export the items of its children,
/// which use its own.
fn is_parent_and_child(cycle: &[String]) -> bool {
    let [parent, child] = cycle else { return false };
    child.rsplit_once("::").is_some_and(|(above, _)| above == parent)
}

/// The graph of rooms: a crate's top-level modules, and its root if it defines what they import.
fn rooms(files: &Graph) -> Graph {
    let mut rooms = Graph::new();
    for (module, imports) in files {
        let own = room(module);
        let others = imports.iter().map(|other| room(other)).filter(|other| *other != own);
        rooms.entry(own.clone()).or_default().extend(others);
    }
    rooms
}

#[test]
fn imports_are_found_in_every_crate() {
    for folder in CRATES {
        let files = Crate::read(folder).imports();
        let with = files.values().filter(|imports| !imports.is_empty()).count();
        assert!(
            files.len() < 3 || 2 * with >= files.len(),
            "{folder}: {with} of {} files import others",
            files.len()
        );
    }
}

#[test]
fn no_cycle_crosses_rooms() {
    let all: Vec<_> = CRATES
        .iter()
        .map(|folder| (folder, described(&rooms(&Crate::read(folder).imports()))))
        .filter(|(_, found)| !found.is_empty())
        .collect();
    assert!(all.is_empty(), "these rooms import each other: {all:#?}");
}

#[test]
fn no_files_of_a_room_import_each_other() {
    let all: Vec<_> = CRATES
        .iter()
        .map(|folder| (folder, described(&Crate::read(folder).imports())))
        .filter(|(_, found)| !found.is_empty())
        .collect();
    assert!(all.is_empty(), "these files import each other: {all:#?}");
}

/// The heading of the table in ARCHITECTURE.md that lists the rooms of the machine, with the other rooms that each imports.
pub const TABLE: &str = "| room of `workers/src` | holds | may import |";

/// The imports that a table does not allow, and the entries that no import uses.
fn differences(rooms: &Graph, table: &Graph) -> (BTreeSet<String>, BTreeSet<String>) {
    let edges = |graph: &Graph| -> BTreeSet<String> {
        let all = graph.iter().flat_map(|(from, to)| to.iter().map(move |to| (from, to)));
        let specific = all.filter(|(from, to)| {
            !from.is_empty()
                && !to.is_empty()
                && (!COMMON.contains(&to.as_str()) || COMMON.contains(&from.as_str()))
        });
        specific.map(|(from, to)| format!("{from} -> {to}")).collect()
    };
    let (found, allowed) = (edges(rooms), edges(table));
    (&found - &allowed, &allowed - &found)
}

#[test]
fn rooms_of_the_machine_import_what_the_map_allows() {
    let row = |row: Vec<Vec<String>>| (row[0][0].clone(), row[2].iter().cloned().collect());
    let table: Graph = rows(&map(), TABLE).into_iter().map(row).collect();
    let (forbidden, unused) = differences(&rooms(&Crate::read("workers/src").imports()), &table);
    assert!(forbidden.is_empty(), "ARCHITECTURE.md does not allow these imports: {forbidden:#?}");
    assert!(unused.is_empty(), "ARCHITECTURE.md allows imports that no file needs: {unused:#?}");
}

#[test]
fn a_planted_import_is_found() {
    let edge = |from: &str, to: &[&str]| (from.to_string(), to.iter().map(|t| (*t).to_string()).collect());
    let graph: Graph = [edge("stars", &["state", "result"]), edge("state", &["stars"])].into();
    let table: Graph = [edge("state", &["stars", "machine"])].into();
    let (forbidden, unused) = differences(&graph, &table);
    assert!(forbidden.iter().eq(["stars -> result"]) && unused.iter().eq(["state -> machine"]));
}

#[test]
fn a_planted_cycle_is_found() {
    let edge = |from: &str, to: &[&str]| (from.to_string(), to.iter().map(|t| (*t).to_string()).collect());
    let graph: Graph = [edge("a", &["b"]), edge("b", &["c"]), edge("c", &["a"]), edge("d", &["a"])].into();
    assert_eq!(cycles(&graph), [["a", "b", "c"].map(str::to_string).to_vec()]);
    let graph: Graph = [edge("a", &["b"]), edge("b", &["a", "b::c"]), edge("b::c", &["b"])].into();
    assert_eq!(described(&graph).len(), 1);
    let graph: Graph = [edge("b", &["b::c"]), edge("b::c", &["b"]), edge("d", &["b"])].into();
    assert!(described(&graph).is_empty());
    let graph: Graph = [edge("b::c", &["b::d"]), edge("b::d", &["b::c"])].into();
    assert_eq!(described(&graph), [["b::c -> b::d", "b::d -> b::c"]]);
}
