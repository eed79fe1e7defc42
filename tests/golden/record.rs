//! The record of a case: lines of outputs, lines of counts, and their full text.

use std::fmt::{Debug, Display, Write as _};

use sha2::{Digest, Sha256};

use crate::calls::{MeshOutcome, Outcome};

/// Numbers in a line of the full text.
const NUMBERS_OF_A_LINE: usize = 12;

/// One section of the counts of a run, such as the traffic of its links: an entry a line, as `Debug` prints it. So a
/// field that a type gains is in the record.
#[derive(Clone, Debug)]
pub struct Section {
    name: &'static str,
    entries: Vec<String>,
}

impl Section {
    /// A section of these entries.
    pub fn new<E: Debug>(name: &'static str, entries: impl IntoIterator<Item = E>) -> Self {
        Section { name, entries: entries.into_iter().map(|entry| format!("{entry:?}")).collect() }
    }

    /// Adds other entries.
    pub fn and_all<T: Debug>(self, entries: impl IntoIterator<Item = T>) -> Self {
        entries.into_iter().fold(self, Section::and)
    }

    /// Adds another entry.
    pub fn and(mut self, entry: impl Debug) -> Self {
        self.entries.push(format!("{entry:?}"));
        self
    }

    /// Hash of all values in order. Names of structs and fields are not in it.
    fn hash(&self) -> String {
        let mut hash = Sha256::new();
        for entry in &self.entries {
            for value in values(entry) {
                hash.update(value);
                hash.update(" ");
            }
            hash.update("\n");
        }
        hexadecimal(&hash.finalize()[..16])
    }
}

/// The words of a text of `Debug` that are not names of structs or fields. Punctuation is left out.
fn values(text: &str) -> impl Iterator<Item = &str> {
    let delimits = |c: char| !(c.is_alphanumeric() || "._-".contains(c));
    let pieces = move || text.split_inclusive(delimits);
    let pairs = pieces().zip(pieces().skip(1).chain([""]));
    let values = pairs.filter(|(piece, next)| !piece.ends_with(':') && !next.starts_with('{'));
    values.map(move |(piece, _)| piece.trim_end_matches(delimits)).filter(|word| !word.is_empty())
}

/// The lines of one case.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Lines of outputs.
    pub outputs: Vec<String>,
    /// Lines of counts: the run, the section, the number of its entries, and their hash.
    pub counts: Vec<String>,
    /// What the hashes stand for.
    pub text: String,
    /// Draws of separators beyond the first of each node.
    pub retries: u64,
}

impl Record {
    /// Adds a line of outputs.
    pub fn output(&mut self, run: &str, what: &str, value: impl Display) {
        self.outputs.push(format!("{run} {what} {value}"));
        let _ = writeln!(self.text, "{run} {what} {value}");
    }

    /// Adds a short value as it is, a long one by its length and its hash.
    pub fn value(&mut self, run: &str, what: &str, value: &str) {
        if value.len() <= 80 {
            return self.output(run, what, value);
        }
        self.output(run, what, format_args!("{} {}", value.len(), sha256(value.as_bytes())));
        let _ = writeln!(self.text, "{run} {what} {value}");
    }

    /// Adds the count and the hash of numbers.
    pub fn numbers(&mut self, run: &str, what: &str, numbers: &[u64]) {
        if numbers.is_empty() {
            return;
        }
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        self.output(run, what, format_args!("{} {}", numbers.len(), sha256(&bytes)));
        for line in numbers.chunks(NUMBERS_OF_A_LINE) {
            let _ = writeln!(self.text, "{run} {what} {line:?}");
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
        self.counts(run, &o.counts);
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
        self.counts(run, &o.counts);
    }

    /// Adds a line for each section that has entries.
    pub fn counts(&mut self, run: &str, sections: &[Section]) {
        for section in sections.iter().filter(|section| !section.entries.is_empty()) {
            let Section { name, entries } = section;
            self.counts.push(format!("{run} {name} {} {}", entries.len(), section.hash()));
            for entry in entries {
                let _ = writeln!(self.text, "{run} {name} {entry}");
            }
        }
    }
}

/// As hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
