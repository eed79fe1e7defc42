//! The star of a vertex as a local convex hull.
//!
//! **Statement** (paper, Lemmas 4.1 and 4.3). Lift the points to the paraboloid. The edges at `p` of
//! the lower hull, hence of the Delaunay triangulation, are the vertices of the convex hull, one
//! dimension down, of the rays from `p`'s lift to the other lifts. If the candidates hold every
//! Delaunay neighbour of `p`, the hull of the candidates gives the star of `p`.
//!
//! We do not cut the rays with a hyperplane: the hull is kept as the *link* of `p`, a closed complex of
//! `DIM`-vertex facets in which the vertical ray is the infinite vertex, and a candidate is added by
//! digging the facets it conflicts with ([`crate::complex`]). A finite facet `f` conflicts with `q` iff
//! `q` lies in the circumsphere of `(p, f)`; an infinite one iff `q` lies beyond the hull facet.
//!
//! **Work and depth.** One sweep over the link's facets for each candidate: a vector step. With `m`
//! candidates and link size `l`: depth O(m), work O(m l); both constants under the paper's hypothesis.
//!
//! **Departures.** (1) Candidates come in order of distance, so that most conflict with nothing, and the
//! sweeps end where no facet reaches: a facet conflicts with no candidate farther than its sphere's
//! diameter. (2) The tests are done in
//! rounded arithmetic on inverse images (`planes`), with one error bound per facet; what the bound does not
//! decide goes to the exact predicates. (3) Of those undecided, few need be asked: see below.
//!
//! **One exact test a candidate.** Over the cone that the link spans, the lifted facets are the graph of a
//! convex function, the largest of their linear functions; under the perturbation too. A candidate `q` in
//! the cone lies below it iff it lies below the facet whose own cone holds `q`: if that does not conflict,
//! no facet does. Outside the cone `q` lies beyond some infinite facet, strictly. So if rounded arithmetic
//! finds no conflict but leaves facets undecided, the exact test of that one finite facet, or an
//! orientation for each infinite one, decides; and when there is a conflict, only facets that meet the
//! cavity are asked, as it is dug. Among cospherical points, where nothing is decided by rounding, this is
//! what keeps a sweep from one exact test for each facet. (A `q` on the common face of several cones is
//! in all of them, and their functions agree there.)

#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

mod builder;
mod candidate;
mod change;
mod corners;
mod planes;
mod witness;

pub use builder::StarBuilder;
pub use change::Extended;
pub use witness::Witnesses;

#[cfg(test)]
mod tests;
