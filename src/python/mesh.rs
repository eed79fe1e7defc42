//! Meshes of domains.

use std::path::PathBuf;

use glam::{DVec2, DVec3};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use septet_core::mesh::field::SizeField;
use septet_core::mesh::labelled::Labelled;
use septet_core::mesh::{Dimension, MESH_OPTIONS, MakeError, MeshError, MeshKeep, MeshSpec, accept, make_of};
use septet_core::model::{Labels, MeshView, Patches};
use septet_core::spec::row;
use septet_core::{Door, Remedy};
use septet_doors::{Code, Failure};
use septet_io::read::{AnyInput, InputError, read_domains, read_sizes};
use septet_io::write::{Order, WriteOptions, check_output, write};
use septet_lab::report::mesh::{CheckedMesh, MeshContext, MeshReport, feature_name};
use septet_meshing::input::{DomainKind, Input, InputSegment};

use crate::arrays::{self, Array, Width, flat};
use crate::errors;
use crate::watch::Watch;

/// The stages that progress reports.
const STAGES: [&str; 3] = ["domain", "mesh", "report"];

/// The fault of arrays whose last row is not whole.
const NO_ROWS: &str = "its arrays have no whole rows";

/// The mesh behind `septet.Mesh`.
#[pyclass(frozen, module = "septet._septet")]
pub struct Meshed {
    dimension: usize,
    points: Vec<f64>,
    cells: Vec<u64>,
    labels: Labels,
    quality: String,
    first_id: u64,
    width: Width,
}

/// A reason why there is no mesh.
enum NoMesh {
    File(InputError),
    /// The domain has defects.
    Domain(String, Vec<String>),
    Failed(Failure),
}

impl NoMesh {
    fn raised(self, py: Python<'_>) -> PyErr {
        match self {
            NoMesh::File(error) => errors::of_input(py, &error, errors::OF_MESH),
            NoMesh::Domain(message, defects) => {
                errors::exception(py, "DomainError", &message, [("defects", defects)])
            }
            NoMesh::Failed(failure) => errors::raise(py, &failure),
        }
    }

    fn of(code: Code, message: &str, remedy: Option<Remedy>) -> Self {
        NoMesh::Failed(Failure::new(code, errors::with_known(message, remedy, errors::OF_MESH)))
    }
}

/// Returns the request of a mesh with these options, as key and value.
fn request_of(options: &[(String, String)], watch: &Watch) -> Result<MeshSpec, NoMesh> {
    let mut request = MeshSpec::default();
    for (name, value) in options {
        let set = match MESH_OPTIONS.iter().find(|row| row.name == name) {
            Some(row) => row.set(&mut request, value),
            None => row(name).set(&mut request.run, value),
        };
        set.map_err(|error| NoMesh::of(Code::Usage, &error.to_string(), error.remedy()))?;
    }
    request.run.check().map_err(|error| NoMesh::of(Code::Usage, &error.to_string(), error.remedy()))?;
    request.run.control.cancel = Some(watch.flag());
    Ok(request)
}

/// Returns a domain of points and polygons: a closed surface, or the closed loops of the boundary of a plane region.
fn domain_of(points: &[f64], columns: usize, (offsets, vertices): (&[i64], &[i64])) -> AnyInput {
    let vertex = |&v: &i64| u32::try_from(v).unwrap_or(u32::MAX);
    let loops = offsets
        .windows(2)
        .map(|ends| vertices[ends[0] as usize..ends[1] as usize].iter().map(vertex).collect::<Vec<u32>>());
    if columns == 3 {
        let points = points.as_chunks().0.iter().copied().map(DVec3::from_array).collect();
        return AnyInput::Space(Input::surface(points, loops));
    }
    let points = points.as_chunks().0.iter().copied().map(DVec2::from_array).collect();
    let mut input = Input::new(DomainKind::Complex, points);
    for polygon in loops {
        let ends = polygon.iter().zip(polygon.iter().cycle().skip(1));
        input.segments.extend(ends.map(|(&a, &b)| InputSegment { ends: [a, b], marker: 0 }));
    }
    AnyInput::Plane(input)
}

