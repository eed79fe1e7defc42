//! The surface that a remeshed boundary follows.
//!
//! **Statement.** The distances are those of [`Deviation`](crate::conformity::Deviation). A change of the boundary is
//! permitted if
//! 1. no new face is farther from the surface than the aim of remeshing, or than the old faces if these are farther;
//! 2. no vertex of the surface near the old faces is farther from the new faces than the aim, or than from the old
//!    faces if these are farther.
//!
//! *Then the largest distances of a mesh do not rise above the aim.* The nearest point of the boundary to a vertex of
//! the surface either remains, or lies on the old faces and condition 2 holds. Changes of different faces therefore do
//! not depend on each other.

use septet_geometry::point::dist2;
use septet_geometry::range::scale;

use crate::bvh::{Bounds, Bvh};
use crate::conformity::OFF;
use crate::distance::closest_on_triangle;
use crate::domain::Domain;
use crate::generate::remesh::DEFAULT_DISTANCE;
use crate::space::Space;

/// The triangles and vertices of a surface.
pub(super) struct Surface<P: Space> {
    walls: Vec<[P; 3]>,
    facets: Vec<u32>,
    tree: Bvh<P>,
    vertices: Vec<P>,
    vertex_tree: Bvh<P>,
    /// The largest distance, in scaled coordinates, if one was requested.
    distance: Option<f64>,
    /// The largest distance of a point from the plane of its facet.
    flat: f64,
}

/// A face of the boundary, and the largest size at its corners.
pub(super) type Sized<P> = ([P; 3], f64);

impl<P: Space> Surface<P> {
    pub(super) fn new(domain: &Domain<P>, distance: Option<f64>) -> Self {
        let place = |v: u32| domain.points()[v as usize];
        let (mut walls, mut facets, mut used) = (Vec::new(), Vec::new(), Vec::new());
        for (f, facet) in (0u32..).zip(&domain.facets) {
            for &wall in &facet.walls {
                let row = domain.walls()[wall as usize];
                let corners = [0, 1, 2].map(|i| row.as_ref()[i]);
                used.extend(corners);
                walls.push(corners.map(place));
                facets.push(f);
            }
        }
        used.sort_unstable();
        used.dedup();
        let vertices: Vec<P> = used.into_iter().map(place).collect();
        let largest = vertices.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i).abs())).fold(0.0, f64::max);
        Surface {
            tree: Bvh::new(walls.iter().map(|w: &[P; 3]| Bounds::of(*w)).collect()),
            vertex_tree: Bvh::new(vertices.iter().map(|&p| Bounds::of([p])).collect()),
            walls,
            facets,
            vertices,
            distance: distance.map(|d| scale(P::splat(d), domain.simplices.frame.exponent).coord(0)),
            flat: 0.25 * OFF * largest,
        }
    }

    /// Returns the point of the surface nearest to a point, and its facet.
    pub(super) fn nearest(&self, q: P) -> Option<(P, u32)> {
        let mut best = None;
        let closest = |w: u32| {
            let [a, b, c] = self.walls[w as usize];
            closest_on_triangle(a, b, c, q)
        };
        self.tree.nearest(
            q,
            |w| dist2(closest(w), q),
            |w, _| {
                best = Some((closest(w), self.facets[w as usize]));
                false
            },
        );
        best
    }

    /// Returns the nearest point as [`Surface::nearest`] does, if it is in the plane of the facet up to rounding.
    pub(super) fn place(&self, q: P, normals: &[P]) -> Option<(P, u32)> {
        let (at, facet) = self.nearest(q)?;
        let first = self.facets.partition_point(|&f| f < facet);
        let off = (at - self.walls[first][0]).dot(normals[facet as usize]).abs();
        (off <= self.flat).then_some((at, facet))
    }

    fn aim(&self, size: f64) -> f64 {
        self.distance.unwrap_or(DEFAULT_DISTANCE * size)
    }

    /// Returns the largest distance of a face from the surface, at the points of the check.
    fn off(&self, [a, b, c]: [P; 3]) -> f64 {
        let thirds = [[a, b], [b, c], [c, a]].map(|[p, q]| [(p * 2.0 + q) / 3.0, (p + q * 2.0) / 3.0]);
        let places = thirds.into_iter().flatten().chain([(a + b + c) / 3.0]);
        let distance = |p: P| self.nearest(p).map_or(f64::INFINITY, |near| dist2(near.0, p));
        places.map(distance).fold(0.0, f64::max).sqrt()
    }

    /// Returns the largest distance of some faces from the surface.
    pub(super) fn off_all(&self, faces: &[Sized<P>]) -> f64 {
        faces.iter().map(|f| self.off(f.0)).fold(0.0, f64::max)
    }

    /// Returns `true` if new faces may replace old ones. `before` returns the distance of the old ones.
    pub(super) fn permits(&self, old: &[Sized<P>], before: impl Fn() -> f64, new: &[Sized<P>]) -> bool {
        let fits = |&(face, size): &Sized<P>| {
            let off = self.off(face);
            off <= self.aim(size) || off <= before()
        };
        if !new.iter().all(fits) {
            return false;
        }
        let reach = old.iter().map(|f| self.distance.unwrap_or(f.1)).fold(0.0, f64::max);
        let least = new.iter().map(|f| self.aim(f.1)).fold(f64::INFINITY, f64::min);
        let mut near = Bounds::of(old.iter().flat_map(|f| f.0));
        near = Bounds { low: near.low - P::splat(reach), high: near.high + P::splat(reach) };
        let distance = |faces: &[Sized<P>], p: P| {
            let to = |&([a, b, c], _): &Sized<P>| dist2(closest_on_triangle(a, b, c, p), p);
            faces.iter().map(to).fold(f64::INFINITY, f64::min).sqrt()
        };
        let mut fits = true;
        self.vertex_tree.visit(&near, |v| {
            let p = self.vertices[v as usize];
            let before = distance(old, p);
            fits = before > reach || distance(new, p) <= before.max(least);
            fits
        });
        fits
    }
}
