//! Products: the values that one phase hands to another. Their fields are private, and few rooms change them.

use std::collections::{BTreeMap, BTreeSet};

use crate::map::{rows, text as map};
use crate::source::{Crate, room};
use crate::syntax::{
    Function, by_value, definitions, functions, implemented, lets, mutable_references, mutable_variables,
    type_at, visible_fields, words,
};

/// The heading of the table in ARCHITECTURE.md that lists the products with the rooms that make and change them.
const TABLE: &str = "| products | made by | also changed by |";

/// The products with visible fields, for the reasons in ARCHITECTURE.md.
const VISIBLE: [&str; 3] = ["Share", "Choice", "Certificate"];

/// Rooms without phase functions. The functions of the machine are the steps of a phase.
const WITHOUT_PHASES: [&str; 5] = ["config", "hosts", "machine", "share", "state"];

/// Rooms whose types are no products.
const WITHOUT_PRODUCTS: [&str; 3] = ["config", "hosts", "machine"];

/// The room whose functions call phases and pass products on.
pub const PROGRAMS: &str = "programs";

/// The product that more than two rooms change, because every phase that receives ghosts adds them to it.
const SHARED_BY_ALL: &str = "Table";

/// The crate of the machine.
pub fn machine() -> Crate {
    Crate::read("workers/src")
}

/// The phase functions of a text: its visible async functions.
pub fn phases(text: &str) -> Vec<Function<'_>> {
    functions(text).into_iter().filter(|function| function.is_phase).collect()
}

/// The words in the types of a function's parameters and result.
pub fn type_words<'a>(function: &Function<'a>) -> impl Iterator<Item = &'a str> {
    let types = function.parameters.iter().map(|(_, of)| *of).chain([function.result]);
    types.flat_map(words).collect::<Vec<_>>().into_iter()
}

/// Whether a room of the machine has phase functions.
pub fn has_phases(room: &str) -> bool {
    !room.is_empty() && !WITHOUT_PHASES.contains(&room)
}

/// The rooms of a product.
#[derive(Clone)]
struct Rooms {
    makers: BTreeSet<String>,
    changers: BTreeSet<String>,
}

/// The rooms of each product.
fn table() -> BTreeMap<String, Rooms> {
    let set = |cell: &Vec<String>| cell.iter().cloned().collect();
    let row = |row: Vec<Vec<String>>| {
        let rooms = Rooms { makers: set(&row[1]), changers: set(&row[2]) };
        row[0].iter().map(|product| (product.clone(), rooms.clone())).collect::<Vec<_>>()
    };
    rows(&map(), TABLE).into_iter().flat_map(row).collect()
}

/// The products of a crate, each with the rooms whose phase functions return it: the structs and enums in the signatures of
/// phase functions that are not `Copy`. An alias counts as the types that it names.
fn products(source: &Crate) -> BTreeMap<String, BTreeSet<String>> {
    let mut aliases: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut types: BTreeSet<&str> = BTreeSet::new();
    for (module, (_, text)) in &source.files {
        for definition in definitions(text) {
            if definition.kind == "type" {
                let right = definition.text.split_once('=').map_or("", |(_, right)| right);
                aliases.entry(definition.name).or_default().extend(words(type_at(right)));
            } else if definition.kind != "trait"
                && !definition.is_copy
                && !WITHOUT_PRODUCTS.contains(&room(module).as_str())
            {
                types.insert(definition.name);
            }
        }
    }
    let named = |text: &str| -> BTreeSet<String> {
        let expand = |word| aliases.get(word).cloned().unwrap_or_else(|| vec![word]);
        let all = words(text).flat_map(expand).flat_map(expand).filter(|word| types.contains(word));
        all.map(str::to_string).collect()
    };
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, (_, text)) in source.files.iter().filter(|(module, _)| has_phases(&room(module))) {
        for phase in phases(text) {
            for name in phase.parameters.iter().flat_map(|(_, of)| named(of)) {
                found.entry(name).or_default();
            }
            for name in named(phase.result) {
                found.entry(name).or_default().insert(room(module));
            }
        }
    }
    found
}

/// The products that a text changes: those that it takes by `&mut`, and its mutable parameters and variables.
fn changed(text: &str, products: &BTreeSet<String>) -> BTreeSet<String> {
    let mut types: Vec<String> = mutable_references(text).into_iter().map(str::to_string).collect();
    types.extend(mutable_variables(text).into_iter().map(by_value));
    let all = functions(text).into_iter().flat_map(|function| function.parameters).chain(lets(text));
    let is_mutable = |pattern: &str| words(pattern).any(|word| word == "mut");
    types.extend(all.filter(|(pattern, _)| is_mutable(pattern)).map(|(_, of)| by_value(of)));
    let named = types.iter().flat_map(|of| words(of)).filter(|word| products.contains(*word));
    named.map(str::to_string).collect()
}

