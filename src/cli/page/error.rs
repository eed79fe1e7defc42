//! Errors of the page.

use thiserror::Error;

/// A reason why an input cannot be shown.
#[derive(Debug, Error)]
pub enum PageError {
    /// The text is not JSON.
    #[error("{name}, line {line}: not JSON ({why})")]
    Syntax {
        /// Name of the file.
        name: String,
        /// 1-based line number.
        line: usize,
        /// Message of the parser.
        why: String,
    },
    /// The JSON is not a report.
    #[error(
        "{name}, line {line}: not a septet report (neither `schema` septet-run/2 or septet-mesh/2 nor `phases`)"
    )]
    NoRun {
        /// Name of the file.
        name: String,
        /// 1-based line number.
        line: usize,
    },
    /// A required field is missing.
    #[error("{name}, line {line}: the report has no field `{field}`")]
    Missing {
        /// Name of the file.
        name: String,
        /// 1-based line number.
        line: usize,
        /// Name of the missing field.
        field: &'static str,
    },
    /// A field of a mesh report is invalid.
    #[error("{name}, line {line}: not the report of a mesh: `{field}`: {why}")]
    Field {
        /// Name of the file.
        name: String,
        /// 1-based line number.
        line: usize,
        /// Path of the field.
        field: String,
        /// The reason.
        why: String,
    },
    /// The input is empty.
    #[error("the input contains no reports")]
    Empty,
}
