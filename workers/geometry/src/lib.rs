//! septet-geometry: the mathematics of the parallel Delaunay algorithm.
//!
//! The crate has no input or output, no threads, no clock and no unordered maps. Every algorithm is written once over
//! the trait [`point::Point`], which is implemented for the plane ([`glam::DVec2`]) and for space ([`glam::DVec3`]).

pub mod cost;

pub mod bounds;

pub mod coordinate_arrays;

pub mod kd_blocks;

pub mod simd;

pub mod lists;

pub mod point;

pub mod range;

pub mod filter;

pub mod predicates;

pub mod complex;

pub mod separator;

pub mod selection;

pub mod neighbourhood;

pub mod graph;

pub mod grid;

pub mod hash;

pub mod priority;

pub mod hull;

pub mod measure;

pub mod conflict_region;

pub mod incremental;

pub mod dependence;
