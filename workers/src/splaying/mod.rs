//! Star splaying: stars that disagree exchange cells until they agree.

pub(crate) mod fallback;
pub(crate) mod messages;
mod pending;
pub(crate) mod splay;
mod step;
mod wire;
