//! A card: a number with its name and a note.

use crate::page::svg::escape;
use std::fmt::Write;

pub(super) fn card(out: &mut String, name: &str, value: &str, note: &str) {
    let (name, value, note) = (escape(name), escape(value), escape(note));
    let _ = writeln!(out, "<div><dt>{name}</dt><dd>{value}</dd><dd class=\"note\">{note}</dd></div>");
}
