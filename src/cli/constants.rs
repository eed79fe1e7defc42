//! Options for the constants of the partition tree.

use clap::{Args, ValueEnum};
use septet_core::spec::{Purpose, Spec};

use super::headings::MACHINE;
use super::numbers::count;

/// Constants of a counted run, besides the leaf size.
#[derive(Debug, Args)]
pub struct ConstantsArgs {
    /// Constants of the partition: for little work and depth, or for little time
    ///
    /// --samples, --tries and --leaf replace single constants.
    #[arg(long, value_enum, default_value_t = PurposeArg::Counting, help_heading = MACHINE, hide_short_help = true)]
    constants: PurposeArg,
    /// Largest number of samples from which a separator is drawn; small subproblems have fewer
    #[arg(long, value_name = "M|auto", default_value = "auto", value_parser = samples, help_heading = MACHINE, hide_short_help = true)]
    samples: Auto<u64>,
    /// Number of great circles of which the best becomes the separator
    #[arg(long, value_name = "T|auto", default_value = "auto", value_parser = tries, help_heading = MACHINE, hide_short_help = true)]
    tries: Auto<u32>,
}

/// A number, or `auto`.
#[derive(Clone, Copy, Debug)]
pub struct Auto<T>(pub Option<T>);

/// `--constants`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PurposeArg {
    /// Little work and depth
    Counting,
    /// Little time
    Timing,
}

impl ConstantsArgs {
    /// Returns `spec` with these options applied.
    pub fn extend(&self, spec: Spec) -> Spec {
        spec.with(|c| {
            c.tree.constants.purpose = match self.constants {
                PurposeArg::Counting => Purpose::Counting,
                PurposeArg::Timing => Purpose::Timing,
            };
            c.tree.constants.samples = self.samples.0;
            c.tree.constants.tries = self.tries.0;
        })
    }
}

/// Parses a whole number, or `auto`.
pub fn auto(text: &str) -> Result<Auto<u64>, String> {
    if text == "auto" { Ok(Auto(None)) } else { count(text).map(|number| Auto(Some(number))) }
}

fn samples(text: &str) -> Result<Auto<u64>, String> {
    auto(text)
}

fn tries(text: &str) -> Result<Auto<u32>, String> {
    let Auto(number) = auto(text)?;
    let small = number.map(u32::try_from).transpose().map_err(|_| "expected a smaller number".to_owned())?;
    Ok(Auto(small))
}
