//! Counts of predicate calls by the stage that decides them, for experiments with the feature `stage-counts`.
//!
//! The counters are local to the thread and affect no result. Without the feature they do not exist.

/// The stage that decided a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Rounded arithmetic within its error bound.
    Filter,
    /// Rounded arithmetic without any rounding error.
    Exact,
    /// Integers of fixed width.
    Integer,
    /// Expansions.
    Expansion,
}

/// Counts one orientation decided at `stage`.
#[inline]
pub(super) fn orientation(stage: Stage) {
    count(stage, 0);
}

/// Counts one in-sphere sign decided at `stage`.
#[inline]
pub(super) fn in_sphere(stage: Stage) {
    count(stage, 4);
}

/// Counts one in-sphere sign that was zero.
#[inline]
pub(super) fn tie() {
    #[cfg(feature = "stage-counts")]
    counters::add(8);
}

#[cfg_attr(not(feature = "stage-counts"), expect(unused_variables, reason = "nothing is counted"))]
#[inline]
fn count(stage: Stage, first: usize) {
    #[cfg(feature = "stage-counts")]
    counters::add(first + stage as usize);
}

#[cfg(feature = "stage-counts")]
mod counters {
    use std::cell::Cell;

    thread_local! {
        static COUNTS: [Cell<u64>; 9] = const { [const { Cell::new(0) }; 9] };
    }

    pub(super) fn add(at: usize) {
        COUNTS.with(|counts| counts[at].set(counts[at].get() + 1));
    }

    /// Returns and resets the thread's counts: orientations by [`super::Stage`], in-sphere signs by stage, and
    /// in-sphere signs that were zero.
    pub fn take() -> ([u64; 4], [u64; 4], u64) {
        COUNTS.with(|counts| {
            let taken = |i: usize| counts[i].take();
            ([0, 1, 2, 3].map(taken), [4, 5, 6, 7].map(taken), taken(8))
        })
    }
}

#[cfg(feature = "stage-counts")]
pub use counters::take;