/// Whether a text makes a value of a type: by a function of the type, or from its fields.
fn makes(text: &str, name: &str) -> bool {
    let is_value = |before: &str| {
        let last = words(before.rsplit('\n').next().unwrap_or("")).last();
        !before.ends_with(|c: char| c.is_alphanumeric() || c == '_')
            && !last.is_some_and(|word| ["struct", "impl", "for", "let"].contains(&word))
            && !before.ends_with("-> ")
    };
    let is_made = |after: &str| ["::", " {", "("].iter().any(|start| after.starts_with(start));
    text.match_indices(name).any(|(at, _)| is_value(&text[..at]) && is_made(&text[at + name.len()..]))
}

/// Each product with a room that changes it, and the files in which the room does. A room may have `impl` blocks of the
/// types that it defines.
fn changes(source: &Crate, products: &BTreeSet<String>) -> BTreeMap<(String, String), Vec<String>> {
    let mut found: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    let defined: BTreeSet<(String, String)> = source
        .files
        .iter()
        .flat_map(|(module, (_, text))| {
            definitions(text).into_iter().map(|definition| (definition.name.to_string(), room(module)))
        })
        .collect();
    for (module, (name, text)) in source.files.iter().filter(|(module, _)| room(module) != PROGRAMS) {
        let blocks = implemented(text).into_iter().map(str::to_string);
        let foreign = blocks
            .filter(|block| products.contains(block) && !defined.contains(&(block.clone(), room(module))));
        for product in changed(text, products).into_iter().chain(foreign) {
            found.entry((product, room(module))).or_default().push(name.clone());
        }
    }
    found
}

/// The differences between the table and the source, as sentences.
fn differences(source: &Crate, table: &BTreeMap<String, Rooms>) -> Vec<String> {
    let products = products(source);
    let names: BTreeSet<String> = products.keys().cloned().collect();
    let listed: BTreeSet<String> = table.keys().cloned().collect();
    let mut found: Vec<String> =
        (&names - &listed).iter().map(|name| format!("phases take or return {name}; list it")).collect();
    found
        .extend((&listed - &names).iter().map(|name| format!("no phase takes or returns {name}; remove it")));
    let changes = changes(source, &names);
    for (product, rooms) in table.iter().filter(|(product, _)| names.contains(*product)) {
        let of: BTreeMap<&String, &Vec<String>> =
            changes.iter().filter(|((of, _), _)| of == product).map(|((_, at), files)| (at, files)).collect();
        found.extend(rooms.differences(source, product, &products[product], &of));
    }
    found
}

impl Rooms {
    /// The differences between the row of a product and the source: the rooms whose phase functions return the product, and
    /// the rooms that change it, with the files in which they do.
    fn differences(
        &self,
        source: &Crate,
        product: &str,
        returned: &BTreeSet<String>,
        changes: &BTreeMap<&String, &Vec<String>>,
    ) -> Vec<String> {
        let mut found = Vec::new();
        let listed = &self.makers | &self.changers;
        for (at, files) in changes.iter().filter(|(at, _)| !listed.contains(**at)) {
            found.push(format!("`{at}` changes {product} in {}; list `{at}`", files.join(", ")));
        }
        for at in returned - &listed {
            found.push(format!("phases of `{at}` return {product}; list `{at}`"));
        }
        for at in self.changers.iter().filter(|at| !changes.contains_key(at)) {
            found.push(format!("`{at}` does not change {product}; remove `{at}`"));
        }
        for at in &self.makers {
            let mut code = source.files.iter().filter(|(module, _)| room(module) == *at);
            if !code.any(|(_, (_, text))| makes(text, product)) {
                found.push(format!("`{at}` does not make {product}; remove `{at}`"));
            }
        }
        if self.makers.is_empty() || !self.makers.is_disjoint(&self.changers) {
            found.push(format!("{product} needs a maker that is not listed twice"));
        }
        if self.makers.len() > 2 {
            found.push(format!("more than two rooms make {product}: {:?}", self.makers));
        }
        if self.changers.len() > 2 && product != SHARED_BY_ALL {
            found.push(format!(
                "more than two rooms besides its makers change {product}: {:?}",
                self.changers
            ));
        }
        found
    }
}

/// The visible fields of the structs with this name, by file.
fn fields_of<'a>(source: &'a Crate, name: &str) -> Vec<(&'a str, Vec<&'a str>)> {
    let mut found = Vec::new();
    for (file, text) in source.files.values() {
        let structs = definitions(text).into_iter().filter(|d| d.kind == "struct" && d.name == name);
        found.extend(structs.map(|definition| (file.as_str(), visible_fields(definition.text))));
    }
    found
}

