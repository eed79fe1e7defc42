//! Thin sheets.
//!
//! **Statement.** At a place of the surface a *sheet* is thin if a segment along the normal, to either side, meets the surface
//! again. Let the dual edge of a face start at s on one side of a plane sheet of thickness t, in a ball of radius r, and let
//! balls on the other side have radii of at most R: if `R^2 <= r^2 + t^2` some corner there is nearer to every place of the
//! other side than the face's, so that the dual edge ends within the sheet. Radii of at most t, on both sides,
//! make it so. Beside ridges two sheets meet and t falls to nothing: there it is the chords that keep them apart
//! ([`super::edge_recovery`]).
//!
//! **Departures.** Balls below a part of f are not divided for it: a sheet that is thinner is left to be told apart by
//! what the boundary is found to be: a manifold with the surface's Euler characteristic, or else the part is halved.

use septet_geometry::point::dist2;

use super::refinement::Refinement;
use super::restricted::Face;
use crate::distance::closest_on_segment;
use crate::generate::machine::Machine;
use crate::space::Space;

/// Balls are not divided below this part of f for a sheet's sake; where the boundary has other handles than the surface not below
/// half of it, a quarter and so on down to [`THINNEST`].
pub(super) const THIN: f64 = 0.125;
pub(super) const THINNEST: f64 = THIN / 16.0;

impl<P: Space, M: Machine<P> + Sync> Refinement<'_, P, M> {
    /// Is a face's ball wider than the sheet that it lies on is thick?
    pub(super) fn is_wide(&self, face: &Face<P>) -> bool {
        let (at, radius) = (face.place.at, face.radius);
        if radius <= self.thinnest * (self.generator.rules.size)(at) {
            return false;
        }
        let across = face.place.normal * (radius / face.place.normal.norm2().sqrt());
        let found = [across, across * -1.0].map(|d| self.surface.again(at, d));
        let Some(thickness2) = found.into_iter().flatten().min_by(f64::total_cmp) else { return false };
        !self.is_beside_ridge(at, thickness2)
    }

    /// Is a ridge as near as a squared distance?
    fn is_beside_ridge(&self, at: P, limit2: f64) -> bool {
        let ends = |c: u32| self.chords[c as usize].ends.map(|v| self.generator.vertices.points[v as usize]);
        let mut beside = false;
        let distance = |c: u32| {
            let [p, q] = ends(c);
            dist2(closest_on_segment(p, q, at), at)
        };
        self.chord_tree.nearest(at, distance, |_, d2| {
            beside = d2 <= limit2;
            false
        });
        beside
    }
}
