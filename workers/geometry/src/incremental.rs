//! The sequential kernel: incremental Delaunay triangulation in the plane and in space.
//!
//! **Statement** (Bowyer 1981, Watson 1981). The cells whose circumspheres contain a new point form a topological
//! ball, the *cavity*, around it. Replacing them by the cone from the point over the boundary of the cavity yields
//! the Delaunay triangulation of the larger set. A walk finds one of these cells (`search`). A breadth-first search
//! from neighbour to neighbour finds the others (`cavity`). Rounded spheres (`sphere`) decide nearly all conflict
//! tests, and [`crate::predicates`] decide the rest.
//!
//! **Work.** O(n log n) expected in the order of [`insertion_order`], for points whose random samples have
//! triangulations of linear size. Point sets in the plane always satisfy this condition. In space, the work is O(n^2)
//! at worst, which is then also the size of the result. The order consists of biased random rounds, each along a curve
//! (Amenta, Choi and Rote 2003).
//!
//! **Departures.** The exterior is represented by an infinite vertex, so a point outside the hull needs no special
//! step. Points are stored in the order of their insertion, and new cells use the slots of those that they replace.
//! Ties are perturbed by coordinates. The set of cells is therefore a function of the set of points, independent of
//! order and numbering.

mod cavity;
mod cells;
mod operations;
mod order;
mod read;
mod ridges;
mod rows;
mod scratch;
mod search;
mod sphere;
mod triangulation;

pub use cells::Cells;
pub use operations::Operations;
pub use order::{FarPoints, curve_order, insertion_order, insertion_round};
pub use read::facet_without;
pub use rows::{FIRST_MARK, KeptCells};
pub use triangulation::{Incremental, IncrementalError, STOP_CHECK_INTERVAL};

#[cfg(test)]
pub(crate) mod tests;
