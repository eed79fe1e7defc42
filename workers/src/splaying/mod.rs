//! Star splaying: stars that disagree exchange cells until they agree.
//!
#![doc = include_str!("proof.md")]

pub(crate) mod fallback;
pub(crate) mod pending;
pub(crate) mod splay;
pub(crate) mod step;