/// Returns the reason for an error of generation.
fn refused<P: Dimension>(
    error: MakeError<P>,
    name: impl Fn(septet_meshing::domain::Feature) -> String,
) -> NoMesh {
    let (message, remedy) = (error.to_string(), error.remedy());
    match error {
        MakeError::Mesh(MeshError::Coarse { feature, .. }) => {
            NoMesh::Domain(errors::with_remedy(&message, remedy), vec![name(feature)])
        }
        MakeError::Mesh(MeshError::Missing { features, .. }) => {
            let defects =
                features.iter().map(|&(feature, parts)| format!("{}: {parts} parts", name(feature)));
            NoMesh::Domain(errors::with_known(&message, remedy, errors::OF_MESH), defects.collect())
        }
        MakeError::Mesh(MeshError::Run(error)) => NoMesh::Failed(Failure::of_run(&error, Door::Python)),
        MakeError::Mesh(MeshError::Memory { forecast, limit, .. }) => {
            let mut failure =
                Failure::new(Code::Limit, errors::with_known(&message, remedy, errors::OF_MESH));
            failure.forecast = Some(septet_doors::Forecast { bytes: forecast, limit });
            NoMesh::Failed(failure)
        }
        MakeError::Mesh(MeshError::TooMany { .. }) => NoMesh::of(Code::Limit, &message, remedy),
        MakeError::Mesh(MeshError::Dimension { .. } | MeshError::Size(_) | MeshError::Unsupported(_)) => {
            NoMesh::of(Code::Usage, &message, remedy)
        }
        _ => NoMesh::of(Code::Failed, &message, remedy),
    }
}

/// Checks a domain and meshes it.
fn meshed<P: Dimension>(
    input: &Input<P>,
    (request, first_id): (&MeshSpec, u64),
    watch: &Watch,
) -> Result<Meshed, NoMesh> {
    let accepted = accept(input, request).map_err(|defects| {
        let defects: Vec<String> =
            defects.iter().map(|defect| format!("{}: {}", defect.kind(), defect.in_file(first_id))).collect();
        let first = defects.first().cloned().unwrap_or_default();
        NoMesh::Domain(format!("the domain has {} defects; the first is {first}", defects.len()), defects)
    })?;
    let domain = accepted.domain;
    note(watch, 1);
    let named = |feature| feature_name(&domain, feature, first_id);
    let made = make_of(&domain, request, MeshKeep::default()).map_err(|error| refused(error, named))?;
    note(watch, 2);
    let checked = CheckedMesh {
        domain: &domain,
        request,
        mesh: &made.mesh,
        stages: &made.stages,
        quality: &made.quality,
        conformity: &made.conformity,
        run_log: &made.run_log,
        picture: None,
    };
    let report = MeshReport::of(&checked, &MeshContext { first_id, ..MeshContext::default() });
    let quality = serde_json::to_string(&report.quality);
    let quality = quality.map_err(|error| NoMesh::of(Code::Failed, &error.to_string(), None))?;
    let labelled = Labelled::of(&domain, &made.mesh);
    let view = labelled.view();
    Ok(Meshed {
        dimension: P::DIM,
        width: Width::of(view.point_count(), view.cell_count()),
        points: view.coordinates.to_vec(),
        cells: view.cells.to_vec(),
        labels: view.labels.cloned().unwrap_or_default(),
        quality,
        first_id,
    })
}

fn note(watch: &Watch, stage: usize) {
    watch.note(STAGES[stage], stage as u64, STAGES.len() as u64);
}

/// A domain of Python: files, or points with polygons as offsets and vertices.
#[derive(FromPyObject)]
enum Domain<'py> {
    Files(Vec<PathBuf>),
    Surface(PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, i64>, PyReadonlyArray1<'py, i64>),
}

/// A size field of Python: a file, or points with sizes.
#[derive(FromPyObject)]
enum Sizes<'py> {
    File(String),
    Rows(PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>),
}

