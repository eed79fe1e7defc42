//! Star splaying: stars that disagree exchange cells until they agree.
//!
#![doc = include_str!("proof.md")]

pub(crate) mod fallback;
pub(crate) mod messages;
mod pending;
mod region;
pub(crate) mod splay;
mod step;
mod wire;
