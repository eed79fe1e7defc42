//! Errors of the second account.

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
    /// A line is not a row.
    #[error("line {line} is not a row of a cost trace: {source}")]
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
    #[error("{found} of {expected} rows are there: the cost trace is incomplete")]
    Incomplete {
        /// The number in the header.
        expected: u64,
        /// The number of rows.
        found: u64,
    },
    /// A row names a row that does not come before it.
    #[error("row {row} is after row {after}, which does not come before it")]
    Order {
        /// The row.
        row: u64,
        /// The row that it names.
        after: u64,
    },
    /// A row other than the first names no row.
    #[error("row {row} is after no other row")]
    Loose {
        /// The row.
        row: u64,
    },
    /// No row names a row other than the last.
    #[error("no row is after row {row}")]
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
    /// The longest lane makes a call that its vector step does not count.
    #[error("row {row}: the longest lane has calls that the vector step does not have")]
    Longest {
        /// The row.
        row: u64,
    },
}
