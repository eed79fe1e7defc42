//! Pictures with their captions and tables.

use serde::Serialize;
use serde_json::Value;

use super::svg::Drawing;

/// A table under a picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Table {
    /// Heads, with units.
    pub columns: Vec<String>,
    /// One entry a column.
    pub rows: Vec<Vec<Value>>,
}

impl Table {
    pub(super) fn new(columns: &[&str]) -> Self {
        Table { columns: columns.iter().map(|&c| c.to_owned()).collect(), rows: Vec::new() }
    }
}

/// One way to draw a figure: a phase, a measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// What tells it from the others.
    pub name: String,
    /// The drawing, without its own style.
    pub body: Drawing,
    /// The numbers in it.
    pub table: Table,
}

/// A picture with a caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of its file.
    pub id: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What is to be seen.
    pub caption: String,
    /// At least one.
    pub variants: Vec<Variant>,
}
