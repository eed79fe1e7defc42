//! The star of a vertex as a local convex hull.
//!
//! **Statement** (paper, Lemmas 4.1 and 4.3). Lift the points to the paraboloid. Consider the convex hull, one
//! dimension lower, of the rays from the lift of `p` to the other lifts. Its vertices correspond to the edges at `p` of
//! the lower hull, and hence of the Delaunay triangulation. If the candidates include every Delaunay neighbour of `p`,
//! the hull of the candidates is the star of `p`.
//!
//! The rays are not intersected with a hyperplane. The hull is stored as the *link* of `p`, a closed complex of facets
//! with `DIM` vertices, in which the vertical ray is the infinite vertex. A candidate is added by replacing the facets
//! that it conflicts with ([`crate::complex`]). A finite facet `f` conflicts with `q` iff `q` lies in the circumsphere
//! of `(p, f)`. An infinite facet conflicts with `q` iff `q` lies beyond the hull facet.
//!
//! **Work and depth.** Each near candidate takes one sweep over the facets of the link, which is a vector step. For `m`
//! candidates and link size `l`: depth O(m), work O(m l). Both are constant under the paper's hypothesis. If the link
//! becomes large while many candidates remain, these are added at random with conflict lists (`random_order`): O(m log m)
//! expected work and O(log^2 m) depth.
//!
//! In dimensions 4 to 6, the link is a list of facets (`general`, `higher`).
//!
//! **Departures.**
//! 1. The near candidates, and all candidates of a star with at most 64, are added in order of distance, so most conflict with no facet. A facet conflicts with no candidate
//!    farther than the diameter of its sphere. The sweeps end when the remaining candidates are farther than the
//!    diameters of all spheres.
//! 2. Tests run in rounded arithmetic on inverse images (`planes`), with one error bound for each facet. If the bound
//!    is inconclusive, the exact predicates decide.
//! 3. Few undecided facets need an exact test, as follows.
//!
//! **One exact test for each candidate.** Over the cone that the link spans, the lifted facets are the graph of a
//! convex function, namely the maximum of their linear functions. This also holds under the perturbation. Let `q` be a
//! candidate.
//! 1. *`q` lies in the cone.* Then `q` lies below the graph iff it lies below the facet whose own cone contains `q`. So
//!    if that facet does not conflict, no facet does. If `q` lies on a common face of several cones, it is in all of
//!    them, and their functions agree there.
//! 2. *`q` lies outside the cone.* Then `q` lies strictly beyond some infinite facet.
//!
//! Suppose that rounded arithmetic finds no conflict but leaves facets undecided. Then one exact test of the finite
//! facet in 1, or one orientation for each infinite facet, decides. If there is a conflict, only undecided facets
//! adjacent to the cavity are tested, while the cavity grows. Among cospherical points, rounded arithmetic decides no
//! test. For such points, this rule saves testing every facet exactly.

#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

mod builder;
mod candidate;
mod cavity;
mod change;
mod conflict_lists;
mod corners;
mod general;
mod hidden;
mod higher;
mod large;
mod planes;
mod random_order;
mod witness;

pub use builder::StarBuilder;
pub use change::Extended;
pub use large::LargeStars;
pub use witness::Witnesses;

#[cfg(test)]
mod tests;
