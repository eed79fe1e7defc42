//! Where circumcentres lie, by their distance from features.
//!
//! **Statement.** A centre c is *near* a feature if it is in the domain and no farther from that feature, the nearest
//! one, than `zone` times f(c); *free* if it is in the domain and farther; else *outside*. If the nearest feature
//! is farther than the circumradius, the way from c to a vertex meets no wall, so c is in the domain as the cell
//! is; only else is it located.
//!
//! **Work and depth.** A query for the nearest feature a cell, and an exact location for some.

use super::Place;
use crate::distance::Features;
use crate::domain::Domain;
use crate::space::Space;

/// The protected zones of a domain.
pub struct Zones<'a, P: Space> {
    /// The domain.
    pub domain: &'a Domain<P>,
    /// Its features.
    pub features: &'a Features<P>,
    /// f in scaled coordinates.
    pub size: &'a dyn Fn(P) -> f64,
    /// The width of a zone over f.
    pub zone: f64,
}

impl<P: Space> Zones<'_, P> {
    /// Where a circumcentre of this circumradius lies.
    pub fn place(&self, centre: P, radius: f64) -> Place {
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
            _ if !inside => Place::Outside(nearest.map(|met| met.feature)),
            Some(met) if met.distance <= self.zone * (self.size)(centre) => Place::Near(met.feature),
            _ => Place::Free,
        }
    }
}
