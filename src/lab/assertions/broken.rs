//! The error of a failed check.

use std::fmt;

use thiserror::Error;

use crate::experiment::Line;
use crate::experiment::fit::{FitReport, FitRequest, fit};
use septet_protocol::ledger::{RoundKey, RoundRow, RoundTally};

/// A row of the table in the error: one run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Row {
    /// Number of distinct points.
    pub n: u64,
    /// Number of workers.
    pub workers: u32,
    /// Seed of the set and of the draws.
    pub seed: u64,
    /// The measured count.
    pub counted: f64,
    /// The bound.
    pub bound: f64,
    /// Whether the count exceeds the bound.
    pub beyond: bool,
}

impl Row {
    pub(super) fn at_most(line: &Line, counted: f64, bound: f64) -> Row {
        let Line { n, workers, seed, .. } = *line;
        // NaN exceeds every bound.
        let beyond = counted.is_nan() || bound.is_nan() || counted > bound;
        Row { n, workers, seed, counted, bound, beyond }
    }
}

/// Counts that exceed their bound. The error message contains the count and its bound, the table, the fit if there is
/// one, and the first round that exceeds the bound.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub struct Broken {
    /// The name of the count, and its relation to the bound.
    pub what: String,
    /// All runs that were checked. Empty for a check of growth.
    pub table: Vec<Row>,
    /// The growth of the count, if there are enough sizes for a fit.
    pub fit: Option<Box<FitReport>>,
    /// The first round, level or count that exceeds the bound, in words. For a check of growth, a round or level that
    /// may explain the failure.
    pub first: Option<String>,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.what)?;
        if !self.table.is_empty() {
            let (n, workers, seed, counted, bound) = ("n", "workers", "seed", "counted", "bound");
            writeln!(f, "  {n:>12} {workers:>8} {seed:>6} {counted:>12} {bound:>12}")?;
        }
        for row in &self.table {
            let mark = if row.beyond { "  <- above the bound" } else { "" };
            let (counted, bound) = (short(row.counted), short(row.bound));
            let Row { n, workers, seed, .. } = row;
            writeln!(f, "  {n:>12} {workers:>8} {seed:>6} {counted:>12} {bound:>12}{mark}")?;
        }
        match &self.fit {
            Some(report) => write!(f, "{}", report.text())?,
            None if self.table.len() > 1 => writeln!(f, "  too few sizes for a fit")?,
            None => {}
        }
        match &self.first {
            Some(first) => write!(f, "  first {first}"),
            None => Ok(()),
        }
    }
}

/// Formats a number with at most five decimals, and no trailing zeros.
pub(super) fn short(x: f64) -> String {
    if x == x.trunc() && x.abs() < 1e15 {
        return format!("{x:.0}");
    }
    let text = format!("{x:.5}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// Describes a round that exceeds a bound, in words.
pub(super) fn describe(row: &RoundRow) -> String {
    let RoundRow { key: RoundKey { round, phase }, tally } = row;
    let (phase, RoundTally { merged, points, messages, bytes, .. }) = (phase.name(), tally);
    format!(
        "round above the bound: round {round} of {phase}, {messages} messages, {bytes} bytes, {merged} merged, \
         {points} points"
    )
}

/// Compares a count of each run with a bound for that run. `count` returns both. If a count exceeds its bound, the
/// error contains the fit that `question` requests, and the words of `first`.
pub(super) fn compare(
    lines: &[Line],
    what: &str,
    bound_text: &str,
    count: impl Fn(&Line) -> (f64, f64),
    question: Option<&FitRequest>,
    first: impl Fn(&Line, f64) -> Option<String>,
) -> Result<(), Broken> {
    let rows: Vec<Row> = lines
        .iter()
        .map(|line| {
            let (counted, bound) = count(line);
            Row::at_most(line, counted, bound)
        })
        .collect();
    let Some(at) = rows.iter().position(|row| row.beyond) else {
        return if lines.is_empty() { Err(nothing(what)) } else { Ok(()) };
    };
    let (counted, bound) = (short(rows[at].counted), short(rows[at].bound));
    Err(Broken {
        what: format!("{what}: {counted} above {bound} = {bound_text}"),
        fit: question.and_then(|request| fit(lines, request).ok()).map(Box::new),
        first: first(&lines[at], rows[at].bound),
        table: rows,
    })
}

/// Returns the error of a check over no runs.
pub(super) fn nothing(what: &str) -> Broken {
    Broken { what: format!("{what}: no runs"), table: Vec::new(), fit: None, first: None }
}
