//! The number of *exact tests*: orientations and in-sphere signs that the filter did not decide.
//!
//! **Statement.** Each such call is one exact test, whichever exact stage decides it: rounded arithmetic without any
//! rounding error, integers, or expansions. Ties count once, because the stage that finds the zero also breaks the tie.
//!
//! **Why.** An exact test takes about ten times as long as a rounded one, and the ledger charges both as one operation. The
//! count says how far that constant matters.
//!
//! The predicates have no meter. They count on their thread, and the owner of a meter charges the tests of a computation
//! between two readings ([`ExactTests::so_far`], [`ExactTests::since`]). The computation must run on one thread. The filter
//! alone decides most calls, and these do not touch the counter.

use std::cell::Cell;
use std::ops::AddAssign;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// Counts one exact test.
#[inline]
pub(super) fn exact_test() {
    COUNT.with(|count| count.set(count.get() + 1));
}

/// A number of exact tests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct ExactTests(u64);

impl ExactTests {
    /// Returns the tests of this thread so far.
    #[inline]
    pub fn so_far() -> Self {
        ExactTests(COUNT.with(Cell::get))
    }

    /// Returns the tests of this thread since the reading `self`.
    #[inline]
    #[must_use]
    pub fn since(self) -> Self {
        ExactTests(ExactTests::so_far().0.wrapping_sub(self.0))
    }

    /// Returns the number.
    pub fn count(self) -> u64 {
        self.0
    }
}

impl AddAssign for ExactTests {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}
