//! Experiments: sweeps of counted runs, one line of JSON each, and what can be said of how the counts grow.
//!
//! A [`Sweep`] names sizes, kinds of sets, numbers of workers and seeds; [`Sweep::jobs`] lists its runs, a
//! [`Runner`] makes them, a [`Journal`] keeps their [`Line`]s and takes up an interrupted sweep. [`fit`] judges
//! lines against laws of growth.

pub mod fit;
mod journal;
mod line;
mod measure;
mod runner;
mod sizes;
mod sweep;

pub use journal::{Journal, JournalError, Lines, read_lines};
pub use line::{
    DepthLine, GraphLine, LevelLine, Line, PhaseLine, Program, RoundLine, SCHEMA, Settings, Spread, TreeLine,
};
pub use measure::{of_counts, of_run};
pub use runner::{RunError, Runner};
pub use sizes::{SizesError, parse_sizes};
pub use sweep::{Job, Sweep, SweepError};
