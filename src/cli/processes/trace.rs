//! The traces of several processes: each process records its ranks in a file of its own.

use std::ffi::OsStr;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};

use septet_lab::trace::{self, Detail};
use tracing_subscriber::layer::Identity;

use super::team::Team;
use crate::errors::Failure;
use crate::instruments::check_trace;
use crate::options::TraceArgs;
use crate::progress::Talk;

/// Sets up logging and the trace of this process, if any, and runs the work. The traces are completed even if the work fails.
///
/// # Errors
/// Fails with the first failure of any process.
pub(super) fn traced(
    args: &TraceArgs,
    team: &mut Team<'_>,
    talk: &Talk,
    work: impl FnOnce(&mut Team<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let Some(path) = &args.trace else {
        talk.log(None::<Identity>);
        return work(team);
    };
    let detail = args.trace_level.map_or_else(Detail::default, Detail::from);
    let own = path_of(path, team.processes.process());
    let begun = check_trace(args).and_then(|()| Ok(trace::layer(&own, detail)?));
    // The processes leave this call at about the same time, at which their clocks start.
    let (layer, file) = team.agree(begun)?;
    talk.log(Some(layer));
    let outcome = catch_unwind(AssertUnwindSafe(|| work(team)));
    let finished = file.finish().map_err(Failure::from);
    outcome.unwrap_or_else(|panic| resume_unwind(panic))?;
    team.agree(finished)?;
    if team.is_first() {
        let last = path_of(path, team.processes.processes() - 1);
        talk.note(format!("wrote {} to {}", own.display(), last.display()));
    }
    Ok(())
}

/// Returns the names of the traces of all processes.
pub(super) fn paths(args: &TraceArgs, processes: u32) -> Vec<PathBuf> {
    args.trace.iter().flat_map(|path| (0..processes).map(|process| path_of(path, process))).collect()
}

/// Returns the name of the trace of a process: `run.json` becomes `run.3.json`.
fn path_of(path: &Path, process: u32) -> PathBuf {
    let extension = path.extension().and_then(OsStr::to_str).unwrap_or("json");
    path.with_extension(format!("{process}.{extension}"))
}
