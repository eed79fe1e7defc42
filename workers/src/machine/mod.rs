//! The machine as a rank sees it: its context, collective operations, the outbox, counts and traces.

pub mod collectives;
pub mod context;
mod flips;
pub mod group;
pub mod group_relay;
pub mod group_tree;
pub mod outbox;
pub mod profile;
pub mod reduction;

pub use context::{Context, Running};
