//! Calls without the interpreter that hear signals and report progress.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use septet_core::Door;
use septet_core::spec::{Progress, ProgressFn};
use septet_doors::{Call, Failure};

use crate::errors;

/// Below this number of items a call takes milliseconds, also if a point has as many neighbours, and is not watched.
pub const UNWATCHED: usize = 256;

/// Below this number of items, a query is answered on one thread.
pub const FEW: usize = 20_000;

/// The time between two looks at signals.
const LOOK: Duration = Duration::from_millis(20);

/// The least time between two calls of a progress callback.
const REPORT: Duration = Duration::from_millis(100);

/// A stage, its position, and the number of stages.
type Stage = (String, u64, u64);

/// A call that can be cancelled and that reports progress.
#[derive(Clone)]
pub struct Watch {
    flag: Arc<AtomicBool>,
    latest: Arc<Mutex<Option<Stage>>>,
    callback: Option<Arc<Py<PyAny>>>,
}

impl Watch {
    /// Creates the watch of a call with a callback for progress.
    pub fn new(callback: Option<Py<PyAny>>) -> Self {
        Watch { flag: Arc::default(), latest: Arc::default(), callback: callback.map(Arc::new) }
    }

    /// Returns the call of the library on a number of threads.
    pub fn call(&self, threads: Option<usize>) -> Call {
        Call { door: Door::Python, threads, cancel: Some(self.flag.clone()) }
    }

    /// Returns the flag that cancels the call.
    pub fn flag(&self) -> Arc<AtomicBool> {
        self.flag.clone()
    }

    /// Whether the call is cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }

    /// Ends a call without cancellation points, from within its progress callback, if it is cancelled. Unwinding removes partial files.
    pub fn unwind_if_cancelled(&self) {
        if self.is_cancelled() {
            resume_unwind(Box::new("cancelled"));
        }
    }

    /// Stores a stage, which the loop that waits reports.
    pub fn note(&self, name: &str, position: u64, of: u64) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some((name.to_owned(), position, of));
    }

    /// Returns the callback for runs, if progress is requested.
    pub fn progress(&self) -> Option<ProgressFn> {
        self.callback.as_ref()?;
        let watch = Watch { callback: None, ..self.clone() };
        Some(Arc::new(move |progress: Progress| {
            let (position, of) = progress.position;
            watch.note(progress.phase, position as u64, of as u64);
        }))
    }

    /// Runs `work` without the interpreter. A call of more than [`UNWATCHED`] items, or with a callback, runs on a thread of its
    /// own; an exception of a signal handler or of the callback cancels it and is raised when it has ended.
    ///
    /// # Errors
    /// Returns the exception of the failure, of the signal handler or of the callback.
    pub fn run<T: Send>(
        &self,
        py: Python<'_>,
        size: usize,
        work: impl FnOnce() -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let result = if size < UNWATCHED && self.callback.is_none() {
            py.detach(|| catch_unwind(AssertUnwindSafe(work)))
        } else {
            let (result, raised) = self.waited(py, work);
            if let Some(error) = raised {
                return Err(error);
            }
            result
        };
        match result {
            Ok(result) => result.map_err(|failure| errors::raise(py, &failure)),
            Err(_) => Err(errors::raise(py, &Failure::panicked(Door::Python))),
        }
    }

    /// Runs `work` on a thread, and looks at signals and progress meanwhile.
    fn waited<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce() -> T + Send,
    ) -> (std::thread::Result<T>, Option<PyErr>) {
        let (sender, mut receiver) = channel();
        let mut raised = None;
        let result = std::thread::scope(|scope| {
            let worker = scope.spawn(move || {
                // The receiver hears the end also if `work` panics, because the sender is dropped.
                let _sender: std::sync::mpsc::Sender<()> = sender;
                work()
            });
            let mut last = None;
            loop {
                let (back, outcome) = py.detach(move || {
                    let outcome = receiver.recv_timeout(LOOK);
                    (receiver, outcome)
                });
                receiver = back;
                let is_over = !matches!(outcome, Err(RecvTimeoutError::Timeout));
                if raised.is_none() {
                    raised = self.look(py, &mut last, is_over).err();
                }
                if raised.is_some() {
                    self.flag.store(true, Ordering::Relaxed);
                }
                if is_over {
                    break;
                }
            }
            py.detach(|| worker.join())
        });
        (result, raised)
    }

    /// Runs signal handlers, and calls the callback with the latest stage.
    fn look(&self, py: Python<'_>, last: &mut Option<Instant>, is_over: bool) -> PyResult<()> {
        py.check_signals()?;
        let Some(callback) = &self.callback else { return Ok(()) };
        if !is_over && last.is_some_and(|last| last.elapsed() < REPORT) {
            return Ok(());
        }
        let stage = self.latest.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(stage) = stage {
            *last = Some(Instant::now());
            callback.call1(py, stage)?;
        }
        Ok(())
    }
}
