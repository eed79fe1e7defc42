//! Runs of the counted machine.

use std::path::PathBuf;
use std::time::Instant;

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use septet_core::Spec;
use septet_core::run::memory::{peak_rss, rss};
use septet_core::spec::row;
use septet_doors::{Code, Failure, Request, Sites, Triangulated, simulated};
use septet_io::write::write_text;
use septet_lab::assertions::{
    Broken, bytes, depth_of_levels, levels, levels_over_leaf, merges, messages_per_worker, no_repair, rounds,
};
use septet_lab::experiment::{Line, of_run};
use septet_lab::report::{RunContext, RunReport};

use crate::arrays::flat;
use crate::delaunay::{Core, Given, sites_of};
use crate::errors;
use crate::watch::Watch;

/// The run behind `septet.Run`.
#[pyclass(frozen, module = "septet._septet")]
pub struct Machine {
    core: Py<Core>,
    report: String,
    line: Line,
}

/// The results of a run of the machine.
struct Ran {
    made: Triangulated,
    report: String,
    line: Line,
}

/// Returns the specification of a run with these options, as key and value.
fn spec_of(options: &[(String, String)]) -> Result<Spec, Failure> {
    let mut spec = Spec::default();
    let failed = |error: &septet_core::spec::SpecError| {
        Failure::new(Code::Usage, errors::with_remedy(&error.to_string(), error.remedy()))
    };
    for (name, value) in options {
        row(name).set(&mut spec, value).map_err(|error| failed(&error))?;
    }
    spec.check().map_err(|error| failed(&error))?;
    Ok(spec)
}

/// Runs the paper's recursion, and takes its triangulation and its report.
fn ran(
    (points, columns): (&[f64], usize),
    (requested, sites): (&Spec, Sites),
    watch: &Watch,
) -> Result<Ran, Failure> {
    let (start, before) = (Instant::now(), rss());
    let mut spec = requested.clone();
    spec.control.cancel = Some(watch.flag());
    spec.control.progress = watch.progress();
    let request = Request { sites, ..Request::new(watch.call(spec.machine.threads)) };
    let run = simulated(points, columns, &request, &spec)?;
    let context = RunContext {
        command: "simulate",
        threads: spec.machine.thread_count(),
        total_seconds: start.elapsed().as_secs_f64(),
        rss_before_bytes: before,
        peak_rss_bytes: peak_rss(),
        ..RunContext::default()
    };
    let report = RunReport::of(&run, requested, &context).to_json();
    let report = report.map_err(|error| Failure::new(Code::Failed, error.to_string()))?;
    let line = of_run(&run);
    let made = Triangulated::of_run(points, columns, run, &request)?;
    Ok(Ran { made, report, line })
}

#[pymethods]
impl Machine {
    #[new]
    #[pyo3(signature = (points, options, given, progress))]
    fn new(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        options: Vec<(String, String)>,
        given: Given<'_>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let (n, columns) = (points.shape()[0], points.shape()[1]);
        let points = flat(&points)?;
        let sites = sites_of(&given)?;
        let mut spec = spec_of(&options).map_err(|failure| errors::raise(py, &failure))?;
        spec.input.periodic.clone_from(&sites.periodic);
        let watch = Watch::new(progress);
        let ran = watch.run(py, n, || ran((points, columns), (&spec, sites), &watch))?;
        let core = Py::new(py, Core::of(ran.made, &spec, None))?;
        Ok(Machine { core, report: ran.report, line: ran.line })
    }

    /// Returns the triangulation.
    fn core(&self, py: Python<'_>) -> Py<Core> {
        self.core.clone_ref(py)
    }

    /// Returns the report as JSON.
    fn report(&self) -> &str {
        &self.report
    }

    /// Returns the failure of a check, or none. `words` are its phase, if it has one; `numbers` are its bounds.
    fn check(
        &self,
        py: Python<'_>,
        name: &str,
        words: Vec<String>,
        numbers: Vec<f64>,
    ) -> PyResult<Option<String>> {
        let line = &self.line;
        let phase = words.first().map_or("", String::as_str);
        let found: Result<(), Broken> = match (name, words.len(), numbers.as_slice()) {
            ("levels", 0, &[slope, constant]) => levels(line, slope, constant),
            ("levels_over_leaf", 0, &[slope, constant]) => levels_over_leaf(line, slope, constant),
            ("merges", 0, &[slope, constant]) => merges(line, slope, constant),
            ("no_repair", 0, []) => no_repair(line),
            ("rounds", 1, &[slope, constant]) => rounds(line, phase, slope, constant),
            ("messages_per_worker", 1, &[slope, constant]) => {
                messages_per_worker(line, phase, slope, constant)
            }
            ("bytes", 1, &[factor]) => bytes(line, phase, factor),
            ("depth_of_levels", 1, &[most]) => depth_of_levels(line, phase, most as u64),
            _ => {
                let message =
                    format!("the claim {name} with these arguments is unknown; see help(septet.Run.check)");
                return Err(errors::plain(py, "OptionError", &message));
            }
        };
        Ok(found.err().map(|broken| broken.to_string()))
    }
}

/// Writes the report of a run: as JSON, or as a page if the name ends in `.html`.
#[pyfunction]
pub fn write_report(py: Python<'_>, path: PathBuf, report: &str) -> PyResult<()> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let text = match ending.as_deref() {
        Some("json") => format!("{report}\n"),
        Some("html") => {
            let page = septet_cli::page_of(&path.to_string_lossy(), report);
            page.map_err(|message: String| errors::plain(py, "InputError", &message))?
        }
        _ => {
            let message =
                format!("{}: a report is a .json file, or a page with the ending .html", path.display());
            return Err(errors::plain(py, "OptionError", &message));
        }
    };
    py.detach(|| write_text(&path, &text)).map_err(|error| errors::of_output(py, &error))
}
