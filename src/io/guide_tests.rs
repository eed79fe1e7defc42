//! The tables of the guide and the list in README, against the table of formats.
//!
//! `SEPTET_GUIDE=write cargo test -p septet-io guide` writes them.

use std::fs;
use std::path::Path;

use crate::format::{Format, Role, Row};

/// Joins the cells of a row.
fn line(cells: impl IntoIterator<Item = String>) -> String {
    cells
        .into_iter()
        .fold("|".to_owned(), |line, cell| line + if cell.is_empty() { "" } else { " " } + &cell + " |")
        + "\n"
}

fn dotted(extensions: &[&str]) -> String {
    extensions.iter().map(|extension| format!("`.{extension}`")).collect::<Vec<_>>().join(" ")
}

fn remark(row: &Row, role: Role) -> String {
    row.remark(role).map_or("", |text| if text.is_empty() { "yes" } else { text }).to_owned()
}

/// The table of the uses of all formats.
fn uses() -> String {
    let roles = [
        Role::Points,
        Role::Weights,
        Role::Cells,
        Role::Domain,
        Role::Sizes,
        Role::Triangulation,
        Role::PointSet,
    ];
    let heads = [
        "extension",
        "points in",
        "weights in",
        "cells in (`verify`)",
        "domain in (`mesh`)",
        "sizes in (`mesh`)",
        "triangulation out",
        "points out (`generate`)",
    ];
    let mut text = line(heads.map(str::to_owned)) + &"|---".repeat(heads.len()) + "|\n";
    for row in Format::ALL.iter().map(|format| format.row()) {
        let also = if row.ambiguous.is_empty() {
            String::new()
        } else {
            format!(" (input also {})", dotted(row.ambiguous))
        };
        let name = dotted(row.extensions) + &also;
        text += &line([name].into_iter().chain(roles.map(|role| remark(row, role))));
    }
    text
}

/// The table of the files of meshes of domains.
fn meshes() -> String {
    let heads =
        ["extension", "cells", "faces on facets (2D: edges on segments)", "edges on segments", "points"];
    let mut text = line(heads.map(str::to_owned)) + &"|---".repeat(heads.len()) + "|\n";
    for row in Format::ALL.iter().map(|format| format.row()) {
        if let Some(labels) = row.labels {
            text += &line([dotted(row.extensions)].into_iter().chain(labels.map(str::to_owned)));
        }
    }
    text
}

/// The sentences on formats that need a further rule.
fn rules() -> String {
    let of = |holds: fn(&Row, Role) -> bool, role: Role| {
        let names = role.formats().filter(|format| holds(format.row(), role));
        names
            .flat_map(|format| format.row().extensions)
            .map(|name| format!("`.{name}`"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    format!(
        "Every file except {} may be compressed with gzip. {} hold values at points and owners of cells.\n\
         Several processes divide the rows of {} in the input, and the cells of {} in the output.\n",
        of(|row, _| !row.is_packable, Role::Triangulation),
        of(|row, _| row.has_data, Role::Triangulation),
        of(Row::is_divided, Role::Points),
        of(Row::is_divided, Role::Triangulation),
    )
}

/// The list of README.
fn list() -> String {
    let of = |role: Role| {
        let names = role.formats().map(|format| format!("`.{}`", format.name())).collect::<Vec<_>>();
        names.join(", ")
    };
    format!(
        "- Points are read from {}.\n- Triangulations are written as {}.\n- Domains are read from {}.\n",
        of(Role::Points),
        of(Role::Triangulation),
        of(Role::Domain)
    )
}

/// Compares or writes a block of a document.
fn check(file: &str, block: &str, expected: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    let text = fs::read_to_string(&path).unwrap();
    let (begin, end) = (format!("<!-- table {block} -->\n\n"), format!("\n<!-- end {block} -->"));
    let start = text.find(&begin).unwrap_or_else(|| panic!("{file} has no block {block}")) + begin.len();
    let length = text[start..].find(&end).unwrap();
    if std::env::var_os("SEPTET_GUIDE").is_some_and(|value| value == "write") {
        fs::write(path, text[..start].to_owned() + expected + &text[start + length..]).unwrap();
    } else {
        assert_eq!(&text[start..start + length], expected, "SEPTET_GUIDE=write writes {block} of {file}");
    }
}

#[test]
fn the_guide_and_readme_have_the_table() {
    check("src/guide/formats.md", "formats", &uses());
    check("src/guide/formats.md", "format-rules", &rules());
    check("src/guide/formats.md", "meshes", &meshes());
    check("README.md", "formats", &list());
}
