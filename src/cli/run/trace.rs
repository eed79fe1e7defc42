//! The trace of a run. Several processes record their ranks in a file each.

use std::ffi::OsStr;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};

use septet_lab::trace;
use tracing_subscriber::layer::Identity;

use super::team::Team;
use crate::errors::Failure;
use crate::instruments;
use crate::options::TraceArgs;
use crate::progress::Talk;

/// Sets up logging and the trace of this process, if any, and runs the work. The trace is completed even if the work fails. The
/// trace of a process alone is appended to `files`.
///
/// # Errors
/// Fails with the first failure of any process.
pub(super) fn traced<T>(
    args: &TraceArgs,
    team: &mut Team<'_>,
    talk: &Talk,
    files: &mut Vec<PathBuf>,
    work: impl FnOnce(&mut Team<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    if team.is_alone() {
        return instruments::traced(args, talk, files, || work(team));
    }
    let Some(path) = &args.trace else {
        talk.log(None::<Identity>);
        return work(team);
    };
    let detail = args.trace_level.unwrap_or_default();
    let own = path_of(path, team.processes.process());
    let begun = trace::layer(&own, detail).map_err(Failure::from);
    // The processes leave this call at about the same time, at which their clocks start.
    let (layer, file) = team.agree(begun)?;
    talk.log(Some(layer));
    let outcome = catch_unwind(AssertUnwindSafe(|| work(team)));
    let finished = file.finish().map_err(Failure::from);
    let done = outcome.unwrap_or_else(|panic| resume_unwind(panic))?;
    team.agree(finished)?;
    if team.is_first() {
        let last = path_of(path, team.processes.processes() - 1);
        talk.note(format!("wrote {} to {}", own.display(), last.display()));
    }
    Ok(done)
}

/// Returns the names of the traces of all processes.
pub(super) fn paths(args: &TraceArgs, team: &Team<'_>) -> Vec<PathBuf> {
    let of_team = |path: &PathBuf| {
        let numbers = 0..team.processes.processes();
        if team.is_alone() { vec![path.clone()] } else { numbers.map(|n| path_of(path, n)).collect() }
    };
    args.trace.iter().flat_map(of_team).collect()
}

/// Returns the name of the trace of a process: `run.json` becomes `run.3.json`.
fn path_of(path: &Path, process: u32) -> PathBuf {
    let extension = path.extension().and_then(OsStr::to_str).unwrap_or("json");
    path.with_extension(format!("{process}.{extension}"))
}
