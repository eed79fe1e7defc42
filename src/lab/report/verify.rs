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
    /// Column or file of the weights, if they are given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<&'a str>,
    /// Column or file of the radii, if they are given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radii: Option<&'a str>,
    /// The periodic box, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periodic: Option<VerifiedBox>,
    /// Whether the cells are a Delaunay triangulation, or a regular one of points with weights.
    pub passed: bool,
    /// The levels of verification, with the first faults of each.
    #[serde(flatten)]
    pub report: &'a septet_verify::Report,
}

/// The periodic box of verified cells.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct VerifiedBox {
    /// Length along each axis; null for an axis that is not periodic.
    #[serde(rename = "box")]
    pub lengths: Vec<Option<f64>>,
    /// The file of the offsets of the vertices.
    pub offsets_file: String,
}

impl<'a> VerifyReport<'a> {
    /// Returns the report on these two files, without weights and a periodic box.
    pub fn of(report: &'a septet_verify::Report, points: &'a str, cells: &Path) -> Self {
        VerifyReport {
            schema: VERIFY_SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            points_file: points,
            cells_file: cells.display().to_string(),
            weights: None,
            radii: None,
            periodic: None,
            passed: report.passed(),
            report,
        }
    }
}
