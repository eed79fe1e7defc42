//! The distance between boundary and surface during refinement.
//!
//! **Statement.** The distance to the surface is measured at seven points of each face: the centroid, and the points
//! that divide the edges in thirds. The corners lie on the surface. The distance from each vertex of the surface to
//! the faces is also measured. The two maxima are lower bounds for the two one-sided Hausdorff distances.

use septet_geometry::point::dist2;

use super::surface::Surface;
use crate::bvh::{Bounds, Bvh};
use crate::distance::closest_on_triangle;
use crate::domain::Domain;
use crate::generate::machine::MeshMachine;
use crate::space::Space;

/// Returns the largest measured distance of each face from the surface.
pub(super) fn of_faces<P: Space, M: MeshMachine<P> + Sync>(
    machine: &M,
    surface: &Surface<P>,
    faces: &[[P; 3]],
) -> Vec<f64> {
    machine.map(faces, |&[a, b, c]| {
        let thirds = [[a, b], [b, c], [c, a]].map(|[p, q]| [(p * 2.0 + q) / 3.0, (p + q * 2.0) / 3.0]);
        let places = thirds.into_iter().flatten().chain([(a + b + c) / 3.0]);
        let distances = places.filter_map(|p| surface.nearest(p).map(|near| dist2(near.at, p)));
        distances.fold(0.0, f64::max).sqrt()
    })
}

/// Returns, for each vertex of the surface, its distance to the faces, its position, and the nearest face.
pub(super) fn of_vertices<P: Space, M: MeshMachine<P> + Sync>(
    machine: &M,
    domain: &Domain<P>,
    faces: &[[P; 3]],
) -> Vec<(f64, P, usize)> {
    let tree = Bvh::new(faces.iter().map(|t| Bounds::of(*t)).collect());
    let mut used: Vec<u32> = domain.triangles().into_iter().flatten().collect();
    used.sort_unstable();
    used.dedup();
    machine.map(&used, |&v| {
        let p = domain.points()[v as usize];
        let mut found = (f64::INFINITY, p, 0);
        let distance = |t: u32| {
            let [a, b, c] = faces[t as usize];
            dist2(closest_on_triangle(a, b, c, p), p)
        };
        tree.nearest(p, distance, |t, d2| {
            found = (d2.sqrt(), p, t as usize);
            false
        });
        found
    })
}
