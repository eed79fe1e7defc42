//! How much is run.

use serde::Serialize;

/// How much is run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// A third of the quick sizes and fewer sets, for tests of claims themselves: not offered on the command line.
    Brief,
    /// Under three minutes on two cores.
    #[default]
    Quick,
    /// To 2^24 points where the phase allows; hours.
    Full,
}
