//! Products: the values that one phase hands to another. Their fields are private, and few rooms change them.

use std::collections::{BTreeMap, BTreeSet};

use crate::map::{rows, text as map};
use crate::source::{code, files, is_test};

const FOLDER: &str = "workers/src";

/// The heading of the table in ARCHITECTURE.md that lists each product with the rooms that make and change it.
const TABLE: &str = "| product | made by | also changed by |";

/// The entry of a product that every room may change.
const ANY: &str = "any room";

/// The code of a crate, without tests, by room and file.
fn sources() -> Vec<(String, String, String)> {
    let plain = files(FOLDER).into_iter().filter(|(name, _)| !is_test(name));
    plain.map(|(name, text)| (room_of(&name), name, code(&text))).collect()
}

/// The room of a file of the crate.
fn room_of(name: &str) -> String {
    let inside = &name[FOLDER.len() + 1..];
    inside.split(['/', '.']).next().unwrap_or("").to_string()
}

/// The rooms that make and change a product.
struct Rooms {
    makers: BTreeSet<String>,
    changers: BTreeSet<String>,
}

/// The rooms of each product.
fn table() -> BTreeMap<String, Rooms> {
    let set = |cell: &Vec<String>| cell.iter().cloned().collect();
    let row =
        |row: Vec<Vec<String>>| (row[0][0].clone(), Rooms { makers: set(&row[1]), changers: set(&row[2]) });
    rows(&map(), TABLE).into_iter().map(row).collect()
}

/// The fields of the struct `name` with a visibility. `None` if the text does not define the struct.
fn visible_fields(text: &str, name: &str) -> Option<Vec<String>> {
    let declared = format!("struct {name}");
    let is_end = |rest: &str| rest.starts_with([' ', '<', '(', ';', '{']);
    let at = text.match_indices(&declared).find(|(at, _)| is_end(&text[at + declared.len()..]))?.0;
    let rest = &text[at..];
    let end = rest.find("\n}").into_iter().chain(rest.find(";\n")).min().unwrap_or(rest.len());
    let body = rest[..end].split_once(['{', '(']).map_or("", |(_, body)| body);
    let fields = body.lines().map(str::trim).filter(|line| line.starts_with("pub"));
    Some(fields.map(str::to_string).collect())
}

/// The products that the signatures of a text take by `&mut`.
fn changed(text: &str, products: &BTreeSet<String>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, _) in text.match_indices("fn ") {
        let signature = &text[at..];
        let signature = &signature[..signature.find(['{', ';']).unwrap_or(signature.len())];
        for (at, mutable) in signature.match_indices("&mut ") {
            let named = signature[at + mutable.len()..].split(|c: char| !c.is_alphanumeric()).next();
            found.extend(named.filter(|name| products.contains(*name)).map(str::to_string));
        }
    }
    found
}

#[test]
fn fields_of_products_are_private() {
    let sources = sources();
    let listed = table().into_keys().chain(["Context".to_string()]);
    for product in listed {
        let found: Vec<_> = sources
            .iter()
            .filter_map(|(_, name, text)| visible_fields(text, &product).map(|fields| (name, fields)))
            .collect();
        assert!(!found.is_empty(), "ARCHITECTURE.md lists the product {product}, which is no struct");
        for (name, fields) in found {
            assert!(fields.is_empty(), "{name}: fields of {product} are visible: {fields:#?}");
        }
    }
}

#[test]
fn products_are_changed_by_the_listed_rooms() {
    let table = table();
    let products: BTreeSet<String> = table.keys().cloned().collect();
    let mut unused: BTreeSet<(String, String)> = BTreeSet::new();
    for (product, Rooms { changers, .. }) in &table {
        assert!(
            changers.len() <= 2,
            "{product} is changed by more than two rooms besides its maker: {changers:?}"
        );
        unused
            .extend(changers.iter().filter(|room| *room != ANY).map(|room| (product.clone(), room.clone())));
    }
    for (room, name, text) in sources() {
        for product in changed(&text, &products) {
            let Rooms { makers, changers } = &table[&product];
            assert!(
                makers.contains(&room) || changers.contains(&room) || changers.contains(ANY),
                "{name} takes `&mut {product}`, but ARCHITECTURE.md does not list `{room}` for it"
            );
            unused.remove(&(product, room.clone()));
        }
    }
    assert!(unused.is_empty(), "ARCHITECTURE.md lists rooms that do not change these products: {unused:?}");
}

#[test]
fn a_planted_field_and_a_planted_change_are_found() {
    let text =
        "pub struct Tree<P> {\n    pub(crate) root: P,\n    leaves: u8,\n}\n\nstruct Treetop(pub u8);\n";
    assert_eq!(visible_fields(text, "Tree").unwrap(), ["pub(crate) root: P,"]);
    assert_eq!(visible_fields(text, "Treetop").unwrap(), ["pub u8)"]);
    assert_eq!(visible_fields(text, "Top"), None);
    let products: BTreeSet<String> = ["Tree".to_string()].into();
    let text = "async fn grow<P>(\n    cx: &mut Context<P>,\n    tree: &mut Tree<P>,\n) -> u8 {\n    0\n}\n";
    assert_eq!(changed(text, &products), products);
    assert!(changed("fn look(tree: &Tree) {\n    let x: &mut Tree;\n}\n", &products).is_empty());
}
