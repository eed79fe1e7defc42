//! The tables of options in the guide, against the rows of options.
//!
//! `SEPTET_GUIDE=write cargo test -p septet-cli guide` writes them.

use std::fs;

use septet_core::mesh::MESH_OPTIONS;
use septet_core::spec::{OPTIONS, Row, Words};

use crate::names::with_formats;

/// Returns the table of options, in Markdown.
fn table<S: Default>(rows: &[Row<S>]) -> String {
    let head = "| option | meaning | values | default | can change |\n|---|---|---|---|---|\n";
    rows.iter().map(line).fold(head.to_owned(), |table, line| table + &line)
}

fn line<S: Default>(row: &Row<S>) -> String {
    let bar = |text: &str| text.replace('|', "\\|");
    let doc = with_formats(row.doc);
    let (meaning, more) = doc.split_once("\n\n").unwrap_or((&doc, ""));
    let ends = if more.is_empty() { "" } else { ". " };
    let words: Vec<String> = row.words.iter().map(|(word, _)| format!("`{word}`")).collect();
    let values = if row.words.is_empty() { format!("`{}`", bar(row.form)) } else { words.join(", ") };
    let values = if row.is_flag { "-".to_owned() } else { values };
    let default = row.default_text().filter(|_| !row.is_flag);
    let default = default.map_or_else(|| "-".to_owned(), |text| format!("`{text}`"));
    format!("| `--{}` | {meaning}{ends}{more} | {values} | {default} | {} |\n", row.name, row.matters.name())
}

/// Compares a block of the guide with its text, or writes it.
fn compare(block: &str, expected: &str) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../guide/options.md");
    let guide = fs::read_to_string(path).unwrap();
    let (start, end) = (format!("<!-- {block} -->\n"), format!("<!-- end of {block} -->\n"));
    let (before, rest) = guide.split_once(&start).unwrap();
    let (found, after) = rest.split_once(&end).unwrap();
    if std::env::var_os("SEPTET_GUIDE").is_some_and(|value| value == "write") {
        fs::write(path, [before, &start, expected, &end, after].concat()).unwrap();
    } else {
        assert_eq!(found, expected, "SEPTET_GUIDE=write cargo test -p septet-cli guide writes it");
    }
}

// One test, because both blocks are in one file.
#[test]
fn the_guide_has_the_tables_of_options() {
    compare("options", &table(OPTIONS));
    compare("options of meshes", &table(MESH_OPTIONS));
}
