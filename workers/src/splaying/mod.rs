//! Star splaying: stars that disagree exchange cells until they agree.
//!
#![doc = include_str!("proof.md")]

mod all_stars;
pub(crate) mod fallback;
pub(crate) mod messages;
pub(crate) mod pass;
mod pending;
mod probes;
mod region;
mod register;
pub(crate) mod splay;
mod step;
pub(crate) mod tell;
mod wire;
