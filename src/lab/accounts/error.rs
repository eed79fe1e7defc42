//! Errors of the second account.

use septet_core::Remedy;
use thiserror::Error;

/// A text that is not a complete cost trace.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AccountError {
    /// The text cannot be read.
    #[error("line {line} cannot be read: {source}")]
    Unreadable {
        /// The line, from 1.
        line: u64,
        /// The error.
        source: std::io::Error,
    },
    /// There is no line.
    #[error("the cost trace is empty")]
    Empty,
    /// A line is neither a header nor a row.
    #[error("line {line} is not a line of a cost trace: {source}")]
    Syntax {
        /// The line, from 1.
        line: u64,
        /// The error.
        source: serde_json::Error,
    },
    /// The text has another format.
    #[error("the format is `{found}` instead of `septet-cost/1`")]
    Schema {
        /// The format in the text.
        found: String,
    },
    /// The number of a row is not its position.
    #[error("row {expected} is missing: row {found} is at its position")]
    Missing {
        /// The missing row.
        expected: u64,
        /// The row at its position.
        found: u64,
    },
    /// The number of rows differs from the header.
    #[error("the trace has {found} of {expected} rows")]
    Incomplete {
        /// The number in the header.
        expected: u64,
        /// The number of rows.
        found: u64,
    },
    /// A row names a row that does not come before it.
    #[error("row {row} names row {after} in `after`, which does not come before it")]
    Order {
        /// The row.
        row: u64,
        /// The row that it names.
        after: u64,
    },
    /// A row other than the first names no earlier row.
    #[error("row {row} has no predecessor in `after`")]
    Loose {
        /// The row.
        row: u64,
    },
    /// A row other than the last is named by no later row.
    #[error("row {row} has no successor")]
    Unused {
        /// The row.
        row: u64,
    },
    /// A primitive has no price.
    #[error("row {row}: the primitive `{primitive}` has no price")]
    Primitive {
        /// The row.
        row: u64,
        /// The primitive.
        primitive: String,
    },
    /// No phase has this name.
    #[error("row {row}: there is no phase `{phase}`")]
    Phase {
        /// The row.
        row: u64,
        /// The name.
        phase: String,
    },
    /// The node id of a row is 0. Ids begin with 1, the root.
    #[error("row {row}: there is no node 0, because the root is 1")]
    Node {
        /// The row.
        row: u64,
    },
    /// A count is above the largest 64-bit number.
    #[error("row {row}: work or depth is above 2^64 - 1")]
    Overflow {
        /// The row.
        row: u64,
    },
    /// The longest lane makes a call more often than all lanes together.
    #[error("row {row}: `longest` has calls that `calls` does not have")]
    Longest {
        /// The row.
        row: u64,
    },
    /// More than two `lanes` are nested.
    #[error("row {row}: `lanes` may contain `lanes` at one level only")]
    Nesting {
        /// The row.
        row: u64,
    },
}

impl AccountError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(Remedy::of(match self {
            Self::Empty | Self::Syntax { .. } | Self::Schema { .. } => {
                "give a file that `septet simulate` wrote with {cost-trace}"
            }
            Self::Primitive { .. } | Self::Phase { .. } => "use the version of septet that wrote the trace",
            Self::Unreadable { .. }
            | Self::Missing { .. }
            | Self::Incomplete { .. }
            | Self::Order { .. }
            | Self::Loose { .. }
            | Self::Unused { .. }
            | Self::Node { .. }
            | Self::Overflow { .. }
            | Self::Longest { .. }
            | Self::Nesting { .. } => "write the cost trace again",
        }))
    }
}

/// A text that is not the report of the run that wrote the cost trace.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The text is not a report.
    #[error("the text is not the report of a run: {0}")]
    Syntax(#[from] serde_json::Error),
    /// The text has another format.
    #[error("the format is `{found}` instead of `septet-run/2`")]
    Schema {
        /// The format in the text.
        found: String,
    },
    /// The run does not count work and depth.
    #[error("this run has no counts")]
    NoCounts,
    /// The seeds differ.
    #[error("the report belongs to another run: it has seed {reported}, and the trace has seed {traced}")]
    Seed {
        /// The seed of the report.
        reported: u64,
        /// The seed of the trace.
        traced: u64,
    },
    /// The numbers of points differ.
    #[error("the report belongs to another run: it has {reported} points, and the trace has {traced} points")]
    Points {
        /// The number of distinct points of the report.
        reported: u64,
        /// The number of distinct points of the trace.
        traced: u64,
    },
}

impl ReportError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(Remedy::of(match self {
            Self::Syntax(_) | Self::Schema { .. } => "give a file that `septet simulate` wrote with {json}",
            Self::NoCounts => "run `septet simulate` with {json}",
            Self::Seed { .. } | Self::Points { .. } => "write both files in one run",
        }))
    }
}
