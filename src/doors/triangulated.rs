//! A triangulation in the plane or in space.

use bytemuck::cast_slice;
use glam::{DVec2, DVec3};
use septet_core::{Code, Error, Outcome, triangulate};
use septet_geometry::coordinates::Coordinates;
use septet_queries::{Dimension, Ragged, Tessellation};

use crate::call::{Call, Request};
use crate::failure::Failure;
use crate::rows::Rows;

/// A triangulation of either dimension.
#[derive(Clone, Debug)]
pub(crate) enum Either {
    Plane(Tessellation<DVec2>),
    Space(Tessellation<DVec3>),
}

/// Evaluates an expression for the triangulation of either dimension.
macro_rules! either {
    ($of:expr, $t:ident => $value:expr) => {
        match &$of.either {
            $crate::triangulated::Either::Plane($t) => $value,
            $crate::triangulated::Either::Space($t) => $value,
        }
    };
}
pub(crate) use either;

/// An immutable triangulation of points with 2 or 3 coordinates. Threads may share it.
///
/// Cells are rows of `columns + 1` vertices: positively oriented, with the smallest vertex first, and sorted.
#[derive(Clone, Debug)]
pub struct Triangulated {
    pub(crate) either: Either,
    skipped: Vec<u32>,
    run: Option<Box<Outcome>>,
}

impl Triangulated {
    /// Triangulates rows of `columns` coordinates, 2 or 3. There may be no points, and they may be flat: then there are no cells.
    ///
    /// # Errors
    /// Fails if there are not 2 or 3 columns, or if the last row is not whole. Fails if a point is not finite and such points are not
    /// skipped, or if the digits of the points spread too far. Fails above the limit of memory, and if the call is cancelled.
    pub fn new(points: &[f64], columns: usize, request: &Request) -> Result<Self, Failure> {
        match Rows::of(points, columns)? {
            Rows::Plane(points) => Self::made(points, request, Either::Plane),
            Rows::Space(points) => Self::made(points, request, Either::Space),
        }
    }

    fn made<P: Dimension + Coordinates>(
        points: &[P],
        request: &Request,
        wrap: fn(Tessellation<P>) -> Either,
    ) -> Result<Self, Failure> {
        let door = request.call.door;
        let failed = |error: &Error| Failure::of_run(error, door);
        let work = || {
            let run = triangulate(points, &request.spec()).map_err(|error| failed(&error))?;
            let made = Tessellation::new(points, &run).map_err(|error| Failure::of_query(&error, door))?;
            Ok::<_, Failure>((made, run))
        };
        let (made, run) = request.call.within(work)??;
        Ok(Self::with_run(wrap(made), run))
    }

    /// Takes the triangulation of the points that a run made. It keeps the run without its cells.
    ///
    /// # Errors
    /// Fails if the points are not those of the run, if the run did not end, if it has weights or a periodic box, and if the call
    /// is cancelled.
    pub fn of_run(points: &[f64], columns: usize, run: Outcome, call: &Call) -> Result<Self, Failure> {
        let either = match Rows::of(points, columns)? {
            Rows::Plane(points) => Either::Plane(call.ask(|| Tessellation::new(points, &run))?),
            Rows::Space(points) => Either::Space(call.ask(|| Tessellation::new(points, &run))?),
        };
        Ok(Self::with_run(either, run))
    }

    fn with_run(either: Either, mut run: Outcome) -> Self {
        run.shares = Vec::new();
        let skipped = run.left_out.refused.iter().map(|&point| point as u32).collect();
        Triangulated { either, skipped, run: Some(Box::new(run)) }
    }

    /// Takes a triangulation from its points and cells, such as those of a pickle. `cells` are the rows that
    /// [`Triangulated::cells`] returns. Points that are not finite count as skipped. The points are triangulated again, because no
    /// check of the cells takes much less time.
    ///
    /// # Errors
    /// Fails if the cells are not the canonical rows of the triangulation of the points.
    pub fn of_rows(points: &[f64], columns: usize, cells: &[u32], call: &Call) -> Result<Self, Failure> {
        if !cells.len().is_multiple_of(columns + 1) {
            let message = format!("{} vertices are not whole cells of {} vertices", cells.len(), columns + 1);
            return Err(Failure::usage(message));
        }
        let request = Request { skip_invalid: true, ..Request::new(call.clone()) };
        let made = Self::new(points, columns, &request)?;
        if made.cells() != cells {
            return Err(Failure::new(Code::Input, "the cells are not those of the points"));
        }
        Ok(Triangulated { run: None, ..made })
    }

