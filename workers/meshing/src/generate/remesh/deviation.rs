//! How far the boundary of a mesh is from the surface that it follows.
//!
//! **Statement.** The distance from the surface at seven places of each face (middle and thirds of edges; corners lie on
//! the surface), and the distance of the surface's vertices from the faces. Both are lower bounds of the two halves of
//! the Hausdorff distance, each attained at a place that was looked at.

use septet_geometry::point::dist2;
use septet_geometry::range::scale;

use super::surface::Surface;
use crate::bvh::{Bounds, Bvh};
use crate::distance::closest_on_triangle;
use crate::domain::Domain;
use crate::generate::machine::Machine;
use crate::mesh::{Mesh, OUTSIDE};
use crate::space::Space;

/// The distance between a boundary and the surface that it follows, in the unit of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// The largest distance of a sampled place of the boundary from the surface.
    pub of_boundary: f64,
    /// The largest distance of a vertex of the surface from the boundary.
    pub of_surface: f64,
}

impl Deviation {
    /// That of a mesh's boundary; measured on the mesh alone.
    pub fn of<P: Space, M: Machine<P> + Sync>(domain: &Domain<P>, mesh: &Mesh<P>, machine: &M) -> Self {
        let at = |v: u32| scale(mesh.points[v as usize], domain.simplices.exponent);
        let outer = mesh.faces.iter().filter(|f| f.cells.contains(&OUTSIDE));
        let faces: Vec<[P; 3]> = outer.map(|f| [0, 1, 2].map(|i| at(f.vertices.as_ref()[i]))).collect();
        let unscaled = |d: f64| scale(P::splat(d), -domain.simplices.exponent).coord(0);
        let boundary = of_faces(machine, &Surface::new(domain), &faces);
        let surface = of_vertices(machine, domain, &faces);
        Deviation {
            of_boundary: unscaled(boundary.into_iter().fold(0.0, f64::max)),
            of_surface: unscaled(surface.into_iter().map(|v| v.0).fold(0.0, f64::max)),
        }
    }
}

/// The largest distance of each face from the surface.
pub(super) fn of_faces<P: Space, M: Machine<P> + Sync>(
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

/// The distance of each vertex of the surface from the faces, and where it is.
pub(super) fn of_vertices<P: Space, M: Machine<P> + Sync>(
    machine: &M,
    domain: &Domain<P>,
    faces: &[[P; 3]],
) -> Vec<(f64, P)> {
    let tree = Bvh::new(faces.iter().map(|t| Bounds::of(*t)).collect());
    let mut used: Vec<u32> = domain
        .facets
        .iter()
        .flat_map(|f| &f.walls)
        .flat_map(|&w| domain.walls()[w as usize].as_ref().to_vec())
        .collect();
    used.sort_unstable();
    used.dedup();
    machine.map(&used, |&v| {
        let p = domain.points()[v as usize];
        let mut found = f64::INFINITY;
        let distance = |t: u32| {
            let [a, b, c] = faces[t as usize];
            dist2(closest_on_triangle(a, b, c, p), p)
        };
        tree.nearest(p, distance, |_, d2| {
            found = d2.sqrt();
            false
        });
        (found, p)
    })
}
