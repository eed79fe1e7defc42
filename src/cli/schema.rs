//! `septet schema`: JSON schemas of the reports and of cost traces.

use clap::{Args, ValueEnum};

use super::errors::Failure;
use super::files;

/// Options of `septet schema`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet schema run > run.schema.json
  septet schema mesh")]
pub struct SchemaArgs {
    /// Report to describe
    #[arg(value_enum)]
    report: Which,
}

/// The reports in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Which {
    /// `--json` of `septet triangulate` and `septet simulate`
    Run,
    /// `--json` of `septet mesh`
    Mesh,
    /// A line of `septet scale`
    Scale,
    /// `--json` of `septet fit`
    Fit,
    /// `--json` of `septet fit --speedup`
    Speedup,
    /// `--json` of `septet reproduce`
    Claims,
    /// `--json` of `septet predict`
    Predict,
    /// `--json` of `septet rival`
    Rival,
    /// `--json` of `septet verify`
    Verify,
    /// A line of `--cost-trace` of `septet simulate`
    Cost,
}

impl Which {
    /// Returns the schema as JSON text.
    fn text(self) -> &'static str {
        match self {
            Which::Run => include_str!("schemas/run.schema.json"),
            Which::Mesh => include_str!("schemas/mesh.schema.json"),
            Which::Scale => include_str!("schemas/scale.schema.json"),
            Which::Fit => include_str!("schemas/fit.schema.json"),
            Which::Speedup => include_str!("schemas/speedup.schema.json"),
            Which::Claims => include_str!("schemas/claims.schema.json"),
            Which::Predict => include_str!("schemas/predict.schema.json"),
            Which::Rival => include_str!("schemas/rival.schema.json"),
            Which::Verify => include_str!("schemas/verify.schema.json"),
            Which::Cost => include_str!("schemas/cost.schema.json"),
        }
    }
}

/// Prints a schema to standard output.
pub fn run(args: &SchemaArgs) -> Result<(), Failure> {
    Ok(files::print(args.report.text())?)
}
