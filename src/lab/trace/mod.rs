//! A run as a trace: Chrome's JSON, which Perfetto (<https://ui.perfetto.dev>) opens.
//!
//! Workers tell what they do ([`septet_workers::profile`]); the layer made here reads the clock and writes:
//!
//! - a process for the coordinator and for every worker of a run, in the order of their ranks;
//! - in each a track `rounds`, one slice for what the rank does between two exchanges: named by the phase, with
//!   `: begin` where the phase begins and `: idle` where no message had come;
//! - in the coordinator's a track `phases`, with the run, its phases and their wall-clock times;
//! - tracks `steps`, one for each thread of the system that worked for the rank: a slice for each step at a node
//!   of the partition tree (`split`, `draw`, `leaf hulls`, ...);
//! - an arrow for every message, from the sender's slice to the receiver's;
//! - counters of the bytes and messages in flight and of the nodes of the tree being worked at, at the coordinator.
//!
//! There are no globals: the layer is the caller's to install, for all threads or for a scope. (`tracing` itself keeps
//! one: while the only subscriber is a scope's, an event that another thread passes first, without one, may stay
//! unheard. Do not run untraced work beside a scope that traces.)
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
//! file.finish()?; // only now it has its name
//! # assert!(std::fs::read_to_string(&path)?.ends_with("]}\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Runs of one layer are told apart by [`septet_core::Config::run`]: each has its own processes, and so has the planning run
//! of [`septet_core::config::Workers::Leaves`]. A worker that is a process of its own is heard only there: what it sends
//! has no arrow, and its slices are in the trace of that process if it installs a layer.
//!
//! Times are microseconds from the making of the layer, with three decimals, strictly increasing in each
//! thread. Each thread gathers what it says in a buffer of 64 KiB; the file grows under a
//! temporary name, and is whole and valid whenever it is finished, also after an interrupted run.

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

/// How much a trace tells; each detail includes those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// The coordinator's phases.
    Phase,
    /// What each rank does in each round.
    Round,
    /// Messages, and the bytes in flight.
    Message,
    /// Steps at nodes of the partition tree, and how many go on at once.
    #[default]
    Subproblem,
}

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

/// Was the program built to say anything at all? Not with feature `untraced`.
pub fn is_compiled_in() -> bool {
    STATIC_MAX_LEVEL != LevelFilter::OFF
}

/// Can a trace be written under this name?
///
/// # Errors
/// An [`OutputError`] that tells what stands in the way.
pub fn check(path: &Path) -> Result<(), OutputError> {
    probe(path)
}

/// A trace on its way to its name. Dropped without [`TraceFile::finish`], it vanishes.
#[must_use = "the trace has no name before it is finished"]
pub struct TraceFile {
    path: PathBuf,
    stage: Stage,
    recorder: Arc<Recorder>,
}

/// A layer that writes what is told to a file, and the handle that finishes it.
///
/// # Errors
/// If no file can be made beside `path`.
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
    /// Closes what is open, writes the last of it, and gives the file its name. What is told later is lost.
    ///
    /// # Errors
    /// The first failure to write, which may be of long before, or to rename.
    pub fn finish(self) -> Result<PathBuf, OutputError> {
        let io_error = |source| OutputError::Io { path: self.path.clone(), source };
        let file = self.recorder.finish().map_err(io_error)?;
        sync(&file).map_err(io_error)?;
        self.stage.commit()?;
        Ok(self.path)
    }
}
