//! The extent of the experiments.

use serde::Serialize;

/// The extent of the experiments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// A third of the quick sizes, and fewer sets. Tests of the claims use it. It is not available on the command line.
    Brief,
    /// Less than three minutes on two cores.
    #[default]
    Quick,
    /// Eight to twelve octaves of sizes and more seeds. This takes hours.
    Full,
}

impl Extent {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Extent::Brief => "brief",
            Extent::Quick => "quick",
            Extent::Full => "full",
        }
    }
}
