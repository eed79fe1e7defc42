//! Thin sheets.
//!
//! **Statement.** The surface has a *thin sheet* at a point if a segment along the normal there, to either side,
//! meets the surface again. Let the dual edge of a face start at s on one side of a plane sheet of thickness t, with
//! a surface ball of radius r. Let the balls on the other side have radii of at most R. If `R^2 <= r^2 + t^2`, every
//! point of the other side is nearer to some vertex there than to the vertices of the face. The dual edge then ends
//! inside the sheet. Radii of at most t on both sides ensure this. Near ridges, two sheets meet and t tends to zero.
//! There, the chords separate the sheets ([`super::edge_recovery`]).
//!
//! **Departures.** Balls below a fraction of f are not divided for thin sheets. The topology of the boundary decides
//! whether thinner sheets are separated: it must be a manifold with the Euler characteristic of the surface. Otherwise
//! the fraction is halved.

use septet_geometry::point::dist2;

use super::refinement::Refinement;
use super::restricted::RestrictedFace;
use crate::distance::closest_on_segment;
use crate::generate::machine::MeshMachine;
use crate::space::Space;

/// The radius, relative to f, below which balls are not divided for thin sheets. If the boundary has a wrong number of
/// handles, it is halved repeatedly, down to [`THINNEST`].
pub(super) const THIN: f64 = 0.125;
pub(super) const THINNEST: f64 = THIN / 16.0;

impl<P: Space, M: MeshMachine<P> + Sync> Refinement<'_, P, M> {
    /// Returns `true` if the radius of a face's ball exceeds the thickness of its sheet.
    pub(super) fn is_wide(&self, face: &RestrictedFace<P>) -> bool {
        let (at, radius) = (face.place.at, face.radius);
        if radius <= self.thinnest * self.generator.rules.size.at(at) {
            return false;
        }
        let across = face.place.normal * (radius / face.place.normal.norm2().sqrt());
        let found = [across, across * -1.0].map(|d| self.surface.again(at, d));
        let Some(thickness2) = found.into_iter().flatten().min_by(f64::total_cmp) else { return false };
        !self.is_near_ridge(at, thickness2)
    }

    /// Returns `true` if the squared distance to the nearest ridge is at most `limit2`.
    fn is_near_ridge(&self, at: P, limit2: f64) -> bool {
        let ends = |c: u32| self.chords[c as usize].ends.map(|v| self.generator.vertices.points[v as usize]);
        let mut near = false;
        let distance = |c: u32| {
            let [p, q] = ends(c);
            dist2(closest_on_segment(p, q, at), at)
        };
        self.chord_tree.nearest(at, distance, |_, d2| {
            near = d2 <= limit2;
            false
        });
        near
    }
}
