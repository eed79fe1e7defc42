//! The machine as a rank sees it: its context, what it sends, what is counted and traced.

pub mod context;
pub mod outbox;
pub mod profile;
pub mod tasks;

pub use context::{Context, Running};
