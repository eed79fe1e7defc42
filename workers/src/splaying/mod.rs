//! Star splaying: stars that disagree exchange cells until they agree.

pub(crate) mod fallback;
pub(crate) mod pending;
pub(crate) mod splay;
pub(crate) mod step;
