//! Texts of messages and remedies.

use std::path::Path;

use septet_core::Remedy;

use crate::format::Role;

/// Returns the advice to choose columns, with an example if there is one.
pub(super) fn choose_columns(example: &str) -> Remedy {
    if example.is_empty() {
        return Remedy::of(
            "choose the columns of the coordinates with {columns}, by name or by number from 1",
        );
    }
    Remedy::of("choose the columns of the coordinates, such as {columns} ").and(example)
}

/// Returns the remedy for a file of an unknown format.
pub(super) fn known_formats(advice: Option<&str>, role: Role) -> Remedy {
    let near = advice.map_or_else(String::new, |advice| format!("{advice}, or "));
    let remedy = Remedy::plain(near).and("use one of ").and(role.known());
    if role == Role::Points {
        remedy.then(", or state the format with {input-format} or {raw}")
    } else {
        remedy
    }
}

/// Formats the name of the file for messages.
pub(in super::super) fn shown(path: &Path) -> String {
    if path.as_os_str() == "-" { "standard input".to_owned() } else { path.display().to_string() }
}

pub(super) fn at_column(column: Option<u32>) -> String {
    column.map_or_else(String::new, |column| format!(", column {column}"))
}

pub(super) fn of_points(limit: Option<u64>) -> String {
    limit.map_or_else(String::new, |limit| format!(" and there are {limit} points"))
}

/// Formats the names of the columns for messages.
pub(super) fn listed(names: &[String]) -> String {
    const MOST: usize = 20;
    let shown = names[..names.len().min(MOST)].join(", ");
    match names.len() {
        0 => String::new(),
        1..=MOST => format!(" (columns: {shown})"),
        more => format!(" (columns: {shown} and {} more)", more - MOST),
    }
}
