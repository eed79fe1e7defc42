//! The record of a case: lines of outputs and lines of counts.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use crate::calls::{MeshOutcome, Outcome};

/// Runs with more rows than this are kept as sums and a hash for each kind and phase.
const MOST_ROWS: usize = 250;

/// One line of counts: a kind, a subject, and numbers.
#[derive(Clone, Debug)]
pub struct Row {
    kind: &'static str,
    of: String,
    numbers: Vec<u64>,
}

impl Row {
    /// A row of these numbers.
    pub fn new(kind: &'static str, of: &str, numbers: impl IntoIterator<Item = u64>) -> Self {
        Row { kind, of: of.replace(' ', "-"), numbers: numbers.into_iter().collect() }
    }

    fn text(&self) -> String {
        let mut text = format!("{} {}", self.kind, self.of);
        for number in &self.numbers {
            let _ = write!(text, " {number}");
        }
        text
    }
}

/// Draws of separators beyond the first of each node, summed over the rounds. With a worker for every leaf, only groups
/// draw separators.
pub fn retries(rows: &[Row]) -> u64 {
    rows.iter().filter(|r| r.kind == "round" && r.of == "partition").map(|r| r.numbers[8]).sum()
}

/// The lines of one case.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Lines of outputs.
    pub outputs: Vec<String>,
    /// Lines of counts.
    pub counts: Vec<String>,
    /// Draws of separators beyond the first of each node.
    pub retries: u64,
}

impl Record {
    /// Adds a line of outputs.
    pub fn output(&mut self, run: &str, what: &str, value: impl std::fmt::Display) {
        self.outputs.push(format!("{run} {what} {value}"));
    }

    /// Adds the count and the hash of numbers.
    pub fn numbers(&mut self, run: &str, what: &str, numbers: &[u64]) {
        if !numbers.is_empty() {
            let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
            self.output(run, what, format_args!("{} {}", numbers.len(), sha256(&bytes)));
        }
    }

    fn facts(&mut self, run: &str, facts: &[(&'static str, u64)]) {
        let text: Vec<String> = facts.iter().map(|(name, value)| format!("{name}={value}")).collect();
        self.output(run, "facts", text.join(","));
    }

    /// Adds all lines of a run, or a line that it failed.
    pub fn run(&mut self, run: &str, outcome: Option<&Outcome>) {
        let Some(o) = outcome else { return self.output(run, "result", "error") };
        self.facts(run, &o.facts);
        self.numbers(run, "cells", &o.cells);
        self.numbers(run, "owners", &o.owners);
        self.numbers(run, "graph", &o.graph);
        self.numbers(run, "picture", &o.picture);
        let tree = o.rows.iter().filter(|r| r.kind == "node").flat_map(|r| r.numbers[..6].to_vec());
        self.numbers(run, "tree", &tree.collect::<Vec<_>>());
        self.rows(run, &o.rows);
    }

    /// Records a mesh, or that there is none.
    pub fn mesh(&mut self, run: &str, outcome: Option<&MeshOutcome>) {
        let Some(o) = outcome else { return self.output(run, "result", "error") };
        self.facts(run, &o.facts);
        self.numbers(run, "points", &o.points);
        self.numbers(run, "carriers", &o.carriers);
        self.numbers(run, "cells", &o.cells);
        self.numbers(run, "faces", &o.faces);
        self.numbers(run, "edges", &o.edges);
        self.rows(run, &o.rows);
    }

    /// Lines of counts: every row of a small run, sums and hashes by kind and phase of a large one.
    pub fn rows(&mut self, run: &str, rows: &[Row]) {
        if rows.len() <= MOST_ROWS {
            self.counts.extend(rows.iter().map(|row| format!("{run} {}", row.text())));
            return;
        }
        let mut groups: BTreeMap<(&str, &str), Vec<&Row>> = BTreeMap::new();
        for row in rows {
            groups.entry((row.kind, &row.of)).or_default().push(row);
        }
        for ((kind, of), rows) in groups {
            if rows.len() <= 2 {
                self.counts.extend(rows.iter().map(|row| format!("{run} {}", row.text())));
                continue;
            }
            let mut sums = vec![0u64; rows.iter().map(|r| r.numbers.len()).max().unwrap_or(0)];
            let mut text = String::new();
            for row in &rows {
                sums.iter_mut().zip(&row.numbers).for_each(|(sum, n)| *sum = sum.wrapping_add(*n));
                let _ = writeln!(text, "{}", row.text());
            }
            let sums: Vec<String> = sums.iter().map(u64::to_string).collect();
            let hash = &sha256(text.as_bytes())[..32];
            self.counts.push(format!(
                "{run} {kind} {of} x{} sums {} sha256 {hash}",
                rows.len(),
                sums.join(" ")
            ));
        }
    }
}

/// As hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
