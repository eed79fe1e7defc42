//! The direct path of `triangulate`: ghost layers, one piece a worker, and the interfaces between pieces.

pub(crate) mod ghost_layer;
pub(crate) mod interface;
pub(crate) mod interface_cells;
pub(crate) mod subdomain_triangulation;
