//! Work on a thread of its own, so that its caller can stop to wait for it.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::Duration;

/// The time between two looks at the caller's wish.
const PAUSE: Duration = Duration::from_millis(50);

/// The stack of the thread, as large as that of the first thread of a program.
const STACK: usize = 8 << 20;

/// Runs `work` on a thread of its own, and calls `is_stopped` until it ends. Returns the result of the work, or `None` as soon as
/// `is_stopped` returns `true`. The thread then continues alone, and its result is dropped.
///
/// A reader can stay for a long time in one step: a pipe may be silent, and a small compressed file may be a large text.
///
/// # Errors
/// Fails if the system does not start a thread.
///
/// # Panics
/// Panics if the work does.
pub fn apart<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
    is_stopped: &mut dyn FnMut() -> bool,
) -> std::io::Result<Option<T>> {
    let (to, from) = channel();
    let thread = Builder::new().name("septet-read".to_string()).stack_size(STACK).spawn(move || {
        // The receiver is gone if the work was stopped.
        let _ = to.send(work());
    })?;
    loop {
        match from.recv_timeout(PAUSE) {
            Ok(done) => return Ok(Some(done)),
            Err(RecvTimeoutError::Timeout) if is_stopped() => return Ok(None),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return thread.join().map_or_else(|payload| resume_unwind(payload), |()| Ok(None));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn work_ends_or_is_left() {
        assert_eq!(apart(|| 7, &mut || false).unwrap(), Some(7));
        let (_kept, silent) = channel::<u8>();
        let mut looks = 0;
        let is_stopped = &mut || {
            looks += 1;
            looks == 3
        };
        assert_eq!(apart(move || silent.recv().is_ok(), is_stopped).unwrap(), None);
    }

    #[test]
    #[should_panic(expected = "a reader panicked")]
    fn panics_reach_the_caller() {
        let _ = apart(|| panic!("a reader panicked"), &mut || false);
    }
}
