//! Why there is no page.

use thiserror::Error;

/// Why there is no page.
#[derive(Debug, Error)]
pub enum PageError {
    /// A text that is not JSON.
    #[error("{name}, line {line}: not JSON ({why})")]
    Syntax {
        /// The file.
        name: String,
        /// Its line, from 1.
        line: usize,
        /// What the parser says.
        why: String,
    },
    /// JSON that is no run.
    #[error(
        "{name}, line {line}: no run of septet (neither `schema` septet-run/1 or septet-mesh/1 nor `phases`)"
    )]
    NoRun {
        /// The file.
        name: String,
        /// Its line, from 1.
        line: usize,
    },
    /// A run without what every run has.
    #[error("{name}, line {line}: a run of septet without `{field}`")]
    Missing {
        /// The file.
        name: String,
        /// Its line, from 1.
        line: usize,
        /// What is not there.
        field: &'static str,
    },
    /// A report of a mesh with a field that is not what it should be.
    #[error("{name}, line {line}: not a mesh's report: `{field}`: {why}")]
    Field {
        /// The file.
        name: String,
        /// Its line, from 1.
        line: usize,
        /// The field, by its path.
        field: String,
        /// What is wrong with it.
        why: String,
    },
    /// Nothing given.
    #[error("no run to show")]
    Empty,
}
