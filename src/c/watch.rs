//! The flag of a caller that ends a call.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::thread;
use std::time::Duration;

use septet_doors::{Code, Failure};

/// The time between two looks at the flag.
const WAIT: Duration = Duration::from_millis(10);

/// Runs `call`. While it runs, another thread looks at `cancel`, and sets the flag of the call if it is not 0.
///
/// # Errors
/// Fails as `call` does, and if no thread can be started.
pub(crate) fn watched<T>(
    cancel: Option<&AtomicI32>,
    call: impl FnOnce(Option<Arc<AtomicBool>>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let Some(cancel) = cancel else { return call(None) };
    let flag = Arc::new(AtomicBool::new(cancel.load(Ordering::Acquire) != 0));
    let is_done = AtomicBool::new(false);
    thread::scope(|scope| {
        let look = || {
            while !is_done.load(Ordering::Acquire) && !flag.load(Ordering::Relaxed) {
                thread::park_timeout(WAIT);
                if cancel.load(Ordering::Acquire) != 0 {
                    flag.store(true, Ordering::Relaxed);
                }
            }
        };
        let watcher = thread::Builder::new().name("septet-cancel".to_owned()).spawn_scoped(scope, look);
        let watcher = watcher.map_err(|error| {
            Failure::new(Code::Machine, format!("cannot start a thread for cancel: {error}"))
        })?;
        // The watcher ends even if the call panics.
        let _done = Done { is_done: &is_done, watcher: watcher.thread().clone() };
        call(Some(flag.clone()))
    })
}

/// Ends the watcher when the call has ended.
struct Done<'a> {
    is_done: &'a AtomicBool,
    watcher: thread::Thread,
}

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.is_done.store(true, Ordering::Release);
        self.watcher.unpark();
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    #[test]
    fn a_flag_ends_a_call() {
        let cancel = AtomicI32::new(0);
        let start = Instant::now();
        let ended = watched(Some(&cancel), |flag| {
            let flag = flag.unwrap();
            assert!(!flag.load(Ordering::Relaxed));
            cancel.store(-1, Ordering::Release);
            while !flag.load(Ordering::Relaxed) && start.elapsed().as_secs() < 20 {
                thread::yield_now();
            }
            Ok(flag.load(Ordering::Relaxed))
        });
        assert_eq!(ended, Ok(true));
        assert_eq!(watched(None, |flag| Ok(flag.is_none())), Ok(true));
    }
}
