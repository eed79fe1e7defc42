//! Tables in Markdown and CSV.

use std::fmt::Write;

/// A table with named columns.
pub struct Table {
    names: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates a table without rows.
    pub fn new(names: &[&'static str]) -> Self {
        Table { names: names.to_vec(), rows: Vec::new() }
    }

    /// Adds a row with an entry for each column.
    pub fn push(&mut self, row: Vec<String>) {
        assert_eq!(row.len(), self.names.len(), "an entry for each column");
        let words = self.names.iter().copied().chain(row.iter().map(String::as_str));
        assert!(
            words.into_iter().all(|word| !word.contains([',', '"', '|'])),
            "entries cannot contain separators"
        );
        self.rows.push(row);
    }

    /// Formats the table as Markdown.
    pub fn markdown(&self) -> String {
        let mut out = format!("| {} |\n|{}\n", self.names.join(" | "), "---|".repeat(self.names.len()));
        for row in &self.rows {
            // Writing to a string does not fail.
            let _ = writeln!(out, "| {} |", row.join(" | "));
        }
        out
    }

    /// Formats the table as CSV. No entry contains a comma or a quote.
    pub fn csv(&self) -> String {
        let mut out = self.names.join(",") + "\n";
        for row in &self.rows {
            let _ = writeln!(out, "{}", row.join(","));
        }
        out
    }
}

/// Formats a mean with one decimal.
pub fn mean(sum: u64, runs: u64) -> String {
    format!("{:.1}", sum as f64 / runs.max(1) as f64)
}

/// Formats a mean as a whole number.
pub fn whole(sum: u64, runs: u64) -> String {
    format!("{:.0}", sum as f64 / runs.max(1) as f64)
}