#[test]
fn phase_functions_are_in_the_rooms_of_phases() {
    let source = machine();
    let rooms: BTreeSet<String> = source.files.keys().map(|module| room(module)).collect();
    let with = source.files.iter().filter(|(_, (_, text))| !phases(text).is_empty());
    let mut with: BTreeSet<String> = with.map(|(module, _)| room(module)).collect();
    assert!(with.remove("machine"), "`machine` has no async function");
    let expected = rooms.iter().filter(|at| has_phases(at)).cloned().collect();
    assert_eq!(with, expected, "other rooms have phase functions than expected");
    let unknown: Vec<_> = WITHOUT_PHASES.iter().filter(|at| !rooms.contains(**at)).collect();
    assert!(unknown.is_empty() && rooms.contains(PROGRAMS), "these rooms do not exist: {unknown:?}");
}

#[test]
fn the_table_lists_every_product_and_the_rooms_that_change_it() {
    let found = differences(&machine(), &table());
    assert!(found.is_empty(), "the table of products in ARCHITECTURE.md differs from the source: {found:#?}");
}

#[test]
fn fields_of_products_are_private() {
    let source = machine();
    let excepted: BTreeSet<String> = VISIBLE.map(str::to_string).into();
    let products: BTreeSet<String> = products(&source).into_keys().collect();
    for name in products.iter().chain([&"Context".to_string()]) {
        let found = fields_of(&source, name);
        assert_eq!(found.len(), 1, "exactly one struct must have the name of the product {name}: {found:?}");
        let (file, fields) = &found[0];
        assert_eq!(
            !fields.is_empty(),
            excepted.contains(name),
            "{file}: make the fields of {name} private, or correct the exceptions: {fields:#?}"
        );
    }
    let unknown = &excepted - &products;
    assert!(unknown.is_empty(), "these exceptions are not products: {unknown:?}");
}

/// The rooms that change the structs of which products of `state` consist.
const OF_PARTS: [&str; 2] = ["state", "partition"];

#[test]
fn parts_of_products_are_private_and_changed_where_they_are_made() {
    let source = machine();
    let products = products(&source);
    let mut parts = BTreeSet::new();
    for (_, (file, text)) in source.files.iter().filter(|(module, _)| room(module) == "state") {
        for part in definitions(text) {
            let is_part = part.kind == "struct" && part.is_visible && !part.is_copy;
            if is_part && !products.contains_key(part.name) {
                let fields = visible_fields(part.text);
                assert!(fields.is_empty(), "{file}: fields of {} are visible: {fields:#?}", part.name);
                parts.insert(part.name.to_string());
            }
        }
    }
    assert!(!parts.is_empty(), "`state` has no structs besides products");
    let mut changes = changes(&source, &parts);
    changes.retain(|(_, at), _| !OF_PARTS.contains(&at.as_str()));
    assert!(changes.is_empty(), "only {OF_PARTS:?} may change these structs: {changes:#?}");
}

/// A crate with one product, a phase that makes it and another room with this text.
fn planted(other: &str) -> Crate {
    let made = "pub(crate) async fn grow<P>(cx: &mut Context<P>) -> Result<Tree<P>, Error> {\n    Ok(Tree::default())\n}\n";
    let tree = "pub(crate) struct Tree<P> {\n    root: P,\n}\n\nimpl<P> Default for Tree<P> {\n}\n";
    Crate::of(&[("partition::grow", made), ("state::tree", tree), ("graph::prune", other)])
}

/// A row of the table of products.
fn row(product: &str, makers: &[&str], changers: &[&str]) -> (String, Rooms) {
    let set = |rooms: &[&str]| rooms.iter().map(|room| (*room).to_string()).collect();
    (product.to_string(), Rooms { makers: set(makers), changers: set(changers) })
}

