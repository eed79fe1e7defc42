//! The sequential kernel: incremental Delaunay triangulation in the plane and in space.
//!
//! **Statement.** Bowyer (1981) and Watson (1981): the cells whose circumsphere contains a new point
//! form a ball around it; replacing them by the cone from the point over the ball's boundary gives the
//! Delaunay triangulation of the larger set. One of them is found by a walk (`search`), the others
//! by going from neighbour to neighbour (`cavity`); nearly all questions are answered by rounded
//! spheres (`sphere`), the others by [`crate::predicates`].
//!
//! **Work.** In the order of [`insertion_order`] (biased random rounds along a curve: Amenta, Choi and
//! Rote 2003) O(n log n) expected for points whose samples have linear triangulations; in the plane
//! always; in space O(n^2) at worst, which is the size of the result.
//!
//! **Departures.** Outer space is a vertex, so a point outside the hull needs no special step. Points
//! are stored in the order in which they are inserted, and cells take the slots of those they replace.
//! Since ties are perturbed by coordinates, the set of cells is a function of the set of points:
//! neither order nor numbering matters.

mod cavity;
mod cells;
mod order;
mod read;
mod ridges;
mod rows;
mod scratch;
mod search;
mod sphere;
mod triangulation;

pub use cells::Cells;
pub use order::{insertion_order, insertion_round};
pub use read::facet_without;
pub use rows::{FIRST_MARK, KeptCells};
pub use triangulation::{Incremental, IncrementalError, STOP_CHECK_INTERVAL};

#[cfg(test)]
pub(crate) mod tests;
