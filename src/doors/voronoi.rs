//! Voronoi cells of a triangulation, and power cells of points with weights.

use glam::{DVec2, DVec3};
use septet_core::Door;
use septet_queries::{
    Dimension, NONE, QueryError, Ragged, Region, Ridges, power_cells, power_centroids, power_volumes,
};

use crate::call::Call;
use crate::failure::Failure;
use crate::rows::{Rows, one};
use crate::sites::Query;
use crate::triangulated::{Triangulated, either, weighted};

/// The lower and the upper corner of a box.
pub type Corners<'a> = (&'a [f64], &'a [f64]);

/// The corners of power cells.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PowerCells {
    /// The corners of all cells, one cell after the other: as many coordinates each as a point has.
    pub corners: Vec<f64>,
    /// The corners of the cell of each point: in the plane counter-clockwise. A point that is not a vertex has no corners.
    pub cells: Ragged,
}

/// Evaluates an expression for the sites, the run and the region of a power diagram.
macro_rules! power {
    ($self:ident, $within:ident, $call:ident, |$sites:ident, $run:ident, $region:ident| $value:expr) => {{
        Query::PowerCells.check($self.sites(), $call.door)?;
        let points = $self.points();
        let Some($run) = $self.run_with_cells() else { return Err(Failure::usage("the run has no cells")) };
        let weights = $self.sites().weights.as_deref();
        match Rows::of(&points, $self.columns())? {
            Rows::Plane(points) => {
                let ($sites, $region) =
                    (&weighted(points, weights)[..], $self.region::<DVec2>($within, $call)?);
                $call.ask(|| $value)
            }
            Rows::Space(points) => {
                let ($sites, $region) =
                    (&weighted(points, weights)[..], $self.region::<DVec3>($within, $call)?);
                $call.ask(|| $value)
            }
        }
    }};
}

impl Triangulated {
    /// Returns the region of a power diagram.
    fn region<P: Dimension>(
        &self,
        within: Option<Corners<'_>>,
        call: &Call,
    ) -> Result<Region<'_, P>, Failure> {
        let corners =
            within.map(|(low, high)| Ok::<_, Failure>((one::<P>(low)?, one::<P>(high)?))).transpose()?;
        let (spelled, omitted) = match call.door {
            Door::C => ("low and high", "pass NULL for low and high"),
            _ => ("box=(low, high)", "omit box=(low, high)"),
        };
        let usage = |text: String| Err(Failure::usage(text));
        let periodic = self.sites().periodic.as_ref();
        let is_closed = periodic.is_some_and(|periodic| periodic.lengths.iter().all(Option::is_some));
        match (periodic, corners) {
            (Some(_), Some(_)) if is_closed => {
                usage(format!("the periodic box has no boundary, so the cells have no other box; {omitted}"))
            }
            (Some(periodic), None) if is_closed => Ok(Region::of_periods(periodic)),
            (Some(periodic), Some((low, high))) => Ok(Region::of_periods(periodic).between(low, high)),
            (None, Some((low, high))) => Ok(Region::of_box(low, high)),
            (Some(_), None) => usage(format!(
                "the cells need a box along the axes that are not periodic; pass {spelled}, whose ends along periodic axes are not used"
            )),
            (None, None) => usage(format!("the cells of points with weights need a box; pass {spelled}")),
        }
    }

    /// Returns the corners of the power cell of each point in a box, or in the periodic box. Points of equal weights, or without
    /// weights, have their Voronoi cells. In a periodic box, a cell lies around its point.
    ///
    /// # Errors
    /// See [`Triangulated::voronoi_volumes`]. Fails if the points have neither weights nor a periodic box, and if there are more corners
    /// than 32-bit indices can address.
    pub fn power_cells(&self, within: Option<Corners<'_>>, call: &Call) -> Result<PowerCells, Failure> {
        let mut made = PowerCells::default();
        power!(self, within, call, |sites, run, region| {
            for cell in power_cells(sites, run, region)? {
                let (first, end) = (made.cells.indices.len(), made.cells.indices.len() + cell.corners.len());
                if end >= NONE as usize {
                    return Err(QueryError::TooMany { what: "corners", count: end });
                }
                made.cells.indices.extend(first as u32..end as u32);
                made.cells.offsets.push(made.cells.indices.len() as u64);
                made.corners.extend_from_slice(bytemuck::cast_slice(&cell.corners));
            }
            Ok(())
        })?;
        Ok(made)
    }

    /// Returns the area or volume of the Voronoi cell of each point: infinite if it is unbounded, and 0 for a duplicate, skipped or
    /// hidden point. With a box, those of the parts in it, which add up to that of the box. Those of points with weights, which need a
    /// box, are power cells. Those in a periodic box add up to it.
    ///
    /// # Errors
    /// Fails if the points do not span the space, or if the call is cancelled. Fails if the box is empty, if a vertex lies outside of
    /// it, if points with weights have no box, or if points in a periodic box have another one.
    pub fn voronoi_volumes(&self, within: Option<Corners<'_>>, call: &Call) -> Result<Vec<f64>, Failure> {
        if !self.sites().are_plain() {
            return power!(self, within, call, |sites, run, region| power_volumes(sites, run, region));
        }
        either!(self.asked(Query::PowerCells, call)?, t => match within {
            None => call.ask(|| t.voronoi_volumes()),
            Some((low, high)) => {
                let (low, high) = (one(low)?, one(high)?);
                call.ask(|| t.voronoi_volumes_in(low, high))
            }
        })
    }

    /// Returns the centroid of the Voronoi cell of each point, or of its part in a box: `columns` coordinates. Those of an
    /// unbounded cell and of a duplicate, skipped or hidden point are NaN. In a periodic box, a cell lies around its point.
    ///
    /// # Errors
    /// See [`Triangulated::voronoi_volumes`].
    pub fn voronoi_centroids(&self, within: Option<Corners<'_>>, call: &Call) -> Result<Vec<f64>, Failure> {
        if !self.sites().are_plain() {
            return power!(self, within, call, |sites, run, region| power_centroids(sites, run, region)
                .map(bytemuck::cast_vec));
        }
        either!(self.asked(Query::PowerCells, call)?, t => match within {
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
        either!(self.asked(Query::Ridges, call)?, t => match within {
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
        either!(self.asked(Query::Ridges, call)?, t => call.ask(|| t.voronoi_regions()))
    }
}
