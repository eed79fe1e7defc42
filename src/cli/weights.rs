//! Weights of points: the options of commands that take them.

use std::path::Path;

use clap::Args;
use septet_core::Spec;
use septet_io::Role;
use septet_io::read::{WeightOption, WeightSource};

use super::errors::{Code, Failure};
use super::given::Options;
use super::headings::INPUT;

/// The first line of the help of `--weights`.
const WEIGHTS: &str = "Weights of the points (squared lengths): a column, or a file of one number a row";

/// The first line of the help of `--radii`.
const RADII: &str = "Radii of the points, whose squares are the weights: a column, or a file";

/// Options of weights.
#[derive(Debug, Default, Args)]
pub struct WeightArgs {
    #[arg(long, value_name = "COLUMN|FILE", conflicts_with = "radii", help = WEIGHTS, long_help = weights_help(), help_heading = INPUT, hide_short_help = true)]
    weights: Option<String>,
    #[arg(long, value_name = "COLUMN|FILE", help = RADII, long_help = radii_help(), help_heading = INPUT, hide_short_help = true)]
    radii: Option<String>,
}

/// The weights of points as given on the command line.
#[derive(Clone, Copy, Debug)]
pub struct GivenWeights<'a> {
    /// The argument: a column or a file.
    pub argument: &'a str,
    /// Whether the numbers are radii.
    pub are_radii: bool,
}

impl WeightArgs {
    /// Returns the weights, if they are given.
    pub fn given(&self) -> Option<GivenWeights<'_>> {
        let of = |argument, are_radii| GivenWeights { argument, are_radii };
        let weights = self.weights.as_deref().map(|argument| of(argument, false));
        weights.or_else(|| self.radii.as_deref().map(|argument| of(argument, true)))
    }
}

impl<'a> GivenWeights<'a> {
    /// Returns the spelling of the option.
    fn option(self) -> &'static str {
        if self.are_radii { "--radii" } else { "--weights" }
    }

    /// Returns the argument, if the numbers are weights.
    pub fn weights(self) -> Option<&'a str> {
        (!self.are_radii).then_some(self.argument)
    }

    /// Returns the argument, if the numbers are radii.
    pub fn radii(self) -> Option<&'a str> {
        self.are_radii.then_some(self.argument)
    }

    /// Returns the option of the reader.
    pub fn reading(self) -> WeightOption {
        WeightOption { source: WeightSource::of_argument(self.argument), are_radii: self.are_radii }
    }

    /// Returns the file of the weights, if they are not in a column.
    pub fn file(self) -> Option<&'a Path> {
        let path = Path::new(self.argument);
        matches!(WeightSource::of_argument(self.argument), WeightSource::File(_)).then_some(path)
    }

    /// Refuses weights of a generated sample or of a terrain.
    pub fn check(self, given: &Options<Spec>, is_sample: bool) -> Result<(), Failure> {
        let option = self.option();
        if is_sample {
            let message = format!("{option} applies to files, not to a generated sample");
            return Err(Failure::new(Code::Usage, message).help(format!("omit {option}, or give a file")));
        }
        if given.has("terrain") {
            let message = format!("{option} contradicts --terrain: the points of a terrain have no weights");
            return Err(Failure::new(Code::Usage, message).help(format!("omit {option} or --terrain")));
        }
        Ok(())
    }
}

fn weights_help() -> String {
    format!(
        "{WEIGHTS}\n\n\
         The triangulation is then the regular one: points whose height |x|^2 - weight lies above the lower hull are \
         hidden, and are not vertices. A column is a name from the header row or a 1-based number, in {}. It is not a coordinate. A name with the \
         ending of a format is a file: {}. Its rows are those of the input, including rows that are dropped.",
        Role::WeightColumn.extensions(|_| true),
        Role::Weights.known()
    )
}

fn radii_help() -> String {
    format!("{RADII}\n\nRadii are 0 or more. Otherwise as --weights.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_ending_is_a_file() {
        let of = |weights: Option<&str>, radii: Option<&str>| WeightArgs {
            weights: weights.map(str::to_owned),
            radii: radii.map(str::to_owned),
        };
        assert!(of(None, None).given().is_none());
        let file = of(None, Some("r.npy"));
        let given = file.given().unwrap();
        assert_eq!((given.file(), given.reading().are_radii), (Some(Path::new("r.npy")), true));
        let column = of(Some("mass"), None);
        let given = column.given().unwrap();
        assert_eq!((given.file(), given.reading().are_radii), (None, false));
    }
}
