//! Options for file formats, shared by the commands that read points or write triangulations.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use septet_core::model::MeshView;
use septet_core::spec::InputRules;
use septet_io::read::{Format, ReadOptions};
use septet_io::write::{MshVersion, OutputError, OutputFormat, PointFormat, WriteOptions, write, write_to};

use super::effects::{excludes, needs};
use super::errors::{Code, Failure};
use super::given::Options;
use super::headings::OUTPUT;
use super::names::{input_format, raw_rows, unknown};

/// Returns the options of the reader for these rules.
pub fn read_options(input: &InputRules) -> Result<ReadOptions, Failure> {
    let usage = |expected: String| Failure::new(Code::Usage, expected);
    let raw = input.raw.as_deref().map(raw_rows).transpose().map_err(usage)?;
    let named = input.format.as_deref().map(input_format).transpose().map_err(usage)?;
    Ok(ReadOptions {
        dimension: input.dimension,
        format: raw.map(Format::Raw).or(named),
        skip_invalid: input.skip_invalid,
        columns: input.columns.clone(),
        keep_columns: input.keep_columns,
    })
}

/// Returns a failure if an option of files is used with a sample, which is not a file, or with another one that disables
/// it.
pub fn check_reading(given: &Options, is_sample: bool) -> Result<(), Failure> {
    for name in ["columns", "input-format"] {
        excludes(&format!("--{name}"), given.has(name), "--raw", given.has("raw"))?;
    }
    let of_files = ["columns", "input-format", "raw", "keep-columns", "skip-invalid"];
    match of_files.into_iter().find(|name| is_sample && given.has(name)) {
        Some(name) => {
            let message = format!("--{name} applies to files, not to a generated sample");
            Err(Failure::new(Code::Usage, message).help(format!("omit --{name}, or give a file")))
        }
        None => Ok(()),
    }
}

/// Options of every command that writes a triangulation.
#[derive(Debug, Args)]
pub struct FormatArgs {
    /// Format of all outputs, regardless of their names; required for `-o -`
    ///
    /// vtu, pvtu, vtk, msh, msh22, mesh, off, stl, npy or ele.
    #[arg(long, value_name = "NAME", value_parser = output_format, help_heading = OUTPUT, hide_short_help = true)]
    format: Option<OutputFormat>,
    /// Version of files named .msh [default: 4.1]
    #[arg(long, value_name = "VERSION", value_enum, help_heading = OUTPUT, hide_short_help = true)]
    msh_version: Option<MshArg>,
}

/// `--msh-version`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MshArg {
    /// Legacy Gmsh files
    #[value(name = "2.2")]
    V22,
    /// Current Gmsh files
    #[value(name = "4.1")]
    V41,
}

impl FormatArgs {
    /// Returns the options of the writers.
    pub fn options(&self) -> WriteOptions<'static> {
        let msh = self.msh_version.map_or_else(MshVersion::default, |version| match version {
            MshArg::V22 => MshVersion::V22,
            MshArg::V41 => MshVersion::V41,
        });
        WriteOptions { format: self.format, msh, ..WriteOptions::default() }
    }

    /// Returns `true` if one of these outputs has one of these formats.
    pub fn any(&self, outputs: &[PathBuf], formats: &[OutputFormat]) -> bool {
        let options = self.options();
        outputs.iter().any(|output| options.format_of(output).is_ok_and(|format| formats.contains(&format)))
    }

    /// Refuses options that no output uses.
    pub fn check(&self, outputs: &[PathBuf]) -> Result<(), Failure> {
        needs("--format", self.format.is_some(), "-o OUT", !outputs.is_empty())?;
        let has_msh = self.any(outputs, &[OutputFormat::Msh(None)]);
        needs("--msh-version", self.msh_version.is_some(), "-o OUT.msh", has_msh)
    }
}

/// Parses the name of an output format for triangulations.
pub fn output_format(name: &str) -> Result<OutputFormat, String> {
    name.parse().map_err(|error| unknown(name, error))
}

/// Parses the name of an output format for point sets.
pub fn point_format(name: &str) -> Result<PointFormat, String> {
    name.parse().map_err(|error| unknown(name, error))
}

/// Writes a triangulation to a file, or to standard output for `-`. Returns the files written.
pub fn write_mesh(
    output: &Path,
    view: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<PathBuf>, OutputError> {
    if output.as_os_str() == "-" {
        write_to(&mut std::io::stdout().lock(), view, options, progress)?;
        return Ok(Vec::new());
    }
    write(output, view, options, progress)
}
