use std::collections::BTreeSet;

use super::*;
use crate::spec::{Constants, InputRules, Keep, Machine, Recursion, Setting, SpecError, Tree};

/// The options of the fields of all groups. A new field does not compile here until it is named.
fn fields() -> BTreeSet<&'static str> {
    let Spec { input, machine, tree, recursion, keep, control: _, planted: _ } = Spec::default();
    let InputRules {
        dimension: _,
        columns: _,
        format: _,
        raw: _,
        skip_invalid: _,
        keep_columns: _,
        terrain: _,
        periodic: _,
    } = input;
    // The name of a run is set by programs only.
    let Machine { workers: _, threads: _, registers: _, transport: _, seed: _, run: _, max_memory: _ } =
        machine;
    let Tree { partition: _, leaf: _, constants } = tree;
    let Constants { purpose: _, samples: _, tries: _ } = constants;
    // The spacing is a property of the points.
    let Recursion { graph: _, sets: _, neighbours: _, repair: _, spacing: _ } = recursion;
    // Commands keep the graph and the sets for no output, and the others for their outputs.
    let Keep {
        owner: _,
        view: _,
        nodes: _,
        neighbours: _,
        graph: _,
        sets: _,
        costs: _,
        prices: _,
        operations: _,
    } = keep;
    [
        ["dimension", "columns", "input-format", "raw", "skip-invalid", "keep-columns", "terrain"].as_slice(),
        &["periodic", "origin", "wrap"],
        &["workers", "threads", "registers", "transport", "delivery-seed", "processes", "seed", "max-memory"],
        &["partition", "leaf", "constants", "samples", "tries"],
        &["supergraph", "alpha", "k", "separator-sets", "neighbours", "repair"],
        &["with-owner", "view", "nodes"],
    ]
    .concat()
    .into_iter()
    .collect()
}

#[test]
fn every_field_has_a_row() {
    let names: BTreeSet<&str> = OPTIONS.iter().map(|row| row.name).collect();
    assert_eq!(names, fields());
    assert_eq!(names.len(), OPTIONS.len(), "names are unique");
    for row in OPTIONS {
        assert_eq!(row.key, row.name.replace('-', "_"));
        assert!(row.is_flag || row.form.is_empty() != row.words.is_empty(), "{}: a form or words", row.name);
        assert!(
            !row.doc.ends_with('.') || row.doc.contains("\n\n"),
            "{}: a clause, then sentences",
            row.name
        );
    }
}

#[test]
fn values_survive_a_round_trip() {
    let changed = [
        ("workers", "4"),
        ("threads", "3"),
        ("transport", "sim"),
        ("delivery-seed", "7"),
        ("leaf", "50"),
        ("samples", "1e2"),
        ("tries", "5"),
        ("constants", "timing"),
        ("partition", "kd"),
        ("max-memory", "2G"),
        ("supergraph", "knn"),
        ("k", "10ln"),
        ("separator-sets", "both"),
        ("neighbours", "naive"),
        ("repair", "splay"),
        ("columns", "a,b,c"),
        ("raw", "f64,3"),
        ("view", "10"),
        ("nodes", "none"),
        ("registers", "baseline"),
    ];
    let mut spec = Spec::default();
    for row in OPTIONS {
        if let Some((_, text)) = changed.iter().find(|(name, _)| *name == row.name) {
            row.set(&mut spec, text).unwrap();
            assert!(row.is_changed(&spec), "{}", row.name);
        }
    }
    let mut other = Spec::default();
    for row in OPTIONS.iter().filter(|row| row.is_changed(&spec)) {
        row.set(&mut other, &row.get(&spec).text().unwrap()).unwrap();
    }
    for row in OPTIONS {
        assert_eq!(row.get(&spec), row.get(&other), "{}", row.name);
        for value in [row.get(&spec), row.get(&Spec::default())] {
            let of = value.json_type();
            assert!(row.types.contains(&of), "{}: {of}", row.name);
        }
    }
    assert_eq!(row("max-memory").get(&spec), Setting::Number(2 << 30));
}

#[test]
fn values_that_options_do_not_have_are_refused() {
    let refused = |name: &str, text: &str| row(name).set(&mut Spec::default(), text).unwrap_err();
    assert!(matches!(refused("separator-sets", "all"), SpecError::Value { option: "separator-sets", .. }));
    assert!(matches!(refused("view", "20001"), SpecError::Value { .. }));
    assert_eq!(refused("k", "3"), SpecError::Unused { graph: "density", parameter: "k" });
    let unmet = SpecError::Needs { option: "delivery-seed", needed: "transport", word: "sim" };
    assert_eq!(refused("delivery-seed", "3"), unmet);
    let words: Vec<&str> = row("transport").words_of(Commands::MESH).map(|word| word.0).collect();
    assert_eq!(words, ["channel", "sim"]);
}
