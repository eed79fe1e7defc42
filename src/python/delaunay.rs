//! The triangulation behind `septet.Delaunay`.

use std::path::{Path, PathBuf};

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use septet_core::Spec;
use septet_core::cores::map;
use septet_core::model::MeshView;
use septet_core::result::unfolded::Unfolded;
use septet_core::spec::Control;
use septet_doors::{Call, Failure, Method, Periodic, Request, Sites, Triangulated};
use septet_io::write::{OutputError, WriteOptions, check_output, image_columns, write};
use septet_lab::report::{RunContext, RunReport};

use crate::arrays::{self, Array, Width, flat};
use crate::errors;
use crate::watch::Watch;

/// The triangulation behind `septet.Delaunay`.
#[pyclass(frozen, module = "septet._septet")]
pub struct Core {
    pub(crate) made: Triangulated,
    pub(crate) width: Width,
    /// The request of the caller, without the flag and the callback.
    spec: Spec,
    /// The report of its run as JSON, for one that was loaded from a pickle.
    stats: Option<String>,
}

impl Core {
    /// Takes a triangulation.
    pub fn of(made: Triangulated, spec: &Spec, stats: Option<String>) -> Self {
        let width = Width::of(made.len(), made.cell_count());
        let spec = spec.clone().with(|spec| spec.control = Control::default());
        Core { made, width, spec, stats }
    }

    /// Runs a query of `size` items without the interpreter.
    pub(crate) fn ask<T: Send>(
        &self,
        py: Python<'_>,
        (size, threads): (usize, Option<usize>),
        query: impl FnOnce(&Triangulated, &Call) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let watch = Watch::new(None);
        // A small query of one thread starts no pool.
        let threads = if size < crate::watch::FEW { Some(1) } else { threads };
        let call = watch.call(threads);
        watch.run(py, size, || query(&self.made, &call))
    }

    /// Runs a query of all cells without the interpreter.
    fn whole<T: Send>(
        &self,
        py: Python<'_>,
        query: impl FnOnce(&Triangulated, &Call) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        self.ask(py, (self.made.cell_count(), self.threads()), query)
    }

    /// Returns the number of threads that the caller chose for the triangulation.
    pub(crate) fn threads(&self) -> Option<usize> {
        self.spec.machine.threads
    }

    fn report(&self) -> Option<String> {
        let (run, spec) = (self.made.run()?, &self.spec);
        let context = RunContext {
            command: "triangulate",
            threads: spec.machine.thread_count(),
            ..RunContext::default()
        };
        RunReport::of(run, spec, &context).to_json().ok()
    }
}

/// The lengths of a periodic box, its lower corner, and whether points outside of it are admitted.
type Lattice = (Vec<Option<f64>>, Vec<f64>, bool);

/// The weights of points and their periodic box.
pub type Given<'py> = (Option<PyReadonlyArray1<'py, f64>>, Option<Lattice>);

/// Returns the weights of points and their periodic box.
pub fn sites_of((weights, lattice): &Given<'_>) -> PyResult<Sites> {
    let weights = weights.as_ref().map(|weights| Ok::<_, PyErr>(weights.as_slice()?.to_vec())).transpose()?;
    let periodic = lattice.clone().map(|(lengths, origin, wrap)| {
        let mut periodic = Periodic::of(lengths);
        (periodic.origin, periodic.wrap) = (origin, wrap);
        periodic
    });
    Ok(Sites { weights, periodic })
}

/// Returns the method of a name.
fn method_of(py: Python<'_>, name: &str) -> PyResult<Method> {
    let found = Method::ALL.into_iter().find(|method| method.name() == name);
    found.ok_or_else(|| {
        errors::plain(
            py,
            "OptionError",
            &format!("the method {name} is unknown; pass linear, sibson or laplace"),
        )
    })
}

