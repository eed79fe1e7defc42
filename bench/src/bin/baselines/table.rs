//! A table, as Markdown and as CSV.

use std::fmt::Write;

/// Rows under names.
pub struct Table {
    names: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(names: &[&'static str]) -> Self {
        Table { names: names.to_vec(), rows: Vec::new() }
    }

    /// Adds a row, one cell for each name.
    pub fn push(&mut self, row: Vec<String>) {
        assert_eq!(row.len(), self.names.len(), "a cell for each column");
        let words = self.names.iter().copied().chain(row.iter().map(String::as_str));
        assert!(
            words.into_iter().all(|word| !word.contains([',', '"', '|'])),
            "CSV and Markdown quote nothing"
        );
        self.rows.push(row);
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        let mut out = format!("| {} |\n|{}\n", self.names.join(" | "), "---|".repeat(self.names.len()));
        for row in &self.rows {
            // Writing to a string does not fail.
            let _ = writeln!(out, "| {} |", row.join(" | "));
        }
        out
    }

    /// As CSV; no cell holds a comma or a quote.
    pub fn csv(&self) -> String {
        let mut out = self.names.join(",") + "\n";
        for row in &self.rows {
            let _ = writeln!(out, "{}", row.join(","));
        }
        out
    }
}

/// The mean of a sum, to a tenth.
pub fn mean(sum: u64, runs: u64) -> String {
    format!("{:.1}", sum as f64 / runs.max(1) as f64)
}

/// The mean of a large sum, to a whole number.
pub fn whole(sum: u64, runs: u64) -> String {
    format!("{:.0}", sum as f64 / runs.max(1) as f64)
}
