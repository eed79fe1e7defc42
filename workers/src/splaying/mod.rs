//! Star splaying: stars that disagree exchange cells until they agree.

pub(crate) mod exchange;
pub(crate) mod fallback;
pub(crate) mod react;
pub(crate) mod repair;