#[pymethods]
impl Meshed {
    #[new]
    #[pyo3(signature = (domain, options, size_field, threads, progress))]
    fn new(
        py: Python<'_>,
        domain: Domain<'_>,
        options: Vec<(String, String)>,
        size_field: Option<Sizes<'_>>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let watch = Watch::new(progress);
        let mut request = request_of(&options, &watch).map_err(|error| error.raised(py))?;
        if let Some(Sizes::File(path)) = &size_field {
            let field = read_sizes(std::path::Path::new(path), &mut |_, _| {});
            request.sizes.field = Some(field.map_err(|error| NoMesh::File(error).raised(py))?);
        }
        if let Some(Sizes::Rows(places, sizes)) = &size_field {
            let (dimension, places, sizes) = (places.shape()[1], flat(places)?, sizes.as_slice()?);
            let at = |row: &[f64]| [row[0], row[1], row.get(2).copied().unwrap_or(0.0)];
            let rows = places.chunks_exact(dimension).map(at).zip(sizes.iter().copied()).collect();
            request.sizes.field = Some(SizeField { dimension, rows });
        }
        let given = match &domain {
            Domain::Files(_) => None,
            Domain::Surface(points, offsets, vertices) => {
                let columns = points.shape()[1];
                Some(domain_of(flat(points)?, columns, (offsets.as_slice()?, vertices.as_slice()?)))
            }
        };
        let paths = if let Domain::Files(paths) = &domain { paths.clone() } else { Vec::new() };
        let call = watch.call(threads);
        let work = || {
            note(&watch, 0);
            let (input, first_id) = if let Some(input) = given {
                (input, 0)
            } else {
                let file = read_domains(&paths, &mut |_, _| watch.unwind_if_cancelled());
                let file = file.map_err(NoMesh::File)?;
                (file.input, file.first_id)
            };
            match &input {
                AnyInput::Plane(input) => meshed(input, (&request, first_id), &watch),
                AnyInput::Space(input) => meshed(input, (&request, first_id), &watch),
            }
        };
        // A small domain may have a large mesh, so each call is watched.
        watch.run(py, usize::MAX, || call.within(work))?.map_err(|error| error.raised(py))
    }

    #[getter]
    fn ndim(&self) -> usize {
        self.dimension
    }

    fn points(&self, py: Python<'_>) -> PyResult<Array> {
        arrays::rows(py, self.points.clone(), self.dimension)
    }

    fn cells(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.rows(py, narrow(&self.cells), self.dimension + 1)
    }

    fn cell_regions(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.list(py, self.labels.regions.clone())
    }

    fn facets(&self, py: Python<'_>) -> PyResult<Array> {
        self.width.rows(py, narrow(&self.labels.faces.vertices), self.dimension)
    }

    fn facet_markers(&self, py: Python<'_>) -> PyResult<Array> {
        let markers = &self.labels.faces.markers;
        let small: Result<Vec<i32>, _> = markers.iter().map(|&marker| i32::try_from(marker)).collect();
        match small {
            Ok(small) if self.width == Width::Narrow => arrays::list(py, small),
            _ => arrays::list(py, markers.clone()),
        }
    }

    /// Returns the contents of a pickle.
    fn state(&self, py: Python<'_>) -> PyResult<(usize, u64, &str, Vec<Array>)> {
        let labels = &self.labels;
        let arrays = vec![
            arrays::list(py, self.points.clone())?,
            arrays::list(py, self.cells.clone())?,
            arrays::list(py, labels.regions.clone())?,
            arrays::list(py, labels.attributes.clone())?,
            arrays::list(py, labels.faces.vertices.clone())?,
            arrays::list(py, labels.faces.of.clone())?,
            arrays::list(py, labels.faces.markers.clone())?,
            arrays::list(py, labels.sides.as_flattened().to_vec())?,
            arrays::list(py, labels.edges.vertices.clone())?,
            arrays::list(py, labels.edges.of.clone())?,
            arrays::list(py, labels.edges.markers.clone())?,
            arrays::list(py, labels.point_markers.clone())?,
            arrays::list(py, labels.sizes.clone())?,
            arrays::list(py, labels.carriers.as_flattened().to_vec())?,
        ];
        Ok((self.dimension, self.first_id, &self.quality, arrays))
    }