#[test]
fn a_planted_change_is_found() {
    let table = [row("Tree", &["partition"], &[])].into();
    let changes = [
        "async fn prune<P>(\n    cx: &mut Context<P>,\n    tree: &mut Tree<P>,\n) -> u8 {\n    0\n}\n",
        "fn prune<P, F: Fn(&P) -> u8>(leaf: F, tree: &mut crate::state::tree::Tree<P>) {}\n",
        "fn prune<'a, P>(trees: &'a mut [Tree<P>]) {}\n",
        "fn prune<P>(tree: Option<&mut Tree<P>>) {}\n",
        "fn prune<P>(mut tree: Tree<P>) -> u8 {\n    0\n}\n",
        "fn prune<P>((mut tree, at): (Tree<P>, u8)) {}\n",
        "fn prune<P>(Tree { mut root, .. }: Tree<P>) {}\n",
        "fn prune() {\n    each(|leaf: u8, tree: &mut Tree<P>| tree.cut(leaf));\n}\n",
        "fn prune() {\n    each(|mut tree: Tree<P>| tree.cut());\n}\n",
        "fn prune() {\n    let mut tree: Tree<P> = grown();\n}\n",
        "fn prune() {\n    let (mut tree, at): (Tree<P>, u8) = grown();\n}\n",
        "struct Pruning<'a, P> {\n    tree: &'a mut Tree<P>,\n}\n",
        "impl<P> Tree<P> {\n    fn cut(&mut self) {}\n}\n",
        "impl<P: Point> Cut<P> for crate::state::tree::Tree<P> {\n}\n",
    ];
    for text in changes {
        let found = differences(&planted(text), &table);
        assert_eq!(found, ["`graph` changes Tree in graph::prune; list `graph`"], "{text}");
    }
}

#[test]
fn reading_a_product_changes_nothing() {
    let table = [row("Tree", &["partition"], &[])].into();
    let reads = [
        "fn look<P>(tree: &Tree<P>, count: &mut u8) -> Tree<P> {\n    0\n}\n",
        "fn look<P>(mut trees: &[Tree<P>], mut at: u8) {}\n",
        "fn look() {\n    let mut tree = &mut count;\n    let each: &Tree<P> = mutable(&mut tree, Tree::of(1));\n}\n",
        "impl<P> Cut<Tree<P>> for Knife {\n}\n",
        "fn look<P>(mut treetop: Treetop<P>, other: &mut Subtree<P>) {}\n",
        "fn look<P>(each: &mut impl FnMut(&Tree<P>)) {}\n",
    ];
    for text in reads {
        assert_eq!(differences(&planted(text), &table), Vec::<String>::new(), "{text}");
    }
    let programs = "fn simulate<P>(mut tree: Tree<P>) {}\n";
    let mut source = planted("");
    source.files.insert("programs::simulate".to_string(), ("simulate".to_string(), programs.to_string()));
    assert_eq!(differences(&source, &table), Vec::<String>::new());
}

#[test]
fn a_planted_product_must_be_listed() {
    let phases = [
        "pub(crate) async fn prune<P>(cut: Option<Cut<'_, P>>) {}\n\npub(crate) struct Cut<'a, P> {\n}\n",
        "pub(super) async fn prune<P>(cx: &mut Context<P>) -> Result<Vec<Cut>, Error>\nwhere\n    P: Point,\n{\n}\n\nstruct Cut;\n",
        "pub async fn prune<P>(\n    cx: &mut Context<P>,\n    cuts: Cuts<P>,\n) {\n}\n\ntype Cuts<P> = Vec<Cut<P>>;\n\nenum Cut {\n}\n",
    ];
    for text in phases {
        let found = differences(&planted(text), &[row("Tree", &["partition"], &[])].into());
        assert!(found.contains(&"phases take or return Cut; list it".to_string()), "{text}: {found:?}");
    }
    let private = "async fn prune<P>(cut: Cut<P>) {}\n\npub(crate) fn plain(cut: Cut<P>) {}\n\npub(crate) struct Cut;\n";
    assert_eq!(
        differences(&planted(private), &[row("Tree", &["partition"], &[])].into()),
        Vec::<String>::new()
    );
}

#[test]
fn planted_rows_without_a_reason_are_found() {
    let found = |rows: &[(String, Rooms)]| differences(&planted(""), &rows.iter().cloned().collect());
    assert_eq!(found(&[]), ["phases take or return Tree; list it"]);
    let tree = row("Tree", &["partition"], &[]);
    assert_eq!(
        found(&[tree.clone(), row("Leaf", &["graph"], &[])]),
        ["no phase takes or returns Leaf; remove it"]
    );
    assert_eq!(
        found(&[row("Tree", &["partition", "graph"], &[])]),
        ["`graph` does not make Tree; remove `graph`"]
    );
    assert_eq!(
        found(&[row("Tree", &["partition"], &["graph"])]),
        ["`graph` does not change Tree; remove `graph`"]
    );
    let all = found(&[row("Tree", &["graph"], &["graph", "a", "b"])]);
    assert!(all.contains(&"phases of `partition` return Tree; list `partition`".to_string()));
    assert!(all.contains(&"Tree needs a maker that is not listed twice".to_string()));
    assert!(all.iter().any(|one| one.starts_with("more than two rooms besides its makers change Tree")));
}
