//! Imports of phases: a file with a phase function imports the machine, its own room and the products that it takes and
//! returns.

use std::collections::{BTreeMap, BTreeSet};

use crate::products::{PROGRAMS, has_phases, machine, phases, type_words};
use crate::source::{COMMON, Crate, Module, room};
use crate::syntax::definitions;

/// The files that the file of a phase also imports, with the reason.
const EXCEPTIONS: [(&str, &[&str], &str); 2] = [
    (
        "graph::selection",
        &["neighbours::descent", "neighbours::search"],
        "it sends the balls of a sample down the tree and reads their lists as they complete",
    ),
    ("splaying::splay", &["stars::look_up"], "it looks up the cells of other stars as the check does"),
];

/// The imports of files with phase functions beyond the rule: other than the common rooms, the file's own room, and files
/// that define a type in the signatures of its phase functions.
fn beyond(source: &Crate) -> BTreeSet<(Module, Module)> {
    let mut defined: BTreeMap<&str, BTreeSet<&Module>> = BTreeMap::new();
    for (module, (_, text)) in &source.files {
        for definition in definitions(text) {
            defined.entry(definition.name).or_default().insert(module);
        }
    }
    let mut found = BTreeSet::new();
    for (module, imports) in source.imports() {
        let here = room(&module);
        let phases = phases(&source.files[&module].1);
        if phases.is_empty() || !has_phases(&here) || here == PROGRAMS {
            continue;
        }
        let signed: BTreeSet<&Module> = phases
            .iter()
            .flat_map(type_words)
            .filter_map(|word| defined.get(word))
            .flatten()
            .copied()
            .collect();
        let is_allowed = |other: &Module| {
            room(other) == here || COMMON.contains(&room(other).as_str()) || signed.contains(other)
        };
        let others = imports.into_iter().filter(|other| !is_allowed(other));
        found.extend(others.map(|other| (module.clone(), other)));
    }
    found
}

#[test]
fn phases_import_the_machine_and_the_products_of_their_signatures() {
    let mut table = BTreeSet::new();
    for (file, others, _) in EXCEPTIONS {
        table.extend(others.iter().map(|other| (file.to_string(), (*other).to_string())));
    }
    let found = beyond(&machine());
    let (forbidden, unused) = (&found - &table, &table - &found);
    assert!(
        forbidden.is_empty(),
        "these phases import files without a type of their signatures: {forbidden:#?}"
    );
    assert!(unused.is_empty(), "no phase needs these exceptions: {unused:#?}");
}

#[test]
fn a_planted_import_of_a_phase_is_found() {
    let phase = "use crate::graph::edges::Edges;\nuse crate::graph::lists::{Lists, Part};\nuse crate::state::table::Table;\n\npub(crate) async fn hulls<P>(\n    table: &mut Table<P>,\n    edges: &Edges,\n) -> Result<Stars<P>, Error> {\n}\n";
    let plain = phase.replace("async ", "");
    let files = [
        ("stars::hulls", phase),
        ("stars::links", &plain),
        ("graph::edges", "pub(crate) struct Edges {\n}\n"),
        ("graph::lists", "pub(crate) struct Lists {\n}\n"),
        ("state::table", "pub(crate) struct Table<P> {\n}\n"),
    ];
    let found = beyond(&Crate::of(&files));
    assert!(found.iter().eq([&("stars::hulls".to_string(), "graph::lists".to_string())]));
}