    /// Checks the contents of a pickle, and returns its mesh.
    #[staticmethod]
    fn restored(
        py: Python<'_>,
        head: (usize, u64, String),
        cells: (Numbers<'_, f64>, Numbers<'_, u64>),
        regions: (Numbers<'_, u32>, Numbers<'_, f64>),
        features: (Edges<'_>, Numbers<'_, u32>, Edges<'_>),
        vertices: (Numbers<'_, i64>, Numbers<'_, f64>, Numbers<'_, i32>),
    ) -> PyResult<Self> {
        let (dimension, first_id, quality) = head;
        let ((points, cells), (regions, attributes)) = (cells, regions);
        let ((faces, sides, edges), (point_markers, sizes, carriers)) = (features, vertices);
        let refused = |fault: &str| {
            let message = format!("the pickle holds no mesh: {fault}; make it again");
            errors::plain(py, "InputError", &message)
        };
        let ((sides, no_side), (carriers, no_carrier)) =
            (sides.as_slice()?.as_chunks(), carriers.as_slice()?.as_chunks());
        if !no_side.is_empty() || !no_carrier.is_empty() {
            return Err(refused(NO_ROWS));
        }
        let labels = Labels {
            regions: regions.as_slice()?.to_vec(),
            attributes: attributes.as_slice()?.to_vec(),
            faces: patches(&faces)?,
            sides: sides.to_vec(),
            edges: patches(&edges)?,
            point_markers: point_markers.as_slice()?.to_vec(),
            sizes: sizes.as_slice()?.to_vec(),
            carriers: carriers.to_vec(),
        };
        let (points, cells) = (points.as_slice()?.to_vec(), cells.as_slice()?.to_vec());
        let width = Width::of(points.len() / dimension.max(1), cells.len() / (dimension + 1));
        let made = Meshed { dimension, points, cells, labels, quality, first_id, width };
        let fault = made.fault();
        fault.map_or(Ok(made), |fault| Err(refused(fault)))
    }

    /// Returns the quality as JSON.
    fn quality(&self) -> &str {
        &self.quality
    }

    fn write(&self, py: Python<'_>, path: PathBuf, order: u8) -> PyResult<()> {
        // The package checks the number.
        let order = if order == 2 { Order::Two } else { Order::One };
        let options = WriteOptions { first_id: self.first_id, order, ..WriteOptions::default() };
        check_output(&path, &options).map_err(|error| errors::of_output(py, &error))?;
        let view = MeshView {
            dimension: self.dimension,
            coordinates: &self.points,
            heights: None,
            cells: &self.cells,
            owner: None,
            owning_leaf: None,
            run: None,
            labels: Some(&self.labels),
        };
        let watch = Watch::new(None);
        let call = watch.call(None);
        let size = self.cells.len();
        let written = watch.run(py, size, || {
            call.within(|| write(&path, &view, &options, &mut |_, _| watch.unwind_if_cancelled()))
        })?;
        written.map(|_| ()).map_err(|error| errors::of_output(py, &error))
    }
}

/// Numbers of a pickle.
type Numbers<'py, T> = PyReadonlyArray1<'py, T>;

/// The vertices, features and markers of faces or edges of a pickle.
type Edges<'py> = (Numbers<'py, u64>, Numbers<'py, u32>, Numbers<'py, i64>);

fn patches((vertices, of, markers): &Edges<'_>) -> PyResult<Patches> {
    Ok(Patches {
        vertices: vertices.as_slice()?.to_vec(),
        of: of.as_slice()?.to_vec(),
        markers: markers.as_slice()?.to_vec(),
    })
}

impl Meshed {
    /// Returns the fault of the contents of a pickle, or `None`.
    fn fault(&self) -> Option<&'static str> {
        let Meshed { dimension: d, points, cells, labels, quality, .. } = self;
        let Labels { regions, attributes, faces, sides, edges, point_markers, sizes, carriers } = labels;
        if ![2, 3].contains(d) || !points.len().is_multiple_of(*d) || !cells.len().is_multiple_of(d + 1) {
            return Some(NO_ROWS);
        }
        let (n, m) = (points.len() / d, cells.len() / (d + 1));
        if !points.iter().all(|x| x.is_finite()) {
            return Some("a point is not finite");
        }
        if cells.iter().chain(&faces.vertices).chain(&edges.vertices).any(|&v| v >= n as u64) {
            return Some("a vertex is not the number of a point");
        }
        // A list that meshes of such a domain do not have is empty.
        let fits = |length: usize, rows: usize| length == rows || length == 0;
        let of_cells = regions.len() == m && fits(attributes.len(), m);
        let of_points = fits(point_markers.len(), n) && fits(sizes.len(), n) && fits(carriers.len(), n);
        let whole = |patches: &Patches, corners: usize| {
            patches.vertices.len() == corners * patches.len() && patches.markers.len() == patches.len()
        };
        if !of_cells || !of_points || !whole(faces, *d) || !whole(edges, 2) || !fits(sides.len(), faces.len())
        {
            return Some("its arrays have different lengths");
        }
        // Writers count features from 1.
        if faces.of.iter().chain(&edges.of).any(|&of| of == u32::MAX) {
            return Some("the number of a feature is too large");
        }
        let is_object =
            serde_json::from_str::<serde_json::Value>(quality).is_ok_and(|value| value.is_object());
        (!is_object).then_some("its quality is not a JSON object")
    }
}

/// Returns indices of 32 bits. A mesh has no more points.
fn narrow(ids: &[u64]) -> Vec<u32> {
    ids.iter().map(|&id| id as u32).collect()
}
