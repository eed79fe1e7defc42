//! Errors of the second account. The clause after the last semicolon of a message states the next step.

use thiserror::Error;

/// A text that is not a complete cost trace.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AccountError {
    /// The text cannot be read.
    #[error("line {line} cannot be read: {source}; write the cost trace again")]
    Unreadable {
        /// The line, from 1.
        line: u64,
        /// The error.
        source: std::io::Error,
    },
    /// There is no line.
    #[error("the cost trace is empty; give a file that `septet simulate --cost-trace` wrote")]
    Empty,
    /// A line is neither a header nor a row.
    #[error(
        "line {line} is not a line of a cost trace: {source}; give a file that `septet simulate --cost-trace` wrote"
    )]
    Syntax {
        /// The line, from 1.
        line: u64,
        /// The error.
        source: serde_json::Error,
    },
    /// The text has another format.
    #[error(
        "the format is `{found}` instead of `septet-cost/1`; give a file that `septet simulate --cost-trace` wrote"
    )]
    Schema {
        /// The format in the text.
        found: String,
    },
    /// The number of a row is not its position.
    #[error("row {expected} is missing: row {found} is at its position; write the cost trace again")]
    Missing {
        /// The missing row.
        expected: u64,
        /// The row at its position.
        found: u64,
    },
    /// The number of rows differs from the header.
    #[error("the trace has {found} of {expected} rows; write the cost trace again")]
    Incomplete {
        /// The number in the header.
        expected: u64,
        /// The number of rows.
        found: u64,
    },
    /// A row names a row that does not come before it.
    #[error(
        "row {row} names row {after} in `after`, which does not come before it; write the cost trace again"
    )]
    Order {
        /// The row.
        row: u64,
        /// The row that it names.
        after: u64,
    },
    /// A row other than the first names no earlier row.
    #[error("row {row} has no predecessor in `after`; write the cost trace again")]
    Loose {
        /// The row.
        row: u64,
    },
    /// A row other than the last is named by no later row.
    #[error("row {row} has no successor; write the cost trace again")]
    Unused {
        /// The row.
        row: u64,
    },
    /// A primitive has no price.
    #[error(
        "row {row}: the primitive `{primitive}` has no price; use the version of septet that wrote the trace"
    )]
    Primitive {
        /// The row.
        row: u64,
        /// The primitive.
        primitive: String,
    },
    /// No phase has this name.
    #[error("row {row}: there is no phase `{phase}`; use the version of septet that wrote the trace")]
    Phase {
        /// The row.
        row: u64,
        /// The name.
        phase: String,
    },
    /// The node id of a row is 0. Ids begin with 1, the root.
    #[error("row {row}: there is no node 0, because the root is 1; write the cost trace again")]
    Node {
        /// The row.
        row: u64,
    },
    /// A count is above the largest 64-bit number.
    #[error("row {row}: work or depth is above 2^64 - 1; write the cost trace again")]
    Overflow {
        /// The row.
        row: u64,
    },
    /// The longest lane makes a call more often than all lanes together.
    #[error("row {row}: `longest` has calls that `calls` does not have; write the cost trace again")]
    Longest {
        /// The row.
        row: u64,
    },
    /// More than two `lanes` are nested.
    #[error("row {row}: `lanes` may contain `lanes` at one level only; write the cost trace again")]
    Nesting {
        /// The row.
        row: u64,
    },
}

/// A text that is not the report of the run that wrote the cost trace.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The text is not a report.
    #[error("the text is not the report of a run: {0}; give a file that `septet simulate --json` wrote")]
    Syntax(#[from] serde_json::Error),
    /// The text has another format.
    #[error(
        "the format is `{found}` instead of `septet-run/2`; give a file that `septet simulate --json` wrote"
    )]
    Schema {
        /// The format in the text.
        found: String,
    },
    /// The run does not count work and depth.
    #[error("this run has no counts; run `septet simulate --json`")]
    NoCounts,
    /// The seeds differ.
    #[error(
        "the report belongs to another run: it has seed {reported}, and the trace has seed {traced}; write both files \
         in one run"
    )]
    Seed {
        /// The seed of the report.
        reported: u64,
        /// The seed of the trace.
        traced: u64,
    },
    /// The numbers of points differ.
    #[error(
        "the report belongs to another run: it has {reported} points, and the trace has {traced} points; write both \
         files in one run"
    )]
    Points {
        /// The number of distinct points of the report.
        reported: u64,
        /// The number of distinct points of the trace.
        traced: u64,
    },
}
