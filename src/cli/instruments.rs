//! What a run writes about itself while it goes on and after: the trace and the tables.

use std::ffi::OsStr;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};

use septet_lab::report::TableFormat;
use septet_lab::trace::{self, Detail};
use tracing_subscriber::layer::Identity;

use super::errors::{Code, Failure};
use super::files::write_text;
use super::options::TraceArgs;
use super::progress::Talk;

/// Where `--profile` goes.
pub enum Tables {
    /// Nowhere.
    None,
    /// Standard error, aligned.
    Print,
    /// Files: path, format, and which table if not all.
    Files(Vec<(PathBuf, TableFormat, Option<usize>)>),
}

/// A report's tables in this format: all of them, or one.
type Render<'a> = &'a dyn Fn(TableFormat, Option<usize>) -> String;

impl Tables {
    /// What the option asks for. A name ending in `.csv` stands for a file of each table, by these names.
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
                let message = format!("{}: tables are written as .md or .csv", path.display());
                Err(Failure::new(Code::Usage, message).help("--profile alone prints them"))
            }
        }
    }

    /// The files.
    pub fn paths(&self) -> Vec<&Path> {
        match self {
            Tables::Files(files) => files.iter().map(|f| f.0.as_path()).collect(),
            _ => Vec::new(),
        }
    }

    /// Writes them, if they go to files; returns those.
    pub fn write(&self, tables: Render<'_>) -> Result<Vec<PathBuf>, Failure> {
        if let Tables::Files(files) = self {
            for (path, format, which) in files {
                write_text(path, &tables(*format, *which))?;
            }
        }
        Ok(self.paths().into_iter().map(Path::to_owned).collect())
    }

    /// Prints them, if that is where they go.
    pub fn print(&self, tables: Render<'_>) {
        if matches!(self, Tables::Print) {
            eprint!("{}", tables(TableFormat::Text, None));
        }
    }
}

/// Refuses a trace that cannot be.
pub fn check_trace(args: &TraceArgs) -> Result<(), Failure> {
    match &args.trace {
        Some(path) if path.as_os_str() == "-" => {
            Err(Failure::new(Code::Usage, "--trace needs the name of a file"))
        }
        Some(_) if !trace::is_compiled_in() => {
            Err(Failure::new(Code::Usage, "this septet was built without tracing (feature `untraced`)"))
        }
        _ => Ok(()),
    }
}

/// Does the work with logging set up, and a trace if one is asked for. However the work ends, the trace
/// is finished: it shows how far the work came. Its name is added to `files`.
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
    let detail = args.trace_level.map_or_else(Detail::default, Detail::from);
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
