//! The direct path of `triangulate`: ghost layers, one piece a worker, and the interfaces between pieces.

pub(crate) mod border;
pub(crate) mod halo;
pub(crate) mod interface;
pub(crate) mod piece;
