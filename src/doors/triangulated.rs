//! A triangulation in the plane or in space.

use bytemuck::{Pod, cast_slice};
use glam::{DVec2, DVec3};
use septet_core::result::unfolded::Unfolded;
use septet_core::{Code, Error, Outcome, Spec, cores, simulate, triangulate};
use septet_geometry::site::Weighted;
use septet_queries::{Dimension, QueryError, Ragged, Tessellation};

use crate::call::{Call, Request};
use crate::failure::Failure;
use crate::folded::Folded;
use crate::rows::Rows;
use crate::sites::{Query, Sites};

/// A triangulation of either dimension.
#[derive(Clone, Debug)]
pub(crate) enum Either {
    Plane(Tessellation<DVec2>),
    Space(Tessellation<DVec3>),
}

/// The cells of a triangulation.
#[derive(Clone, Debug)]
enum Form {
    Whole(Either),
    /// In a periodic box.
    Folded(Folded),
}

/// Evaluates an expression for the triangulation of either dimension.
macro_rules! either {
    ($of:expr, $t:ident => $value:expr) => {
        match $of {
            $crate::triangulated::Either::Plane($t) => $value,
            $crate::triangulated::Either::Space($t) => $value,
        }
    };
}
pub(crate) use either;

/// Evaluates an expression for a tessellation of either dimension, or for cells in a periodic box.
macro_rules! form {
    ($of:expr, $t:ident => $value:expr, $folded:ident => $other:expr) => {
        match &$of.form {
            Form::Whole(Either::Plane($t)) => $value,
            Form::Whole(Either::Space($t)) => $value,
            Form::Folded($folded) => $other,
        }
    };
}

/// An immutable triangulation of points with 2 or 3 coordinates. Threads may share it.
///
/// Cells are rows of `columns + 1` vertices: positively oriented, with the smallest vertex first, and sorted. Points may have
/// weights, which hide some of them, or lie in a periodic box, whose cells have offsets.
#[derive(Clone, Debug)]
pub struct Triangulated {
    form: Form,
    sites: Sites,
    skipped: Vec<u32>,
    hidden: Vec<u32>,
    /// Numbers of the caller that the tessellation does not keep, by their positions: those of skipped points, and -0.0.
    given: Vec<(usize, f64)>,
    /// The run. With weights or a periodic box, it has its cells.
    run: Option<Box<Outcome>>,
    /// Whether the run is that of the caller.
    is_counted: bool,
}

/// Joins points with their weights, or with weights of 0.
pub(crate) fn weighted<P: Dimension + Pod>(points: &[P], weights: Option<&[f64]>) -> Vec<Weighted<P>> {
    let weight = |at: usize| weights.map_or(0.0, |weights| weights[at]);
    points.iter().enumerate().map(|(at, &point)| Weighted::new(point, weight(at))).collect()
}

impl Form {
    /// Takes the cells of a run.
    fn of(points: &[f64], columns: usize, run: &Outcome, request: &Request) -> Result<Self, Failure> {
        let sites = &request.sites;
        let failed = |error: &QueryError| Failure::of_query(error, request.call.door);
        if sites.periodic.is_some() {
            return Folded::of(points, columns, run).map(Form::Folded);
        }
        if sites.weights.is_some() {
            // The volumes of power cells need the rows of the run, which loses its shares.
            run.cells();
        }
        Ok(Form::Whole(match Rows::of(points, columns)? {
            Rows::Plane(points) => Either::Plane(taken(points, run, sites).map_err(|error| failed(&error))?),
            Rows::Space(points) => Either::Space(taken(points, run, sites).map_err(|error| failed(&error))?),
        }))
    }
}

/// Takes the tessellation of a run.
fn taken<P: Dimension>(points: &[P], run: &Outcome, sites: &Sites) -> Result<Tessellation<P>, QueryError> {
    if sites.weights.is_some() { Tessellation::regular(points, run) } else { Tessellation::new(points, run) }
}

/// Runs the machine over points of either dimension, with their weights if they have some.
macro_rules! run_of {
    ($call:path, $rows:expr, $weights:expr, $spec:expr) => {
        match ($rows, $weights) {
            (Rows::Plane(points), None) => $call(points, $spec),
            (Rows::Space(points), None) => $call(points, $spec),
            (Rows::Plane(points), weights) => $call(&$crate::triangulated::weighted(points, weights), $spec),
            (Rows::Space(points), weights) => $call(&$crate::triangulated::weighted(points, weights), $spec),
        }
    };
}

