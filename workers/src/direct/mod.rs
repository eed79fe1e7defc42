//! The direct path of `triangulate`: ghost layers, one triangulation per subdomain, and the interface exchange.

pub(crate) mod copies;
pub(crate) mod first_coordinates;
pub(crate) mod ghost_layer;
pub(crate) mod interface;
pub(crate) mod interface_cells;
pub(crate) mod regions;
pub(crate) mod subdomain_triangulation;
