//! Constrained Delaunay triangulations in the plane.
//!
//! **Statement.** Let V be a set of points and S a set of segments between them that meet only at points of V. An edge
//! of a triangulation that contains S is *legal* if it belongs to S or lies on the hull. It is also legal if
//! neither of the two opposite vertices lies in the perturbed circle ([`septet_geometry::predicates`]) of the triangle
//! on the other side. *There is exactly one triangulation of the hull of V that contains S and has only legal edges.*
//! [`Constrained`] computes it from the Delaunay triangulation of V, whatever the order of the segments is. So the
//! result depends neither on the order nor on the number of workers, also if points are cocircular.
//!
//! *Proof.*
//! 1. *At most one.* The perturbation raises the lifted points to heights in general position. A triangulation with
//!    legal edges is then a constrained regular triangulation of generic heights, and there is at most one
//!    (Shewchuk 2008, Theorem 4 and Corollary).
//! 2. *One segment.* Let T be this triangulation for S, and let ab be a new segment without vertices inside. A triangle
//!    that ab does not cross keeps its empty circle, because a constraint only takes vertices out of sight. The
//!    crossed triangles form a polygon on each side of ab. The chain from a to b of a polygon lists the ends of the
//!    crossed edges in the order in which the edges cross ab.
//! 3. *Filling a polygon.* Let c be the vertex of the chain for which no other vertex of the chain lies in the circle of
//!    abc. The triangle abc lies in the polygon: a part of the chain inside it would have a vertex there, and this vertex
//!    would lie in the circle. The vertices between a and c lie left of ac. Otherwise let v be one of them. It lies
//!    outside the circle and left of ab, hence beyond bc. The crossed edge at v meets ab before the crossed edge at c
//!    does, but it enters the triangle through bc. So it crosses the edge at c, a contradiction. The vertices between
//!    c and b lie left of cb by symmetry. The edge ac, with the chain from a to c, therefore satisfies the same
//!    conditions as ab, and induction fills the polygon. Each triangle has a circle without vertices of its chain.
//!    So all edges are legal.
//! 4. *Vertices that the chain visits twice.* Let w be such a vertex, and let p be a vertex between two visits. The
//!    crossed edges at w that are next to p meet ab in two points. The triangle of w and these points contains p. So p
//!    lies in the circle of abw, and w is not chosen while both visits belong to one chain. QED.
//!
//! **Source.** Anglada (1997); Shewchuk and Brown (2015); Shewchuk (2008), *General-dimensional constrained Delaunay and
//! constrained regular triangulations, I*.
//!
//! **Work and depth.** A segment that crosses k edges costs `O(k log k)` tests for chains that a random vertex divides,
//! and `O(k^2)` in the worst case. Sequential: segments may share polygons. The Delaunay triangulation is a run of the
//! [`crate::generate::MeshMachine`].

mod as_it_is;
mod breaklines;
mod cavity;
mod chain;
mod constrained;
mod insert;
mod refine;
mod segment;
mod shapes;
mod star;
mod start;

#[cfg(test)]
mod refine_tests;
#[cfg(test)]
mod tests;

pub use as_it_is::{as_it_is, refined};
pub use breaklines::{NoHeight, Terrain};
pub use constrained::{Constrained, Crossed};
pub use shapes::{Polygon, Shapes};
