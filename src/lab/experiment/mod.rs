//! Experiments: sweeps of counted runs, one line of JSON for each run, and the growth of the counts.
//!
//! A [`Sweep`] consists of sizes, kinds of sets, numbers of workers and seeds. [`Sweep::jobs`] lists its runs, and a
//! [`Runner`] executes them. A [`Journal`] stores their [`Line`]s and resumes an interrupted sweep. [`fit`] compares
//! lines with growth laws.

pub mod fit;
mod journal;
mod line;
mod measure;
mod runner;
mod sizes;
mod sweep;

pub use journal::{Entry, Journal, JournalError, Lines, Stamp, read_entries, read_lines};
pub use line::{DepthLine, Line, Program, RunOptions, SCHEMA, Splits};
pub use measure::of_run;
pub use runner::{RunError, Runner};
pub use sizes::{SizesError, parse_sizes};
pub use sweep::{Job, Sweep, SweepError};
