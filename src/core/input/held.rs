//! The rows that a process holds.

use septet_workers::input::Source;

/// The rows of this process.
#[derive(Clone, Copy)]
pub(crate) struct Held<'a, P> {
    /// The source of the rows.
    pub(crate) source: &'a dyn Source<P>,
    /// The points of this process.
    pub(crate) points: &'a [P],
    /// The number of the first row of all processes, and of those of this process if it numbers them itself.
    pub(crate) first: u64,
    /// Number of rows that are numbered from there on.
    pub(crate) rows: u64,
}