/// Checks weights, and runs the machine.
fn ran(
    points: &[f64],
    columns: usize,
    request: &Request,
    run: impl FnOnce(Rows<'_>, Option<&[f64]>) -> Result<Outcome, Error>,
) -> Result<Outcome, Failure> {
    let (door, sites) = (request.call.door, &request.sites);
    let rows = Rows::of(points, columns)?;
    sites.check(points.len() / columns, request.skip_invalid, door)?;
    run(rows, sites.weights.as_deref()).map_err(|error| Failure::of_run(&error, door))
}

/// Simulates the recursion of the paper over rows of `columns` coordinates, 2 or 3. `spec` has the options of the run, with the
/// periodic box; `request` has the weights and the words of failures.
///
/// # Errors
/// As [`Triangulated::new`].
pub fn simulated(points: &[f64], columns: usize, request: &Request, spec: &Spec) -> Result<Outcome, Failure> {
    request
        .call
        .within(|| ran(points, columns, request, |rows, weights| run_of!(simulate, rows, weights, spec)))?
}

impl Triangulated {
    /// Triangulates rows of `columns` coordinates, 2 or 3. There may be no points, and they may be flat: then there are no cells.
    ///
    /// # Errors
    /// Fails if there are not 2 or 3 columns, or if the last row is not whole. Fails if a point is not finite and such points are not
    /// skipped, or if the digits of the points spread too far. Fails if there is not one weight for each point, and if a point lies
    /// outside of a periodic box. Fails above the limit of memory, and if the call is cancelled.
    pub fn new(points: &[f64], columns: usize, request: &Request) -> Result<Self, Failure> {
        let made = request.call.within(|| {
            let run = ran(points, columns, request, |rows, weights| {
                run_of!(triangulate, rows, weights, &request.spec())
            })?;
            Ok::<_, Failure>((Form::of(points, columns, &run, request)?, run))
        });
        let (form, run) = made??;
        Ok(Self::with_run(form, points, run, request.sites.clone()))
    }

    /// Takes the triangulation of the points that a run made. `request` must have the weights and the box of the run, which the run does not
    /// keep. Without them, the run is kept without its cells.
    ///
    /// # Errors
    /// Fails if the number of the points is not that of the run, if the run did not end, if there is not one weight for each point, if
    /// only one of the run and the request has a periodic box, if the box has another dimension, and if the call is cancelled.
    pub fn of_run(points: &[f64], columns: usize, run: Outcome, request: &Request) -> Result<Self, Failure> {
        let (door, sites) = (request.call.door, &request.sites);
        Rows::of(points, columns)?;
        let (given, counted) = (points.len() / columns, run.points.input);
        sites.check(given, request.skip_invalid, door)?;
        if run.space != columns || given as u64 != counted {
            return Err(Failure::of_query(&QueryError::OtherPoints { given, run: counted }, door));
        }
        let has_other_box = match &sites.periodic {
            Some(periodic) => run.kept.periodic.is_none() || periodic.lengths.len() != columns,
            None => run.kept.periodic.is_some(),
        };
        if has_other_box {
            return Err(Failure::usage("the periodic box is not that of the run; pass the box of the run"));
        }
        let form = request.call.within(|| Form::of(points, columns, &run, request))??;
        Ok(Self::with_run(form, points, run, request.sites.clone()))
    }

    fn with_run(form: Form, points: &[f64], mut run: Outcome, sites: Sites) -> Self {
        run.shares = Vec::new();
        let columns = run.space;
        let rows = |rows: &[u64]| rows.iter().map(|&point| point as u32).collect::<Vec<u32>>();
        let (skipped, hidden) = (rows(&run.left_out.refused), rows(&run.left_out.hidden));
        let is_zero = |x: &f64| *x == 0.0 && x.is_sign_negative();
        let mut given: Vec<(usize, f64)> =
            points.iter().copied().enumerate().filter(|(_, x)| is_zero(x)).collect();
        for at in skipped.iter().flat_map(|&row| row as usize * columns..(row as usize + 1) * columns) {
            given.push((at, points[at]));
        }
        Triangulated { form, sites, skipped, hidden, given, run: Some(Box::new(run)), is_counted: true }
    }

    /// Takes a triangulation from its points and cells, such as those of a pickle. `cells` are the rows that
    /// [`Triangulated::cells`] returns. Points that are not finite count as skipped. The points are triangulated again, because no
    /// check of the cells takes much less time.
    ///
    /// # Errors
    /// Fails if the cells are not the canonical rows of the triangulation of the points.
    pub fn of_rows(
        points: &[f64],
        columns: usize,
        cells: &[u32],
        sites: Sites,
        call: &Call,
    ) -> Result<Self, Failure> {
        if !cells.len().is_multiple_of(columns + 1) {
            let message = format!("{} vertices are not whole cells of {} vertices", cells.len(), columns + 1);
            return Err(Failure::usage(message));
        }
        let request = Request { skip_invalid: true, sites, ..Request::new(call.clone()) };
        let mut made = Self::new(points, columns, &request)?;
        if made.cells() != cells {
            return Err(Failure::new(Code::Input, "the cells are not those of the points"));
        }
        if made.sites.are_plain() {
            made.run = None;
        }
        Ok(Triangulated { is_counted: false, ..made })
    }

    /// Returns the tessellation for a query that has an answer.
    ///
    /// # Errors
    /// Fails if the query has no answer with these weights or in this box.
    pub(crate) fn asked(&self, query: Query, call: &Call) -> Result<&Either, Failure> {
        query.check(&self.sites, call.door)?;
        match &self.form {
            Form::Whole(either) => Ok(either),
            Form::Folded(_) => Err(Failure::usage("a periodic box has no such cells")),
        }
    }

    /// Returns the weights and the periodic box of the points.
    pub fn sites(&self) -> &Sites {
        &self.sites
    }

    /// Returns the run with its cells, which points with weights or in a periodic box have. In a box, it makes the rows of the cells
    /// each time.
    pub(crate) fn run_with_cells(&self) -> Option<&Outcome> {
        self.run.as_deref().filter(|_| !self.sites.are_plain())
    }

    /// Returns the points that weights hide, ascending. They are not vertices.
    pub fn hidden(&self) -> &[u32] {
        &self.hidden
    }

    /// Returns the offset of each vertex of each cell in a periodic box: `columns` whole numbers. The vertex lies at its point plus the
    /// offset times the lengths of the box. `None` without a box.
    pub fn offsets(&self) -> Option<&[i32]> {
        self.folded().map(|folded| &folded.offsets[..])
    }

    /// Whether the cells are a simplicial complex. In a periodic box, they are not if a point is joined to its own image or twice to
    /// another point.
    pub fn is_simplicial(&self) -> bool {
        self.folded().is_none_or(|folded| folded.is_simplicial)
    }

    /// Returns the smallest number of boxes along each axis whose triangulation is a simplicial complex: from 1 to 3. `None` without a
    /// periodic box.
    pub fn sheets(&self) -> Option<&[u32]> {
        self.folded().map(|folded| &folded.sheets[..])
    }

    /// Returns the cells in a periodic box with the images of points that are vertices as points of their own, for pictures. `None`
    /// without a box.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn unfolded(&self, call: &Call) -> Result<Option<Unfolded>, Failure> {
        call.within(|| {
            let (run, periodic) = (self.run_with_cells()?, self.sites.periodic.as_ref()?);
            let part = run.kept.periodic.as_ref()?;
            let cells = cores::map(self.cells(), |&v| u64::from(v));
            Some(Unfolded::of((&cells, part), &self.points(), periodic))
        })
    }

    fn folded(&self) -> Option<&Folded> {
        match &self.form {
            Form::Whole(_) => None,
            Form::Folded(folded) => Some(folded),
        }
    }

    /// Returns the number of coordinates: 2 or 3.
    pub fn columns(&self) -> usize {
        match &self.form {
            Form::Whole(Either::Plane(_)) => 2,
            Form::Whole(Either::Space(_)) => 3,
            Form::Folded(folded) => folded.columns,
        }
    }

    /// Returns the dimension of the affine hull of the points, from -1 for no points. Below [`Triangulated::columns`], there
    /// are no cells.
    pub fn dimension(&self) -> isize {
        form!(self, t => t.dimension(), folded => folded.dimension)
    }

    /// Returns the number of points, duplicates and skipped ones included.
    pub fn len(&self) -> usize {
        form!(self, t => t.len(), folded => folded.points.len() / folded.columns)
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells().len() / (self.columns() + 1)
    }

    /// Returns the run without its cells, with counts and times. A triangulation from rows lacks it.
    pub fn run(&self) -> Option<&Outcome> {
        self.run.as_deref().filter(|_| self.is_counted)
    }

    /// Returns the rows of points, as they were given: `columns` coordinates each.
    pub fn points(&self) -> Vec<f64> {
        let mut points: Vec<f64> =
            form!(self, t => bytemuck::cast_vec(t.points()), folded => folded.points.clone());
        self.given.iter().for_each(|&(at, x)| points[at] = x);
        points
    }

    /// Returns the cells: `columns + 1` vertices each.
    pub fn cells(&self) -> &[u32] {
        form!(self, t => cast_slice(t.cells()), folded => &folded.cells)
    }

    /// Returns the cell across the facet opposite each vertex of each cell, or [`crate::NONE`] if the facet is on the hull.
    pub fn neighbours(&self) -> &[u32] {
        form!(self, t => cast_slice(t.neighbours()), folded => &folded.neighbours)
    }

    /// Returns each coincident point with the first point at its place, which is the vertex: two numbers a row, ascending. With weights, it
    /// is the first of the heaviest ones, and the points with less weight are hidden. It is not a vertex if others hide it.
    pub fn duplicates(&self) -> &[u32] {
        form!(self, t => t.duplicates(), folded => &folded.duplicates).as_flattened()
    }

    /// Returns the points that were dropped because they are not finite, ascending.
    pub fn skipped(&self) -> &[u32] {
        &self.skipped
    }

    /// Returns the smallest cell of each point: that of its vertex for a duplicate, or [`crate::NONE`] if it has none.
    pub fn vertex_cells(&self) -> Vec<u32> {
        form!(self, t => t.vertex_cells(), folded => folded.vertex_cells())
    }

    /// Returns the facets of the convex hull, `columns` vertices each: counter-clockwise from outside, sorted.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn hull(&self, call: &Call) -> Result<Vec<u32>, Failure> {
        either!(self.asked(Query::Hull, call)?, t => call.within(|| cast_slice(&t.hull()).to_vec()))
    }

    /// Returns the edges: two vertices each, smaller first, sorted.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn edges(&self, call: &Call) -> Result<Vec<u32>, Failure> {
        either!(self.asked(Query::Edges, call)?, t => call.within(|| t.edges().into_flattened()))
    }

    /// Returns the vertices that an edge joins to each point, ascending. The row of a duplicate is empty.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn vertex_neighbours(&self, call: &Call) -> Result<Ragged, Failure> {
        either!(self.asked(Query::Edges, call)?, t => call.within(|| t.vertex_neighbours()))
    }

    /// Returns the area or volume of each cell, with a relative error below 1e-15.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn volumes(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        Query::Volumes.check(&self.sites, call.door)?;
        let periodic = self.sites.periodic.as_ref();
        let lengths = periodic.map_or(&[][..], |periodic| &periodic.lengths);
        call.within(|| form!(self, t => Ok(t.cell_volumes()), folded => folded.volumes(lengths)))?
    }

    /// Returns the circumcentre of each cell: `columns` coordinates.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn circumcentres(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        either!(self.asked(Query::Circumspheres, call)?, t => call.within(|| bytemuck::cast_vec(t.circumcentres())))
    }

    /// Returns the circumradius of each cell.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn circumradii(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        either!(self.asked(Query::Circumspheres, call)?, t => call.within(|| t.circumradii()))
    }

    /// Returns the affine maps to barycentric coordinates, `columns + 1` rows of `columns` numbers for each cell. Let `r` be the
    /// last row. The coordinates of `x` but the last are the products of the other rows with `x - r`.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn transforms(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        either!(self.asked(Query::Transforms, call)?, t => call.within(|| bytemuck::cast_vec(t.transforms())))
    }

    /// Returns the gradients of the linear interpolants in each cell: `columns` rows of `values_columns` numbers, given
    /// `values_columns` values for each point.
    ///
    /// # Errors
    /// Fails if the number of values does not fit, or if the call is cancelled.
    pub fn gradients(&self, values: &[f64], values_columns: usize, call: &Call) -> Result<Vec<f64>, Failure> {
        either!(self.asked(Query::Gradients, call)?, t => call.ask(|| t.gradients(values, values_columns)))
    }
}
