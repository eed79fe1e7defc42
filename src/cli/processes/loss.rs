//! The loss of a process of a run: the others stop what they compute, and do not wait for the next exchange.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use septet_io::write::stage::remove_waiting;
use septet_workers::transport::socket::OnEnd;

use crate::errors::{Code, Failure};

/// The time to stop cleanly after the loss of a process. A step that does not look at the request to stop can take longer.
const PATIENCE: Duration = Duration::from_secs(4);

/// The state of the run of this process.
#[derive(Default)]
pub struct Loss {
    /// Whether a connection ended during the run, before anything else stopped it.
    is_first: AtomicBool,
    /// Whether the run of this process is over.
    is_over: AtomicBool,
}

impl Loss {
    /// Returns the function that a connection calls when it ends. It raises the request to stop.
    pub fn hook(self: &Arc<Self>, cancel: &Arc<AtomicBool>) -> OnEnd {
        let (loss, cancel) = (self.clone(), cancel.clone());
        Arc::new(move || loss.connection_ended(&cancel))
    }

    fn connection_ended(self: &Arc<Self>, cancel: &AtomicBool) {
        // After an interrupt, the processes end together.
        if self.is_over.load(Ordering::SeqCst) || cancel.swap(true, Ordering::SeqCst) {
            return;
        }
        self.is_first.store(true, Ordering::SeqCst);
        let loss = self.clone();
        let watch = move || {
            thread::sleep(PATIENCE);
            if !loss.is_over.load(Ordering::SeqCst) {
                exit("this one did not stop in time");
            }
        };
        if thread::Builder::new().spawn(watch).is_err() {
            exit("this one cannot start a thread that waits for its end");
        }
    }

    /// Ends the run of this process. Returns its result. A run that stopped because of a lost process was not interrupted.
    pub fn ended(&self, result: Result<(), Failure>) -> Result<(), Failure> {
        self.is_over.store(true, Ordering::SeqCst);
        match result {
            Err(failure) if failure.code == Code::Interrupted && self.is_first.load(Ordering::SeqCst) => {
                let message = "a process of the run ended";
                Err(Failure::new(Code::Machine, message)
                    .help("see whether the system ended that process, for example because memory ran out"))
            }
            other => other,
        }
    }
}

/// Ends this process at once, without temporary files.
fn exit(reason: &str) -> ! {
    let _ = writeln!(std::io::stderr(), "error: a process of the run ended, and {reason}");
    remove_waiting();
    std::process::exit(Code::Machine as i32);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loss_stops_the_run_and_is_no_interrupt() {
        let interrupted = || Err(Failure::interrupted());
        let code = |result: Result<(), Failure>| result.unwrap_err().code;
        let (loss, cancel) = (Arc::<Loss>::default(), Arc::<AtomicBool>::default());
        loss.hook(&cancel)();
        assert!(cancel.load(Ordering::SeqCst));
        assert_eq!(code(loss.ended(interrupted())), Code::Machine);
        // The user came first.
        let (loss, cancel) = (Arc::<Loss>::default(), Arc::new(AtomicBool::new(true)));
        loss.hook(&cancel)();
        assert_eq!(code(loss.ended(interrupted())), Code::Interrupted);
        // The run is over.
        let (loss, cancel) = (Arc::<Loss>::default(), Arc::<AtomicBool>::default());
        assert!(loss.ended(Ok(())).is_ok());
        loss.hook(&cancel)();
        assert!(!cancel.load(Ordering::SeqCst));
    }
}
