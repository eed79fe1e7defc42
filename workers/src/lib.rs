//! septet-workers: the program of a rank, and the machine that runs it.
//!
//! Each rank is one async function over a [`machine::Context`]. It holds the points that it received, its place in
//! the partition tree and the stars of its points. It has no handle to anything else. Each folder is a *room*, a
//! group of modules: the machine, the data that phases share, or a part of a run.

pub mod config;
pub mod machine;
pub mod state;

pub mod partition;

mod neighbours;

pub mod graph;

mod direct;

mod evaluation;

mod stars;

mod splaying;

pub mod result;

pub mod input;

pub mod share;

pub mod programs;

pub mod hosts;

pub use graph::{selection, sharing, summaries};
pub use hosts::{host, transport};
pub use machine::{outbox, profile};
pub use partition::leader;
pub use result::{merge, view};
pub use state::{frame, table};
