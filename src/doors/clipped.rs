//! The Voronoi diagram in a box over flat arrays.

use septet_queries::{Dimension, Ragged};

use crate::call::Call;
use crate::failure::Failure;
use crate::rows::one;
use crate::sites::Query;
use crate::triangulated::{Triangulated, either};

/// The Voronoi diagram in a box.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Clipped {
    /// The corners of the parts of all cells in the box, as many coordinates each as a point has.
    pub vertices: Vec<f64>,
    /// The two points of each ridge, smaller first. Read as a signed number, `-1 - k` is side `k` of the box: 0 for the lower side of the
    /// first axis, 1 for its upper side, and so on. Sorted as signed numbers.
    pub points: Vec<u32>,
    /// The corners of each ridge, in order around it.
    pub corners: Ragged,
    /// The length or area of each ridge.
    pub areas: Vec<f64>,
}

impl<P: Dimension> From<septet_queries::Clipped<P>> for Clipped {
    fn from(of: septet_queries::Clipped<P>) -> Self {
        Clipped {
            vertices: bytemuck::cast_vec(of.vertices),
            points: of.points.into_flattened(),
            corners: of.corners,
            areas: of.areas,
        }
    }
}

impl Triangulated {
    /// Returns the Voronoi diagram in a box.
    ///
    /// # Errors
    /// Fails if the points do not span the space, if the box is empty, if a vertex lies outside of it, or if the call is
    /// cancelled.
    pub fn voronoi_in(&self, low: &[f64], high: &[f64], call: &Call) -> Result<Clipped, Failure> {
        either!(self.asked(Query::Ridges, call)?, t => {
            let (low, high) = (one(low)?, one(high)?);
            call.ask(|| t.voronoi_in(low, high).map(Clipped::from))
        })
    }
}
