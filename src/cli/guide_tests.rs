//! The table of options in the guide, against the rows of options.
//!
//! `SEPTET_GUIDE=write cargo test -p septet-cli guide` writes it.

use std::fs;

use septet_core::spec::{OPTIONS, Words};

use crate::names::with_formats;

/// Returns the table of all options, in Markdown.
fn guide_table() -> String {
    let bar = |text: &str| text.replace('|', "\\|");
    let mut table =
        "| option | meaning | values | default | can change |\n|---|---|---|---|---|\n".to_owned();
    for row in OPTIONS {
        let doc = with_formats(row.doc);
        let (meaning, more) = doc.split_once("\n\n").unwrap_or((&doc, ""));
        let ends = if more.is_empty() { "" } else { ". " };
        let words: Vec<String> = row.words.iter().map(|(word, _)| format!("`{word}`")).collect();
        let values = if row.words.is_empty() { format!("`{}`", bar(row.form)) } else { words.join(", ") };
        let values = if row.is_flag { "-".to_owned() } else { values };
        let default = row.default_text().map_or_else(|| "-".to_owned(), |text| format!("`{text}`"));
        let change = row.matters.name();
        let line =
            format!("| `--{}` | {meaning}{ends}{more} | {values} | {default} | {change} |\n", row.name);
        table.push_str(&line);
    }
    table
}

#[test]
fn the_guide_has_the_table_of_options() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../guide/options.md");
    let guide = fs::read_to_string(path).unwrap();
    let (start, end) = ("<!-- options -->\n", "<!-- end of options -->\n");
    let (before, rest) = guide.split_once(start).unwrap();
    let (table, after) = rest.split_once(end).unwrap();
    if std::env::var_os("SEPTET_GUIDE").is_some_and(|value| value == "write") {
        fs::write(path, [before, start, &guide_table(), end, after].concat()).unwrap();
    } else {
        assert_eq!(table, guide_table(), "SEPTET_GUIDE=write cargo test -p septet-cli guide writes it");
    }
}
