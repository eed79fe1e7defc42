//! The lines of a cost trace.

use serde::Deserialize;

use super::error::AccountError;

/// Name and version of the format of cost traces.
pub const SCHEMA: &str = "septet-cost/1";

/// The first line. The account does not depend on the other fields of the line.
#[derive(Debug, Deserialize)]
pub(super) struct Header {
    /// Number of points.
    pub(super) points: u64,
    /// The seed of the run.
    pub(super) seed: u64,
    /// Number of rows.
    pub(super) rows: u64,
}

/// The name of the format, which is read first: other formats have other fields.
#[derive(Debug, Deserialize)]
struct Format {
    schema: String,
}

impl Header {
    pub(super) fn parse(line: &str) -> Result<Self, AccountError> {
        let syntax = |source| AccountError::Syntax { line: 1, source };
        let Format { schema } = serde_json::from_str(line).map_err(syntax)?;
        if schema != SCHEMA {
            return Err(AccountError::Schema { found: schema });
        }
        serde_json::from_str(line).map_err(syntax)
    }
}

/// A call of a primitive, or a vector step whose items have their own calls.
#[derive(Debug, Deserialize)]
pub(super) struct Entry {
    pub(super) primitive: String,
    pub(super) items: u64,
    /// The calls of all lanes.
    #[serde(default)]
    pub(super) calls: Vec<Calls>,
    /// The calls of the longest lane, in their order.
    #[serde(default)]
    pub(super) longest: Vec<Entry>,
}

/// Equal calls of all lanes of a vector step.
#[derive(Debug, Deserialize)]
pub(super) struct Calls {
    pub(super) primitive: String,
    pub(super) items: u64,
    /// The number of times that the call occurs.
    pub(super) times: u64,
}

/// One row.
#[derive(Debug, Deserialize)]
pub(super) struct Row {
    /// The position of the row, from 0.
    #[expect(clippy::struct_field_names, reason = "the name in the format")]
    pub(super) row: u64,
    pub(super) phase: String,
    #[serde(default)]
    pub(super) node: Option<u64>,
    #[serde(default)]
    pub(super) step: Option<u32>,
    #[serde(flatten)]
    pub(super) entry: Entry,
    /// The rows that end before this row starts.
    pub(super) after: Vec<u64>,
}

impl Row {
    pub(super) fn parse(line: u64, text: &str) -> Result<Self, AccountError> {
        serde_json::from_str(text).map_err(|source| AccountError::Syntax { line, source })
    }
}
