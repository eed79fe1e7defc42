//! The unit square and the unit cube as domains.

use glam::{DVec2, DVec3};
use septet_meshing::check;
use septet_meshing::defect::Defect;
use septet_meshing::domain::Domain;
use septet_meshing::facet::Triangulate;
use septet_meshing::input::{DomainKind, Input, InputFacet, InputSegment};

/// A dimension, with its unit square or cube as a domain.
pub trait Unit: Triangulate {
    /// Returns the cube in the form in which a file would describe it.
    fn input() -> Input<Self>;

    /// Returns the cube as a domain, in unscaled coordinates.
    ///
    /// # Errors
    /// Never fails, because the input has no defect.
    fn domain() -> Result<Domain<Self>, Vec<Defect>> {
        let domain = check(&Self::input())?;
        debug_assert_eq!(domain.simplices.frame.exponent, 0);
        Ok(domain)
    }
}

impl Unit for DVec2 {
    fn input() -> Input<Self> {
        let corners = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(DVec2::from);
        let mut input = Input::new(DomainKind::Complex, corners.to_vec());
        input.segments = (0..4).map(|i| InputSegment { ends: [i, (i + 1) % 4], marker: 0 }).collect();
        input
    }
}

impl Unit for DVec3 {
    fn input() -> Input<Self> {
        let bit = |i: u32, k: u32| f64::from(i >> k & 1);
        let corners = (0..8).map(|i| DVec3::new(bit(i, 0), bit(i, 1), bit(i, 2))).collect();
        let mut input = Input::new(DomainKind::Complex, corners);
        for square in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let polygons = vec![square.to_vec()];
            input.facets.push(InputFacet { polygons, holes: Vec::new(), marker: 0 });
        }
        input
    }
}
