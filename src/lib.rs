//! septet: Delaunay triangulation by sphere separators, density graphs and local convex hulls.

pub mod model;

pub mod generate;
