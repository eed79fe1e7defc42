//! Triangulations in periodic boxes.
//!
//! **Statement.** Let a box have the length `L_a` along each periodic axis `a`. A site at `x` has the images `x + k L`, for
//! all vectors `k` of whole numbers. The Delaunay (regular) triangulation of all images is periodic, and the result is one
//! cell of each class of translated cells. Ties are broken by positions, whose order no translation changes, so equal cells
//! are broken alike. The result does not depend on the origin of the box.
//!
//! **Method.** The machine triangulates the sites of the box and their images near it. The *base* site of a row is its image
//! in the half-open box.
//! 1. *The images with `k` in `{-1, 0, 1}` suffice for the stars of base sites.* Let the power of a position with respect to
//!    an open ball be negative inside. For positions `x` and `p` and a vector `v` of the lattice, the powers satisfy
//!    `f(x - v) + f(p + v) = f(x) + f(p) + 2 |v|^2 - 2 v . (x - p)`. Let `p` be a base vertex of a cell whose ball contains
//!    none of these images, but a farther one, `x`. Then `|x_a - p_a| > L_a` for an axis. With `v = +- L_a e_a`, one of `p + v`
//!    and `x - v` is inside; `p + v` is one of the images. So `x - v` is inside, and after some steps an image is.
//! 2. *Fewer images suffice* if the machine has all of them within a box, the *cover*, and the conflict region of each cell
//!    with a base vertex lies in the cover. No base vertex may be on the hull. Cells with base vertices and images decide this
//!    (`quotient`). If a region does not lie in the cover, the run is repeated with more images, up to those of 1.
//! 3. A class of cells has exactly one cell whose lexicographically smallest vertex is a base site. These cells are the result
//!    (`quotient`). The sum of their volumes must be that of the box, and in the plane there must be twice as many as sites.
//!
//! One power of two scales the box and the sites into the range of exact signs first, in which no step below underflows.
//!
//! A position that rounding would change is the sum of two numbers ([`septet_geometry::site`]), so nothing is rounded.
//!
//! **Source.** Dolbilin and Huson, "Periodic Delone tilings" (1997); Caroli and Teillaud, "Computing 3D periodic
//! triangulations" (2009), who need several sheets where the result is no simplicial complex. Here, it need not be one.
//!
//! **Work.** That of the triangulation of the box and its images: for well-spaced sites, `O(n^(1-1/d))` images. Few sites, or
//! sites with large voids, have all `3^d`.
//!
//! **Processes.** Each process finds the base sites and the images of its rows, and sends them to the processes whose ranks
//! read them, so the machine is that of one process. Every process finds the cells of the result among those of its ranks. The
//! first one collects them.
//!
//! **Departures.** Sites with weights and images are one type, so a periodic run without weights has weights of 0. Along an
//! axis that is not periodic, the box does not end.

mod edges;
mod images;
mod lattice;
mod quotient;
mod run;
mod team;

pub use run::check_box;
pub(super) use run::{run_periodic, run_shared};

#[cfg(test)]
mod tests;
