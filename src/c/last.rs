//! The status of a call, and the last failure of a thread.

use std::cell::RefCell;
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;
use std::sync::atomic::{AtomicUsize, Ordering};

use septet_doors::{Door, Failure};

/// The status of a call without a failure.
pub(crate) const OK: i32 = 0;

thread_local! {
    static LAST: RefCell<(CString, i64)> = RefCell::new((CString::default(), -1));
}

/// Number of calls that are running.
static RUNNING: AtomicUsize = AtomicUsize::new(0);

/// A running call, during which a panic prints nothing.
struct Running;

impl Running {
    fn start() -> Self {
        static ONCE: Once = Once::new();
        ONCE.call_once(|| {
            let previous = take_hook();
            set_hook(Box::new(move |panic| {
                if RUNNING.load(Ordering::Relaxed) == 0 {
                    previous(panic);
                }
            }));
        });
        RUNNING.fetch_add(1, Ordering::Relaxed);
        Running
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        RUNNING.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Calls `f` with the text and the row of the last failure of this thread.
pub(crate) fn last<T>(f: impl FnOnce(&CString, i64) -> T) -> T {
    LAST.with_borrow(|(text, index)| f(text, *index))
}

/// Returns the value of a call that cannot fail, or `missing` if it panics.
pub(crate) fn value<T>(missing: T, call: impl FnOnce() -> T) -> T {
    let _running = Running::start();
    catch_unwind(AssertUnwindSafe(call)).unwrap_or(missing)
}

/// Runs a call. Records its failure, which may be a panic, and returns its status.
pub(crate) fn status(call: impl FnOnce() -> Result<(), Failure>) -> i32 {
    let _running = Running::start();
    let failure = match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => return OK,
        Ok(Err(failure)) => failure,
        Err(_) => Failure::panicked(Door::C),
    };
    let index = failure.index.and_then(|index| i64::try_from(index).ok()).unwrap_or(-1);
    LAST.set((CString::new(failure.message.replace('\0', " ")).unwrap_or_default(), index));
    failure.code as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_status() {
        assert_eq!(status(|| panic!("planted")), 1);
        assert!(last(|text, index| text.to_str().unwrap().contains("report") && index == -1));
        assert_eq!(value(7, || panic!("planted")), 7);
        assert_eq!(value(7, || 8), 8);
    }

    #[test]
    fn failures_belong_to_their_thread() {
        assert_eq!(status(|| Err(Failure::usage("bad\0text").at(5))), 2);
        assert!(last(|text, index| text.to_str() == Ok("bad text") && index == 5));
        let other = std::thread::spawn(|| last(|text, index| (text.clone(), index)));
        assert_eq!(other.join().unwrap(), (CString::default(), -1));
        assert_eq!(status(|| Ok(())), OK);
    }
}
