//! Options for file formats, shared by the commands that read points or write triangulations.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use septet_core::model::MeshView;
use septet_io::read::{Format, RawRows, ReadOptions, UnknownFormatName, UnknownRawRows};
use septet_io::write::{MshVersion, OutputError, OutputFormat, PointFormat, WriteOptions, write, write_to};

use super::effects::{excludes, needs};
use super::errors::{Code, Failure};
use super::headings::{INPUT, OUTPUT};
use super::text::suggestion;

/// Options of every command that reads points.
#[derive(Debug, Args)]
pub struct ReadArgs {
    /// Columns of the coordinates in a text table
    ///
    /// Names from the header row, or 1-based numbers. By default, columns named x, y and z are used. A table without a
    /// header row may have two or three columns; one with more columns needs this option or the dimension.
    #[arg(long, value_name = "X,Y[,Z]", value_delimiter = ',', help_heading = INPUT)]
    columns: Option<Vec<String>>,
    /// Format of the points, for standard input and unknown extensions
    ///
    /// node, xyz, csv, npy, off, ply, stl, obj, vtu, vtk, msh or mesh.
    #[arg(long, value_name = "NAME", value_parser = input_format, help_heading = INPUT, hide_short_help = true)]
    input_format: Option<Format>,
    /// Read coordinates in binary without a header, such as f64,3
    ///
    /// The type of the coordinates (f32 or f64, or f32be or f64be for big-endian numbers) and the number of coordinates of
    /// a point (2 or 3). The names of the files may be any but those of other formats.
    #[arg(long, value_name = "TYPE,D", value_parser = raw_rows, help_heading = INPUT, hide_short_help = true)]
    raw: Option<RawRows>,
}

impl ReadArgs {
    /// Returns the options of the reader.
    pub fn options(&self, dimension: Option<usize>, skip_invalid: bool) -> ReadOptions {
        ReadOptions {
            dimension,
            format: self.raw.map(Format::Raw).or(self.input_format),
            skip_invalid,
            columns: self.columns.clone(),
            keep_columns: false,
        }
    }

    /// Returns the option that `septet verify` needs to read the same points, after a space.
    pub fn for_verify(&self) -> String {
        self.raw.map_or_else(String::new, |rows| format!(" --raw {rows}"))
    }

    /// Returns a failure if one of these options is used with a sample, which is not a file, or with another one that
    /// disables it. `others` lists further options, and whether each is set.
    pub fn check(&self, is_sample: bool, others: &[(&str, bool)]) -> Result<(), Failure> {
        let formats =
            [("--columns", self.columns.is_some()), ("--input-format", self.input_format.is_some())];
        for (option, given) in formats {
            excludes(option, given, "--raw", self.raw.is_some())?;
        }
        let own = formats.into_iter().chain([("--raw", self.raw.is_some())]);
        match own.chain(others.iter().copied()).find(|(_, given)| is_sample && *given) {
            Some((option, _)) => {
                let message = format!("{option} applies to files, not to a generated sample");
                Err(Failure::new(Code::Usage, message).help(format!("omit {option}, or give a file")))
            }
            None => Ok(()),
        }
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

fn unknown(name: &str, error: UnknownFormatName) -> String {
    format!("{}{error}", suggestion(&name.to_ascii_lowercase(), error.known.split(' ')))
}

fn raw_rows(text: &str) -> Result<RawRows, String> {
    text.parse().map_err(|error: UnknownRawRows| error.to_string())
}

fn input_format(name: &str) -> Result<Format, String> {
    let parsed = name.parse().map_err(|error| unknown(name, error))?;
    if parsed == Format::Ele { Err("ele is a format of cells, not of points".to_owned()) } else { Ok(parsed) }
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