    /// Returns the number of coordinates: 2 or 3.
    pub fn columns(&self) -> usize {
        match self.either {
            Either::Plane(_) => 2,
            Either::Space(_) => 3,
        }
    }

    /// Returns the dimension of the affine hull of the points, from -1 for no points. Below [`Triangulated::columns`], there
    /// are no cells.
    pub fn dimension(&self) -> isize {
        either!(self, t => t.dimension())
    }

    /// Returns the number of points, duplicates and skipped ones included.
    pub fn len(&self) -> usize {
        either!(self, t => t.len())
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        either!(self, t => t.cells().len())
    }

    /// Returns the run without its cells, with counts and times. A triangulation from rows lacks it.
    pub fn run(&self) -> Option<&Outcome> {
        self.run.as_deref()
    }

    /// Returns the rows of points: `columns` coordinates each. A coordinate that was -0.0 is 0.0.
    pub fn points(&self) -> Vec<f64> {
        either!(self, t => bytemuck::cast_vec(t.points()))
    }

    /// Returns the cells: `columns + 1` vertices each.
    pub fn cells(&self) -> &[u32] {
        either!(self, t => cast_slice(t.cells()))
    }

    /// Returns the cell across the facet opposite each vertex of each cell, or [`crate::NONE`] if the facet is on the hull.
    pub fn neighbours(&self) -> &[u32] {
        either!(self, t => cast_slice(t.neighbours()))
    }

    /// Returns each coincident point with the first point at its place, which is the vertex: two numbers a row, ascending.
    pub fn duplicates(&self) -> &[u32] {
        either!(self, t => t.duplicates().as_flattened())
    }

    /// Returns the points that were dropped because they are not finite, ascending.
    pub fn skipped(&self) -> &[u32] {
        &self.skipped
    }

    /// Returns the smallest cell of each point: that of its vertex for a duplicate, or [`crate::NONE`].
    pub fn vertex_cells(&self) -> Vec<u32> {
        either!(self, t => t.vertex_cells())
    }

    /// Returns the facets of the convex hull, `columns` vertices each: counter-clockwise from outside, sorted.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn hull(&self, call: &Call) -> Result<Vec<u32>, Failure> {
        call.within(|| either!(self, t => cast_slice(&t.hull()).to_vec()))
    }

    /// Returns the edges: two vertices each, smaller first, sorted.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn edges(&self, call: &Call) -> Result<Vec<u32>, Failure> {
        call.within(|| either!(self, t => t.edges().into_flattened()))
    }

    /// Returns the vertices that an edge joins to each point, ascending. The row of a duplicate is empty.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn vertex_neighbours(&self, call: &Call) -> Result<Ragged, Failure> {
        call.within(|| either!(self, t => t.vertex_neighbours()))
    }

    /// Returns the area or volume of each cell.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn volumes(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        call.within(|| either!(self, t => t.cell_volumes()))
    }

    /// Returns the circumcentre of each cell: `columns` coordinates.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn circumcentres(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        call.within(|| either!(self, t => bytemuck::cast_vec(t.circumcentres())))
    }

    /// Returns the circumradius of each cell.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn circumradii(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        call.within(|| either!(self, t => t.circumradii()))
    }

    /// Returns the affine maps to barycentric coordinates, `columns + 1` rows of `columns` numbers for each cell. Let `r` be the
    /// last row. The coordinates of `x` but the last are the products of the other rows with `x - r`.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn transforms(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        call.within(|| either!(self, t => bytemuck::cast_vec(t.transforms())))
    }

    /// Returns the gradients of the linear interpolants in each cell: `columns` rows of `values_columns` numbers, given
    /// `values_columns` values for each point.
    ///
    /// # Errors
    /// Fails if the number of values does not fit, or if the call is cancelled.
    pub fn gradients(&self, values: &[f64], values_columns: usize, call: &Call) -> Result<Vec<f64>, Failure> {
        call.ask(|| either!(self, t => t.gradients(values, values_columns)))
    }
}
