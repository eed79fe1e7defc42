//! septet-doors: what the Python package and the C library share.
//!
//! A *door* is a way to call septet from another language. Doors take flat arrays: `n` rows of `d` numbers are one slice of
//! `n d` numbers. Indices have 32 bits, and [`NONE`] means none; read as `i32`, it is -1. Every call runs on the threads
//! of its [`Call`], never in a pool that calls share, and ends soon after its flag is set. Results do not depend on threads.
//!
//! | what | module |
//! | --- | --- |
//! | threads, cancellation, options of a triangulation | [`call`] |
//! | failures: code, text with the remedy, row of a point | [`failure`] |
//! | a triangulation in the plane or in space | [`triangulated`] |
//! | weights, periodic boxes, and the queries that fit them | [`sites`], `folded` |
//! | location, nearest vertices, interpolation | `queries` |
//! | Voronoi cells | [`voronoi`] |
//! | alpha complexes | [`alpha`] |
//! | flat arrays as rows of points | `rows` |

pub mod alpha;
pub mod call;
pub mod clipped;
pub mod failure;
mod folded;
mod queries;
mod rows;
pub mod sites;
#[cfg(test)]
mod tests;
pub mod triangulated;
pub mod voronoi;

pub use alpha::{Filtration, Shape};
pub use call::{Call, Request};
pub use clipped::Clipped;
pub use failure::{Failure, Forecast};
pub use rows::check_columns;
pub use septet_core::spec::Periodic;
pub use septet_core::{Code, Door};
pub use septet_queries::{Barycentric, Method, NONE, Ragged, Ridges, Weights};
pub use sites::Sites;
pub use triangulated::{Triangulated, simulated};
pub use voronoi::{Corners, PowerCells};
