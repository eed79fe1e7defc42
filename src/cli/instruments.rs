//! The trace and the tables of a run.

use std::ffi::OsStr;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};

use septet_lab::report::TableFormat;
use septet_lab::trace;
use tracing_subscriber::layer::Identity;

use super::errors::{Code, Failure};
use super::files::write_text;
use super::options::TraceArgs;
use super::progress::Talk;

/// The destination of `--profile`.
pub enum Tables {
    /// No tables.
    None,
    /// Aligned tables on standard error.
    Print,
    /// Files, each with its path, its format, and the number of its table, or `None` for all tables.
    Files(Vec<(PathBuf, TableFormat, Option<usize>)>),
}

/// Formats all tables of a report, or one of them.
type Render<'a> = &'a dyn Fn(TableFormat, Option<usize>) -> String;

impl Tables {
    /// Returns the destination for the value of `--profile`. If the name ends in `.csv`, each table gets a file.
    pub fn of(profile: Option<&Path>, names: &[&str]) -> Result<Self, Failure> {
        let Some(path) = profile else { return Ok(Tables::None) };
        let extension = path.extension().and_then(OsStr::to_str).map(str::to_lowercase);
        match extension.as_deref() {
            _ if path.as_os_str() == "-" => Ok(Tables::Print),
            Some("md") => Ok(Tables::Files(vec![(path.to_owned(), TableFormat::Markdown, None)])),
            Some("csv") => {
                let of = |(i, name): (usize, &&str)| {
                    (path.with_extension(format!("{name}.csv")), TableFormat::Csv, Some(i))
                };
                Ok(Tables::Files(names.iter().enumerate().map(of).collect()))
            }
            _ => {
                let message = format!("{}: unknown table format; .md and .csv are supported", path.display());
                Err(Failure::new(Code::Usage, message)
                    .help("end the name in .md or .csv, or omit it to print the tables"))
            }
        }
    }

    /// Returns the paths of the files.
    pub fn paths(&self) -> Vec<&Path> {
        match self {
            Tables::Files(files) => files.iter().map(|f| f.0.as_path()).collect(),
            _ => Vec::new(),
        }
    }

    /// Writes the tables to their files, if there are any, and returns the paths.
    pub fn write(&self, tables: Render<'_>) -> Result<Vec<PathBuf>, Failure> {
        if let Tables::Files(files) = self {
            for (path, format, which) in files {
                write_text(path, &tables(*format, *which))?;
            }
        }
        Ok(self.paths().into_iter().map(Path::to_owned).collect())
    }

    /// Prints the tables if their destination is standard error.
    pub fn print(&self, tables: Render<'_>) {
        if matches!(self, Tables::Print) {
            // Nothing can be reported if standard error is closed.
            let _ = write!(std::io::stderr(), "{}", tables(TableFormat::Text, None));
        }
    }
}

/// Checks the options of the trace.
pub fn check_trace(args: &TraceArgs) -> Result<(), Failure> {
    match &args.trace {
        Some(path) if path.as_os_str() == "-" => {
            Err(Failure::new(Code::Usage, "--trace cannot write to standard output").help("give a file name"))
        }
        Some(_) if !trace::is_compiled_in() => {
            Err(Failure::new(Code::Usage, "this program was built without tracing (feature `untraced`)"))
        }
        _ => Ok(()),
    }
}

/// Sets up logging and the trace, if any, and runs the work. The trace is completed even if the work fails or panics.
/// Its path is appended to `files`.
pub fn traced<T>(
    args: &TraceArgs,
    talk: &Talk,
    files: &mut Vec<PathBuf>,
    work: impl FnOnce() -> Result<T, Failure>,
) -> Result<T, Failure> {
    let Some(path) = &args.trace else {
        talk.log(None::<Identity>);
        return work();
    };
    let detail = args.trace_level.unwrap_or_default();
    let (layer, file) = trace::layer(path, detail)?;
    talk.log(Some(layer));
    let outcome = catch_unwind(AssertUnwindSafe(work));
    let finished = file.finish();
    if let (Ok(path), Ok(Err(_)) | Err(_)) = (&finished, &outcome) {
        talk.note(format!("wrote {}", path.display()));
    }
    let done = outcome.unwrap_or_else(|panic| resume_unwind(panic))?;
    files.push(finished?);
    Ok(done)
}