#[pymethods]
impl Core {
    #[new]
    fn new(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        given: Given<'_>,
        threads: Option<usize>,
        settings: (u64, bool, Option<u64>),
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let (n, columns) = (points.shape()[0], points.shape()[1]);
        let points = flat(&points)?;
        let (seed, skip_invalid, max_memory) = settings;
        let watch = Watch::new(progress);
        let mut request = Request::new(watch.call(threads));
        request.sites = sites_of(&given)?;
        request.seed = seed;
        request.skip_invalid = skip_invalid;
        request.max_memory = max_memory;
        request.progress = watch.progress();
        let made = watch.run(py, n, || Triangulated::new(points, columns, &request))?;
        Ok(Core::of(made, &request.spec(), None))
    }

    /// Checks the contents of a pickle, and returns its triangulation.
    #[staticmethod]
    fn restored(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        simplices: PyReadonlyArray2<'_, i64>,
        given: Given<'_>,
        stats: String,
    ) -> PyResult<Self> {
        let sites = sites_of(&given)?;
        let columns = points.shape()[1];
        let wrong = || {
            errors::plain(
                py,
                "InputError",
                "the simplices of the pickle do not fit its points; make it again",
            )
        };
        if simplices.shape()[1] != columns + 1 {
            return Err(wrong());
        }
        let (points, rows) = (flat(&points)?, simplices.as_slice().map_err(|_| wrong())?);
        let cells: Vec<u32> =
            rows.iter().map(|&v| u32::try_from(v)).collect::<Result<_, _>>().map_err(|_| wrong())?;
        let watch = Watch::new(None);
        let call = watch.call(None);
        let made =
            watch.run(py, points.len(), || Ok(Triangulated::of_rows(points, columns, &cells, sites, &call)));
        let made = made?.map_err(|failure| {
            errors::plain(
                py,
                "InputError",
                &format!("the pickle holds no triangulation: {}", failure.message),
            )
        })?;
        Ok(Core::of(made, &Spec::default(), Some(stats)))
    }

    #[getter]
    fn ndim(&self) -> usize {
        self.made.columns()
    }

    #[getter]
    fn dimension(&self) -> isize {
        self.made.dimension()
    }

    #[getter]
    fn simplex_count(&self) -> usize {
        self.made.cell_count()
    }

    #[getter]
    fn point_count(&self) -> usize {
        self.made.len()
    }

    fn points(&self, py: Python<'_>) -> PyResult<Array> {
        arrays::rows(py, self.made.points(), self.made.columns())
    }

    fn simplices(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.rows(py, self.made.cells().to_vec(), self.made.columns() + 1)
    }

    fn neighbors(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.rows(py, self.made.neighbours().to_vec(), self.made.columns() + 1)
    }

    fn convex_hull(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.rows(py, self.whole(py, Triangulated::hull)?, self.made.columns())
    }

    fn duplicates(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.rows(py, self.made.duplicates().to_vec(), 2)
    }

    fn skipped(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.list(py, self.made.skipped().to_vec())
    }

    fn hidden(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.list(py, self.made.hidden().to_vec())
    }

    /// Returns the offsets of the vertices of the simplices in a periodic box, or none.
    fn offsets(&self, py: Python<'_>) -> PyResult<Option<Array>> {
        let d = self.made.columns();
        if !self.is_periodic() {
            return Ok(None);
        }
        // The copy is made without the interpreter.
        let offsets = self.whole(py, |t, call| call.within(|| t.offsets().map(<[i32]>::to_vec)))?;
        offsets.map(|offsets| arrays::blocks(py, offsets, [d + 1, d])).transpose()
    }

    #[getter]
    fn is_simplicial(&self) -> bool {
        self.made.is_simplicial()
    }

    /// Returns the numbers of boxes whose triangulation is a simplicial complex, or none.
    fn sheets(&self) -> Option<Vec<u32>> {
        self.made.sheets().map(<[u32]>::to_vec)
    }

