//! Remeshing: the volume that a closed surface encloses, with a boundary of its own that follows the surface.
//!
//! **Statement.** Of the surface only corners and ridges above the feature angle are kept. Points are sampled on ridges
//! and on the surface, and of their Delaunay triangulation a cell is inside iff its circumcentre is: faces between
//! inside and outside are those whose dual edge crosses the surface an odd number of times, the *restricted Delaunay
//! triangulation*. As the border of a set of cells it is closed. A face's dual edge meets the surface in s; the
//! *surface ball* around s through the face's corners holds no vertex. When the refinement ends,
//!
//! 1. every surface ball has a radius of at most f(s), its face's corners lie on the surface, and the face's centre is
//!    no farther from s than the distance asked for;
//! 2. every edge of the boundary has two faces, every vertex on the surface one fan of them: a 2-manifold (with the surface's Euler
//!    characteristic, or else balls were divided as far as `thin` says);
//! 3. every chord of a ridge is an edge of the boundary, its middle no farther from the ridge's than that distance;
//! 4. every cell inside has a circumradius of at most f at its centre.
//!
//! What violates one of these names a point to be inserted: s, the middle of a chord, or the cell's centre; for a
//! centre in a surface ball its s, for either in the smallest ball of a chord the chord's middle (Shewchuk's
//! order). What a chord that is no edge of the boundary calls for is in `beside`. The candidates of a round are one independent set.
//!
//! **Source.** Boissonnat and Oudot (2005), Oudot, Rineau and Yvinec (2005), as in CGAL's `Mesh_3`; ridges as in
//! Shewchuk (1998).
//!
//! **Departures.** The surface is refined before the volume is sampled, so that the volume's points stay out of the
//! surface balls. Where 1 to 4 need it (ridges and sheets closer than f), points are closer than f: f bounds radii
//! from above everywhere, spacing from below only where the surface lets it. Ridges are not protected by weights: at
//! ridges that meet at small angles the refinement may not end, so rounds are limited and the features named. Where such
//! files fail: a ridge runs at a few degrees beside another one (a fold of a scan, a mouth or an ear that was closed), so that the
//! two are closer to each other than the chords are long. Faces are then spanned across the fold, turned against the surface at s; the points
//! put at s are held by the fold's other side and call for the next, some tenth of a size apart, however many rounds there are.
//! `--feature-angle` keeps fewer ridges, `--boundary exact` all triangles.
//!
//! **Rounds and work.** As for [`super::generate`]; a round of completion locates all circumcentres.

mod chord;
mod deviation;
mod edge_recovery;
mod features;
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
use super::machine::Machine;
use super::{Failure, Generated};

pub use features::{Ridge, SurfaceFeatures};
pub use options::{DEFAULT_DISTANCE, DEFAULT_PARTS, Options};

/// Generates the points of the volume in a closed surface and triangulates them. [`Deviation`](crate::conformity::Deviation) says how far the boundary
/// then is from the surface.
///
/// # Errors
/// [`Failure`]; [`Failure::Unsupported`] in the plane and for domains that are no surfaces.
pub fn remesh<P: Space, M: Machine<P> + Sync>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    feature_angle: f64,
    options: Options,
    machine: &mut M,
) -> Result<Generated<P>, Failure<M::Error>> {
    if P::DIM != 3 || domain.kind != crate::input::Kind::Surface {
        return Err(Failure::Unsupported("only closed surfaces of space can be remeshed"));
    }
    let features = SurfaceFeatures::new(domain, feature_angle);
    let mut generator = Generator::new(domain, rules, machine);
    generator.vertices = super::Vertices::default();
    refinement::Refinement::new(generator, &features, options).run()
}

#[cfg(test)]
mod tests;
