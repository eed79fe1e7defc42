//! Options for file formats, shared by the commands that read points or write triangulations.

use std::path::{Path, PathBuf};

use clap::Args;
use septet_core::Spec;
use septet_core::model::MeshView;
use septet_core::spec::InputRules;
use septet_io::read::ReadOptions;
use septet_io::write::{MshVersion, OutputError, WriteOptions, write, write_to};
use septet_io::{Files, Format, Role, Row};

use super::effects::{excludes, needs};
use super::errors::{Code, Failure};
use super::given::{Options, words};
use super::headings::OUTPUT;
use super::names::{names, of_role, raw_rows};

/// Returns the options of the reader for these rules.
pub fn read_options(input: &InputRules) -> Result<ReadOptions, Failure> {
    let usage = |expected: String| Failure::new(Code::Usage, expected);
    if input.terrain && input.dimension == Some(3) {
        let message = "--terrain contradicts -d 3: a terrain is triangulated in the plane".to_owned();
        return Err(usage(message).help("omit -d 3, or omit --terrain to triangulate in space"));
    }
    let raw = input.raw.as_deref().map(raw_rows).transpose().map_err(usage)?;
    let of_points = of_role(Role::Points);
    let format = input.format.as_deref().map(of_points).transpose().map_err(usage)?;
    Ok(ReadOptions {
        dimension: input.dimension,
        format,
        raw,
        skip_invalid: input.skip_invalid,
        columns: input.columns.clone(),
        keep_columns: input.keep_columns,
        terrain: input.terrain,
        weights: None,
    })
}

/// Returns a failure if an option of files is used with a sample, which is not a file, or with another one that disables
/// it.
pub fn check_reading(given: &Options<Spec>, is_sample: bool) -> Result<(), Failure> {
    for name in ["columns", "input-format"] {
        excludes(&format!("--{name}"), given.has(name), "--raw", given.has("raw"))?;
    }
    let of_files = ["columns", "input-format", "raw", "keep-columns", "terrain", "skip-invalid"];
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
    #[arg(long, value_name = "NAME", value_parser = of_role(Role::Triangulation), help = "Format of all outputs, regardless of their names; required for `-o -`", long_help = output_format_help(), help_heading = OUTPUT, hide_short_help = true)]
    format: Option<Format>,
    /// Version of files named .msh [default: 4.1]
    #[arg(long, value_name = "VERSION", value_parser = words::<MshVersion>(), help_heading = OUTPUT, hide_short_help = true)]
    msh_version: Option<MshVersion>,
}

impl FormatArgs {
    /// Returns the options of the writers.
    pub fn options(&self) -> WriteOptions<'static> {
        let msh = self.msh_version.unwrap_or_default();
        WriteOptions { format: self.format, msh, ..WriteOptions::default() }
    }

    /// Returns `true` if the format of one of these outputs fulfils a condition.
    pub fn any(&self, outputs: &[PathBuf], holds: impl Fn(Format) -> bool) -> bool {
        let options = self.options();
        outputs.iter().any(|output| options.format_of(output).is_ok_and(&holds))
    }

    /// Refuses options that no output uses.
    pub fn check(&self, outputs: &[PathBuf]) -> Result<(), Failure> {
        needs("--format", self.format.is_some(), "-o OUT", !outputs.is_empty())?;
        let has_msh = self.any(outputs, |format| format == Format::Msh);
        needs("--msh-version", self.msh_version.is_some(), "-o OUT.msh", has_msh)
    }
}

/// Returns the help of an option for files of a use: a first line, and the extensions with a remark on compression.
pub fn listed(first: &str, role: Role) -> String {
    format!("{first}\n\nFormats: {}.", role.known())
}

fn output_format_help() -> String {
    let first = "Format of all outputs, regardless of their names; required for `-o -`";
    format!("{first}\n\n{}.", names(Role::Triangulation))
}

/// Returns the help of the input of a run.
pub fn input_help() -> String {
    let ambiguous: Vec<String> = Format::ALL
        .iter()
        .flat_map(|format| format.row().ambiguous)
        .map(|extension| format!(".{extension}"))
        .collect();
    format!(
        "Point file, `-` for standard input, or `sample:KIND:N` for a generated set\n\n\
         Files: {}. Tables of text may also end in {}. --raw reads coordinates in binary. A pattern in quotes, such as \
         'part-*.npy', reads several files in byte order of their names. @LIST reads the files that the text file LIST \
         names, one per line. Rows are numbered across the files. The full form of a sample is \
         `sample:KIND:N[,d=2][,seed=7][,lipschitz=0.25][,ratio=1.3]`.",
        Role::Points.known(),
        ambiguous.join(" ")
    )
}

/// Returns the help of the outputs of a run.
pub fn outputs_help() -> String {
    let pieces = Role::Triangulation.extensions(|row| row.files == Files::Pieces);
    format!(
        "Write the triangulation; may be given several times\n\n\
         {} `-` is standard output. NAME{pieces} writes a piece for each worker into the folder NAME.pieces, which it replaces.",
        of_files(Role::Triangulation)
    )
}

/// Returns the help of the outputs of a mesh.
pub fn mesh_outputs_help() -> String {
    let first = "Write the mesh or its surface; may be given several times";
    format!("{first}\n\n{} `-` is standard output.", of_files(Role::Mesh))
}

/// Describes the outputs of a use: whole meshes, surfaces and sets.
fn of_files(role: Role) -> String {
    let of = |holds: fn(&Row) -> bool| role.extensions(holds);
    let unpacked = of(|row| !row.is_packable);
    let packed = if unpacked.is_empty() {
        "Each also .gz.".to_owned()
    } else {
        format!("Each but {unpacked} also .gz.")
    };
    format!(
        "Formats: {}. Surface in space: {}. A picture of the plane: {}. Any of {} writes all five files. {packed}",
        of(|row| row.files != Files::Set && !row.is_surface && !row.is_plane),
        of(|row| row.is_surface),
        of(|row| row.is_plane),
        of(|row| row.files == Files::Set),
    )
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
