//! The report of `septet verify`.

use std::path::Path;

use serde::Serialize;

/// Name and version of the schema of [`VerifyReport`].
pub const VERIFY_SCHEMA: &str = "septet-verify/1";

/// The verified files, and the result.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct VerifyReport<'a> {
    /// Name and version of this schema.
    #[cfg_attr(feature = "schema", schemars(extend("const" = VERIFY_SCHEMA)))]
    pub schema: &'static str,
    /// Version of septet.
    pub version: &'static str,
    /// The file of points.
    pub points_file: &'a str,
    /// The file of cells.
    pub cells_file: String,
    /// Whether the cells are a Delaunay triangulation.
    pub passed: bool,
    /// The levels of verification, with the first faults of each.
    #[serde(flatten)]
    pub report: &'a septet_verify::Report,
}

impl<'a> VerifyReport<'a> {
    /// Returns the report on these two files.
    pub fn of(report: &'a septet_verify::Report, points: &'a str, cells: &Path) -> Self {
        VerifyReport {
            schema: VERIFY_SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            points_file: points,
            cells_file: cells.display().to_string(),
            passed: report.passed(),
            report,
        }
    }
}
