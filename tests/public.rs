//! The library's public items, as rustdoc lists them: they change only together with `tests/public.txt`.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// A user can read a list of this length.
const MOST_ITEMS: usize = 285;

/// Documents the library alone and returns rustdoc's list of all items.
fn list() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = root.join("target/public");
    let output = Command::new(env!("CARGO"))
        .args(["doc", "--quiet", "--lib", "--no-deps", "--locked", "--offline", "--no-default-features"])
        .args(["--package", "septet", "--target-dir"])
        .arg(&place)
        .current_dir(root)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::read_to_string(place.join("doc/septet/all.html")).unwrap()
}

/// The items: each is a link `<a href="kind.name.html">path</a>` in a list.
fn items(html: &str) -> BTreeSet<String> {
    let entries = html.split("<li><a href=\"").skip(1).filter_map(|rest| {
        let (link, rest) = rest.split_once("\">")?;
        let (path, _) = rest.split_once("</a>")?;
        let (kind, _) = link.rsplit('/').next()?.split_once('.')?;
        Some(format!("{kind} {path}"))
    });
    entries.collect()
}

#[test]
fn the_public_items_are_those_of_the_list() {
    let found = items(&list());
    assert!(found.len() <= MOST_ITEMS, "{} public items", found.len());
    let listed: BTreeSet<String> = include_str!("public.txt").lines().map(str::to_owned).collect();
    let added: Vec<_> = found.difference(&listed).collect();
    let removed: Vec<_> = listed.difference(&found).collect();
    assert!(
        added.is_empty() && removed.is_empty(),
        "new: {added:#?}\ngone: {removed:#?}\nif that is meant, change tests/public.txt"
    );
}
