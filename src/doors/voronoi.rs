//! Voronoi cells of a triangulation.

use septet_queries::{Ragged, Ridges};

use crate::call::Call;
use crate::failure::Failure;
use crate::rows::one;
use crate::triangulated::{Triangulated, either};

/// The lower and the upper corner of a box.
pub type Corners<'a> = (&'a [f64], &'a [f64]);

impl Triangulated {
    /// Returns the area or volume of the Voronoi cell of each point: infinite if it is unbounded, and 0 for a duplicate or skipped
    /// point. With a box, those of the parts in it, which add up to that of the box.
    ///
    /// # Errors
    /// Fails if the points do not span the space, if the box is empty, if a vertex lies outside of it, or if the call is
    /// cancelled.
    pub fn voronoi_volumes(&self, within: Option<Corners<'_>>, call: &Call) -> Result<Vec<f64>, Failure> {
        either!(self, t => match within {
            None => call.ask(|| t.voronoi_volumes()),
            Some((low, high)) => {
                let (low, high) = (one(low)?, one(high)?);
                call.ask(|| t.voronoi_volumes_in(low, high))
            }
        })
    }

    /// Returns the centroid of the Voronoi cell of each point, or of its part in a box: `columns` coordinates. Those of an
    /// unbounded cell and of a duplicate or skipped point are NaN.
    ///
    /// # Errors
    /// See [`Triangulated::voronoi_volumes`].
    pub fn voronoi_centroids(&self, within: Option<Corners<'_>>, call: &Call) -> Result<Vec<f64>, Failure> {
        either!(self, t => match within {
            None => call.ask(|| t.voronoi_centroids()).map(bytemuck::cast_vec),
            Some((low, high)) => {
                let (low, high) = (one(low)?, one(high)?);
                call.ask(|| t.voronoi_centroids_in(low, high)).map(bytemuck::cast_vec)
            }
        })
    }

    /// Returns the ridges of the Voronoi diagram. With a box, their areas are those of the parts in it.
    ///
    /// # Errors
    /// See [`Triangulated::voronoi_volumes`].
    pub fn ridges(&self, within: Option<Corners<'_>>, call: &Call) -> Result<Ridges, Failure> {
        either!(self, t => match within {
            None => call.ask(|| t.ridges()),
            Some((low, high)) => {
                let (low, high) = (one(low)?, one(high)?);
                call.ask(|| t.ridges_in(low, high))
            }
        })
    }

    /// Returns the Voronoi vertices of the cell of each point, as numbers of cells of the triangulation, ascending. The row of
    /// an unbounded cell starts with [`crate::NONE`]. The row of a duplicate or skipped point is empty.
    ///
    /// # Errors
    /// Fails if the points do not span the space, or if the call is cancelled.
    pub fn voronoi_regions(&self, call: &Call) -> Result<Ragged, Failure> {
        call.ask(|| either!(self, t => t.voronoi_regions()))
    }
}
