//! Figures with captions and tables.

use serde::Serialize;
use serde_json::Value;

use super::svg::Drawing;

/// The table of a figure.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DataTable {
    /// Column headings with units.
    pub columns: Vec<String>,
    /// Rows with one entry per column.
    pub rows: Vec<Vec<Value>>,
}

impl DataTable {
    pub(super) fn new(columns: &[&str]) -> Self {
        DataTable { columns: columns.iter().map(|&c| c.to_owned()).collect(), rows: Vec::new() }
    }
}

/// A variant of a figure, such as one phase or one measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Name of the variant.
    pub name: String,
    /// The drawing, without a style.
    pub body: Drawing,
    /// The numbers of the drawing.
    pub table: DataTable,
}

/// A figure with a caption.
#[derive(Clone, Debug, PartialEq)]
pub struct PageFigure {
    /// File name without extension.
    pub id: &'static str,
    /// The heading.
    pub title: &'static str,
    /// The caption.
    pub caption: String,
    /// The variants, at least one.
    pub variants: Vec<Variant>,
}