    #[getter]
    fn has_weights(&self) -> bool {
        self.made.sites().weights.is_some()
    }

    #[getter]
    fn is_periodic(&self) -> bool {
        self.made.sites().periodic.is_some()
    }

    /// Returns the weights, and the lengths of the box, its lower corner, and whether points outside of it are admitted.
    fn sites(&self, py: Python<'_>) -> PyResult<(Option<Array>, Option<Lattice>)> {
        let Sites { weights, periodic } = self.made.sites();
        let weights = weights.as_ref().map(|weights| arrays::list(py, weights.clone())).transpose()?;
        let lattice = |of: &Periodic| (of.lengths.clone(), of.origin.clone(), of.wrap);
        Ok((weights, periodic.as_ref().map(lattice)))
    }

    /// Returns points with their images that are vertices in a periodic box, and simplices of them, or none.
    fn unfolded(&self, py: Python<'_>) -> PyResult<Option<(Array, Array)>> {
        let made = self.whole(py, |t, call| {
            let Some(of) = t.unfolded(call)? else { return Ok(None) };
            let cells = call.within(|| map(&of.cells, |&v| v as u32))?;
            Ok(Some((of.coordinates, cells)))
        })?;
        let Some((coordinates, cells)) = made else { return Ok(None) };
        let d = self.made.columns();
        let width = Width::of(coordinates.len() / d, self.made.cell_count());
        Ok(Some((arrays::rows(py, coordinates, d)?, width.rows(py, cells, d + 1)?)))
    }

    fn vertex_to_simplex(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.list(py, self.made.vertex_cells())
    }

    fn vertex_neighbors(&self, py: Python<'_>) -> PyResult<(Array, Array)> {
        let rows = self.whole(py, Triangulated::vertex_neighbours)?;
        Ok((arrays::offsets(py, rows.offsets)?, self.width.list(py, rows.indices)?))
    }

    fn edges(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.rows(py, self.whole(py, Triangulated::edges)?, 2)
    }

    fn volumes(&self, py: Python<'_>) -> PyResult<Array> {
        arrays::list(py, self.whole(py, Triangulated::volumes)?)
    }

    fn circumcenters(&self, py: Python<'_>) -> PyResult<Array> {
        arrays::rows(py, self.whole(py, Triangulated::circumcentres)?, self.made.columns())
    }

    fn circumradii(&self, py: Python<'_>) -> PyResult<Array> {
        arrays::list(py, self.whole(py, Triangulated::circumradii)?)
    }

    fn transform(&self, py: Python<'_>) -> PyResult<Array> {
        let d = self.made.columns();
        arrays::blocks(py, self.whole(py, Triangulated::transforms)?, [d + 1, d])
    }

    fn locate(
        &self,
        py: Python<'_>,
        x: PyReadonlyArray2<'_, f64>,
        threads: Option<usize>,
    ) -> PyResult<Array> {
        let (size, x) = (x.shape()[0], flat(&x)?);
        self.width.list(py, self.ask(py, (size, threads), |t, call| t.locate(x, call))?)
    }

    fn nearest(
        &self,
        py: Python<'_>,
        x: PyReadonlyArray2<'_, f64>,
        threads: Option<usize>,
    ) -> PyResult<Array> {
        let (size, x) = (x.shape()[0], flat(&x)?);
        self.width.list(py, self.ask(py, (size, threads), |t, call| t.nearest(x, call))?)
    }

