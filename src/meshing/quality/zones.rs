//! The location of circumcentres by their distance from features.
//!
//! **Statement.** A centre c in the domain is *near* its nearest feature if the distance is at most `zone` times
//! f(c), and *free* if the distance is larger. A centre that is not in the domain is *outside*. If the nearest
//! feature is farther than the circumradius, the path from c to a vertex of the cell meets no wall, so c is in the
//! domain like the cell. Otherwise, c is located exactly.
//!
//! **Work and depth.** One query for the nearest feature per cell, and an exact location for some cells.

use super::CentrePlace;
use crate::distance::Features;
use crate::domain::Domain;
use crate::space::Space;

/// The zones around the features of a domain.
pub struct Zones<'a, P: Space> {
    /// The domain.
    pub domain: &'a Domain<P>,
    /// Its features.
    pub features: &'a Features<P>,
    /// The size function f in scaled coordinates.
    pub size: &'a (dyn Fn(P) -> f64 + Sync),
    /// The width of a zone, relative to f.
    pub zone: f64,
}

impl<P: Space> Zones<'_, P> {
    /// Returns the location of a circumcentre with this circumradius.
    pub fn place(&self, centre: P, radius: f64) -> CentrePlace {
        let mut nearest = None;
        self.features.nearest(centre, |met| {
            nearest = Some(met);
            false
        });
        let inside = match nearest {
            Some(met) if met.distance <= radius * (1.0 + 1e-9) => self.domain.is_inside(centre),
            _ => true,
        };
        match nearest {
            _ if !inside => CentrePlace::Outside(nearest.map(|met| met.feature)),
            Some(met) if met.distance <= self.zone * (self.size)(centre) => CentrePlace::Near(met.feature),
            _ => CentrePlace::Free,
        }
    }
}
