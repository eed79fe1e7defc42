//! The extent of the experiments.

use serde::Serialize;

/// The extent of the experiments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// A third of the quick sizes and fewer sets. Tests of the claims use it, and the command line does not offer it.
    Brief,
    /// Less than three minutes on two cores.
    #[default]
    Quick,
    /// Up to 2^24 points where the phase allows, which takes hours.
    Full,
}
