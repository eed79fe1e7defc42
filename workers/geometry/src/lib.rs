//! septet-geometry: the mathematics of the parallel Delaunay algorithm.
//!
//! The crate has no input or output, no threads, no clock and no unordered maps. Every algorithm is written once over
//! the trait [`point::Point`], which is implemented for the plane ([`glam::DVec2`]), for space ([`glam::DVec3`]) and for
//! dimensions 4 to 6 ([`higher::VecN`]).
//!
//! | purpose | modules |
//! | --- | --- |
//! | points, boxes and measures | [`point`], [`site`], [`higher`], [`coordinates`], [`bounds`], [`measure`], [`lists`] |
//! | exact signs | [`range`], [`filter`], [`predicates`] |
//! | work and depth of the counted machine | [`cost`] |
//! | rules that ranks evaluate at items | [`evaluation`] |
//! | separators | [`separator`] |
//! | nearest neighbours | [`neighbourhood`], [`selection`], [`coordinate_arrays`], [`kd_blocks`], [`simd`] |
//! | supergraphs and independent sets | [`graph`], [`grid`], [`priority`], [`hash`] |
//! | stars | [`hull`], [`complex`] |
//! | triangulations | [`incremental`], [`conflict_region`]; the baseline [`dependence`] |
//!
//! ```
//! use glam::DVec2;
//! use septet_geometry::incremental::{Incremental, IncrementalError};
//!
//! let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [2.0, 2.0]].map(DVec2::from_array);
//! let triangulation = Incremental::new(points.to_vec())?;
//! assert_eq!(triangulation.cells().count(), 2);
//! # Ok::<(), IncrementalError>(())
//! ```

pub mod bounds;
pub mod complex;
pub mod conflict_region;
pub mod coordinate_arrays;
pub mod coordinates;
pub mod cost;
mod curve;
pub mod dependence;
pub mod evaluation;
pub mod filter;
pub mod graph;
pub mod grid;
pub mod hash;
pub mod higher;
pub mod hull;
pub mod incremental;
pub mod kd_blocks;
pub mod lists;
pub mod measure;
pub mod neighbourhood;
pub mod point;
pub mod predicates;
pub mod priority;
pub mod range;
pub mod selection;
pub mod separator;
pub mod simd;
pub mod site;
pub mod two_parts;
