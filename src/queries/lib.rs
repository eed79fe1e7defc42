//! septet-queries: questions about a finished triangulation.
//!
//! A [`Tessellation`] is made once from a run and never changes. Every answer is a function of the points and the arguments:
//! it depends neither on threads nor on the order of queries. Where a sign decides, it is exact. Queries run in parallel on the
//! threads of the call ([`septet_core::cores::within`]).
//!
//! | question | modules |
//! | --- | --- |
//! | rows, neighbours, hull, vertices that edges join, volumes, shapes | [`tessellation`], `rows`, `incidence` |
//! | the cell of a query, the nearest vertex | `locate`, `nearest` |
//! | Voronoi vertices, ridges, areas, volumes, centroids | [`voronoi`], `dual`, `double`, `clip`, `centroids`, [`clipped`] |
//! | barycentric coordinates, gradients, weights of interpolations | [`weights`], `linear`, `natural` |
//! | volumes and centroids of power cells, and of Voronoi cells in periodic boxes | [`power`], `clip` |
//! | volumes of cells in periodic boxes | [`images`] |
//! | alpha complexes and shapes | [`alpha`] |
//! | exact signs and ratios in rare cases | `exact` |

pub mod alpha;
mod centroids;
mod clip;
pub mod clipped;
pub mod dimension;
mod double;
mod dual;
pub mod error;
mod exact;
pub mod images;
mod incidence;
mod linear;
mod locate;
mod loops;
mod natural;
mod nearest;
pub mod power;
pub mod ragged;
mod rows;
mod seen;
pub mod tessellation;
#[cfg(test)]
mod tests;
pub mod voronoi;
pub mod weights;

pub use alpha::{AlphaFiltration, AlphaShape};
pub use clipped::Clipped;
pub use dimension::Dimension;
pub use error::QueryError;
pub use images::volumes_in_box;
pub use power::{Polytope, Region, power_cells, power_centroids, power_volumes};
pub use ragged::Ragged;
pub use tessellation::{NONE, Tessellation};
pub use voronoi::Ridges;
pub use weights::{Barycentric, Method, Weights};
