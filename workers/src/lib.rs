//! septet-workers: what a worker runs, and the ways to reach one.
//!
//! A [`worker::Worker`] is a pure message handler over its own state: points it was sent, the part of
//! the partition tree it belongs to, the stars of its home points. It holds no handle to anything else.
//! The modules stand in the order of the phases.

pub mod config;

pub mod schedule;

pub mod profile;

pub mod table;
pub mod tasks;

pub mod tree;

pub mod outbox;

pub mod leader;

mod worker;

pub mod machine;

pub mod partition;

pub mod frame;

mod grow;

mod answers;
mod query;

mod walk;

mod forwards;

mod neighbours;

mod naive;

pub mod summaries;

pub mod choice;

mod ghosts;
mod halo;

mod sets;

mod independent;

mod border;
mod piece;
mod seam;
mod stars;

mod chains;
mod check;
mod done;
mod edges;
mod sums;

mod exchange;
mod fallback;
mod react;
mod repair;

mod links;
mod lookup;

mod rows;

pub mod merge;

pub mod view;

pub mod host;

pub mod transport;