    fn barycentric(
        &self,
        py: Python<'_>,
        x: PyReadonlyArray2<'_, f64>,
        simplices: Option<PyReadonlyArray1<'_, i64>>,
        threads: Option<usize>,
    ) -> PyResult<(Array, Array)> {
        let (size, x) = (x.shape()[0], flat(&x)?);
        let given = simplices.as_ref().map(|rows| rows.as_slice()).transpose()?;
        // The caller has checked that all indices are those of simplices, or -1.
        let given: Option<Vec<u32>> = given.map(|rows| rows.iter().map(|&row| row as u32).collect());
        let (cells, coordinates) = self.ask(py, (size, threads), move |t, call| match given {
            None => t.barycentric(x, call).map(|found| (found.cells, found.coordinates)),
            Some(cells) => {
                let coordinates = t.barycentric_in(x, &cells, call)?;
                Ok((cells, coordinates))
            }
        })?;
        Ok((self.width.list(py, cells)?, arrays::list(py, coordinates)?))
    }

    fn weights(
        &self,
        py: Python<'_>,
        x: PyReadonlyArray2<'_, f64>,
        method: &str,
        threads: Option<usize>,
    ) -> PyResult<(Array, Array, Array)> {
        let (size, x, method) = (x.shape()[0], flat(&x)?, method_of(py, method)?);
        let found = self.ask(py, (size, threads), |t, call| t.weights(x, method, call))?;
        let offsets = arrays::offsets(py, found.offsets)?;
        Ok((offsets, self.width.list(py, found.indices)?, arrays::list(py, found.values)?))
    }

    #[pyo3(signature = (values, x, method, outside, threads))]
    fn interpolate(
        &self,
        py: Python<'_>,
        values: PyReadonlyArray2<'_, f64>,
        x: PyReadonlyArray2<'_, f64>,
        method: &str,
        outside: f64,
        threads: Option<usize>,
    ) -> PyResult<Array> {
        let columns = values.shape()[1];
        let (size, x, values) = (x.shape()[0], flat(&x)?, flat(&values)?);
        let method = method_of(py, method)?;
        let found = self.ask(py, (size, threads), |t, call| {
            t.interpolate((values, columns), x, (method, outside), call)
        })?;
        arrays::list(py, found)
    }

    fn gradients(&self, py: Python<'_>, values: PyReadonlyArray2<'_, f64>) -> PyResult<Array> {
        let (columns, values) = (values.shape()[1], flat(&values)?);
        arrays::list(py, self.whole(py, |t, call| t.gradients(values, columns, call))?)
    }

    /// Returns the report of the run as JSON.
    fn stats(&self) -> String {
        let made = || self.report().unwrap_or_default();
        self.stats.clone().unwrap_or_else(made)
    }

    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let options = WriteOptions::default();
        check_output(&path, &options).map_err(|error| errors::of_output(py, &error))?;
        let watch = Watch::new(None);
        let call = watch.call(None);
        let written = watch.run(py, self.made.cell_count(), || {
            // Formats with points get the images that are vertices, too. A wrong ending is an error of the writer.
            let has_points = options.format_of(&path).is_ok_and(|format| !format.row().has_input_rows);
            let unfolded = if has_points { self.made.unfolded(&call)? } else { None };
            call.within(|| self.written((&path, unfolded), &options, &watch))
        })?;
        written.map_err(|error| errors::of_output(py, &error))
    }
}

impl Core {
    /// Writes points and simplices, or those with images that are vertices.
    fn written(
        &self,
        (path, unfolded): (&Path, Option<Unfolded>),
        options: &WriteOptions<'_>,
        watch: &Watch,
    ) -> Result<(), OutputError> {
        let t = &self.made;
        let columns = unfolded.as_ref().map(|of| image_columns(of, t.columns(), None)).unwrap_or_default();
        let (points, cells) = match unfolded {
            Some(of) => (of.coordinates, of.cells),
            None => (t.points(), map(t.cells(), |&v| u64::from(v))),
        };
        let view = MeshView {
            dimension: t.columns(),
            coordinates: &points,
            heights: None,
            cells: &cells,
            owner: None,
            owning_leaf: None,
            run: None,
            labels: None,
        };
        let options = WriteOptions { point_data: &columns, ..*options };
        write(path, &view, &options, &mut |_, _| watch.unwind_if_cancelled()).map(|_| ())
    }
}
