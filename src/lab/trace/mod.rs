//! Traces of runs in Chrome's JSON format, which Perfetto (<https://ui.perfetto.dev>) opens.
//!
//! Ranks report their work as spans and events ([`septet_workers::profile`]). The layer reads the clock and writes:
//!
//! - A process for the coordinator and for every worker of a run, in the order of their ranks.
//! - In each process, a track `rounds` with one slice for the work between two exchanges. Its name is the phase,
//!   followed by `: begin` in the first round of the phase and by `: idle` if no message had arrived.
//! - In the process of the coordinator, a track `phases` with the run, its phases and their wall-clock times.
//! - Tracks `steps`, one for each operating system thread that worked for the rank. A slice is a step at a node of
//!   the partition tree (`split`, `draw`, `leaf hulls`, ...).
//! - An arrow for every message, from the slice of the sender to the slice of the receiver.
//! - Counters at the coordinator: bytes in flight, and running steps at nodes of the tree.
//!
//! There is no global state: the caller installs the layer for all threads or for a scope. `tracing` itself has
//! global state, however. While only a scope has a subscriber, an event may be lost if another thread without a
//! subscriber reaches it first. Do not run untraced work at the same time as a traced scope.
//!
//! ```
//! use septet::{simulate, trace};
//! use tracing_subscriber::layer::SubscriberExt;
//!
//! # let directory = tempfile::tempdir()?;
//! # let path = directory.path().join("run.json");
//! let (layer, file) = trace::layer(&path, trace::Detail::default())?;
//! let points: Vec<glam::DVec3> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2]).map(|c| c.map(f64::from).into()).collect();
//! tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), || {
//!     simulate(&points, &Default::default())
//! })?;
//! file.finish()?; // gives the file its name
//! # assert!(std::fs::read_to_string(&path)?.ends_with("]}\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`septet_core::spec::Machine::run`] identifies a run among the runs of one layer. Each run has its own processes
//! in the trace, and so does the planning run of [`septet_core::spec::Workers::Leaves`]. A worker in a separate
//! process is not recorded here, and its messages have no arrows. If that process installs a layer, its trace contains
//! the slices of the worker.
//!
//! Times are microseconds since the creation of the layer, with three decimals, strictly increasing in each thread.
//! Each thread collects its rows in a buffer of 64 KiB. The file grows under a temporary name. When it is finished,
//! it is complete and valid, even after an interrupted run.

mod buffer;
mod event;
mod layer;
mod messages;
mod processes;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use septet_workers::profile::{MESSAGE, PHASE, ROUND, SUBPROBLEM};
use tracing::Subscriber;
use tracing::level_filters::{LevelFilter, STATIC_MAX_LEVEL};
use tracing_subscriber::Layer;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::registry::LookupSpan;

use septet_io::write::OutputError;
use septet_io::write::stage::{Stage, probe, sync};

use buffer::Recorder;

/// The detail of a trace; each level includes the previous ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// The coordinator's phases.
    Phase,
    /// The work of each rank in each round.
    Round,
    /// Messages, and the bytes in flight.
    Message,
    /// Steps at nodes of the partition tree, and the number of concurrent steps.
    #[default]
    Subproblem,
}

septet_core::words!(Detail {
    Phase "phase" "Phases of the coordinator",
    Round "round" "Rounds of each worker",
    Message "message" "Messages and bytes in flight",
    Subproblem "subproblem" "Steps at the nodes of the partition tree",
});

impl Detail {
    fn targets(self) -> Targets {
        let all = [
            (Detail::Phase, PHASE, LevelFilter::INFO),
            (Detail::Round, ROUND, LevelFilter::DEBUG),
            (Detail::Message, MESSAGE, LevelFilter::TRACE),
            (Detail::Subproblem, SUBPROBLEM, LevelFilter::TRACE),
        ];
        Targets::new().with_targets(all.into_iter().filter(|t| t.0 <= self).map(|t| (t.1, t.2)))
    }
}

/// Returns `true` if the program was built with spans and events, that is, without the feature `untraced`.
pub fn is_compiled_in() -> bool {
    STATIC_MAX_LEVEL != LevelFilter::OFF
}

/// Checks that a trace can be written under this name.
///
/// # Errors
/// Returns an [`OutputError`] with the reason if the trace cannot be written.
pub fn check(path: &Path) -> Result<(), OutputError> {
    probe(path)
}

/// A trace that still has a temporary name. If it is dropped without [`TraceFile::finish`], the file is removed.
#[must_use = "the trace has no name before it is finished"]
pub struct TraceFile {
    path: PathBuf,
    stage: Stage,
    recorder: Arc<Recorder>,
}

/// Returns a layer that writes to a file, and the handle that finishes the file.
///
/// # Errors
/// Fails if the file cannot be created next to `path`.
pub fn layer<S>(
    path: &Path,
    detail: Detail,
) -> Result<(impl Layer<S> + Send + Sync + 'static, TraceFile), OutputError>
where
    S: Subscriber + for<'a> LookupSpan<'a>,
{
    let mut stage = Stage::default();
    let file = stage.open(path)?;
    let recorder = Arc::new(Recorder::new(file));
    let layer = layer::ChromeLayer::new(recorder.clone()).with_filter(detail.targets());
    Ok((layer, TraceFile { path: path.to_path_buf(), stage, recorder }))
}

impl TraceFile {
    /// Ends open slices, writes the remaining rows, and gives the file its name. Later events are lost.
    ///
    /// # Errors
    /// Returns the first write error, which may have occurred much earlier, or the error of renaming the file.
    pub fn finish(self) -> Result<PathBuf, OutputError> {
        let io_error = |source| OutputError::Io { path: self.path.clone(), source };
        let file = self.recorder.finish().map_err(io_error)?;
        sync(&file).map_err(io_error)?;
        self.stage.commit()?;
        Ok(self.path)
    }
}
