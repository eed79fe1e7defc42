//! Remeshing: a mesh of the volume inside a closed surface, with a new boundary that follows the surface.
//!
//! **Statement.** Remeshing keeps only the corners and ridges of the surface (`features`). It samples points on the
//! ridges and on the surface. A cell of their Delaunay triangulation is inside iff its circumcentre is inside. The
//! faces between inside and outside are those whose dual edge crosses the surface an odd number of times. They form the
//! *restricted Delaunay triangulation*. As the boundary of a set of cells, it is closed. Let the dual edge of a face
//! meet the surface in s. The *surface ball* of the face has its centre in s, passes through the corners of the face,
//! and contains no vertex. When the refinement ends,
//!
//! 1. every surface ball has a radius of at most f(s), where f is the size function. The corners of its face lie on
//!    the surface, and the distance of its centre from s is at most the requested distance;
//! 2. every edge of the boundary has two faces, and every vertex on the surface has one fan of faces, so the boundary
//!    is a 2-manifold. It has the same Euler characteristic as the surface, unless balls were divided down to the
//!    limit of `thin_sheets`;
//! 3. every chord of a ridge is an edge of the boundary, and its midpoint is within the requested distance of the
//!    midpoint of its part of the ridge;
//! 4. every cell inside has a circumradius of at most f at its centre.
//!
//! Each violation gives a point to insert: s, the midpoint of a chord, or the centre of the cell. If the centre of a
//! cell lies in a surface ball, the point s of that ball replaces it. If a point lies in the smallest ball of a chord,
//! the midpoint of the chord replaces it (Shewchuk's order). `edge_recovery` gives the candidates for a chord that is
//! not an edge of the boundary. Each round inserts an independent set of its candidates.
//!
//! **Source.** Boissonnat and Oudot (2005), Oudot, Rineau and Yvinec (2005), as in CGAL's `Mesh_3`; ridges as in
//! Shewchuk (1998).
//!
//! **Departures.**
//! - *Order.* The surface is refined before the volume is sampled, so that points of the volume can be kept out of the
//!   surface balls.
//! - *Spacing.* Points are closer than f if conditions 1 to 4 require it, at ridges and sheets closer than f. The
//!   function f bounds radii from above everywhere. It bounds the spacing from below only where the surface permits
//!   it.
//! - *No weights.* The ridges are not protected by weights. At ridges that meet at small angles, the refinement may
//!   not end. The number of rounds is therefore limited, and the error reports the features.
//! - *Failures.* Remeshing fails if two ridges run next to each other at an angle of a few degrees and are closer to
//!   each other than the length of their chords. Examples are the fold of a scan, or a mouth or ear that was closed.
//!   Faces then span the fold and do not follow the surface at s. The other side of the fold blocks the points
//!   inserted at s. These points cause further ones, about a tenth of the size apart, however many rounds there are.
//!   `--feature-angle` keeps fewer ridges, and `--boundary exact` keeps all triangles.
//!
//! **Rounds and work.** See [`super::generate`]. In addition, each round of completion locates all circumcentres.

mod chord;
mod deviation;
mod edge_recovery;
mod features;
mod large_cells;
mod options;
mod refine;
mod refinement;
mod restricted;
mod ridges;
mod surface;
mod thin_sheets;
mod topology;

use crate::domain::Domain;
use crate::space::Space;

use super::generator::{Generator, Rules};
use super::machine::MeshMachine;
use super::{GeneratedMesh, GenerationError};

pub use features::{Ridge, SurfaceFeatures};
pub use options::{DEFAULT_DISTANCE, DEFAULT_PARTS, Options};

/// Generates the points of the volume inside a closed surface and triangulates them.
/// [`Deviation`](crate::conformity::Deviation) reports the resulting distance between boundary and surface.
///
/// # Errors
/// Returns [`GenerationError::Unsupported`] in the plane and for domains that are not surfaces. Returns another
/// [`GenerationError`] if the machine fails, features cannot be recovered, or the mesh needs too many vertices.
pub fn remesh<P: Space, M: MeshMachine<P> + Sync>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    feature_angle: f64,
    options: Options,
    machine: &mut M,
) -> Result<GeneratedMesh<P>, GenerationError<M::Error>> {
    if P::DIM != 3 || domain.kind != crate::input::DomainKind::Surface {
        return Err(GenerationError::Unsupported("only closed surfaces in space can be remeshed"));
    }
    let features = SurfaceFeatures::new(domain, feature_angle);
    let mut generator = Generator::new(domain, rules, machine);
    generator.vertices = super::Vertices::default();
    refinement::Refinement::new(generator, &features, options).run()
}

#[cfg(test)]
mod tests;
