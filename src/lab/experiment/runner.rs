//! The runs of a sweep.

use std::time::Instant;

use thiserror::Error;

use septet_geometry::incremental::{Incremental, IncrementalError, insertion_order};
use septet_geometry::point::Point;

use septet_core::generate::{GenerateError, Generated, Request, generate};
use septet_core::model::Points;
use septet_core::spec::{Spec, SpecError, Until};
use septet_core::{Ending, Remedy, count, triangulate};
use septet_protocol::ids::ByGroup;

use super::line::{Line, Program, RunOptions, SCHEMA};
use super::measure::of_run;
use super::sweep::{Job, Sweep};
use crate::rows::TreeRow;

/// A reason why a run of a sweep has no line.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunError {
    /// The set cannot be generated.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] septet_core::Error),
    /// The serial kernel failed.
    #[error("the serial kernel failed")]
    Serial(#[from] IncrementalError),
}

impl RunError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        match self {
            RunError::Generate(error) => error.remedy(),
            RunError::Run(error) => error.remedy(),
            RunError::Serial(_) => None,
        }
    }
}

/// Executes runs one after another, and keeps the point set of the last run.
#[derive(Debug, Default)]
pub struct Runner {
    set: Option<(Request, Generated)>,
}

impl Runner {
    /// Executes a run of a sweep. Calls `progress` while it generates the set, unless the previous run had the same
    /// set.
    ///
    /// # Errors
    /// See [`RunError`].
    pub fn run(
        &mut self,
        sweep: &Sweep,
        job: &Job,
        progress: &mut dyn FnMut(&str, u64, u64),
    ) -> Result<Line, RunError> {
        let request = job.request;
        let (_, set) = match self.set.take().filter(|(made, _)| *made == request) {
            Some(kept) => self.set.insert(kept),
            None => self.set.insert((request, generate(&request, progress)?)),
        };
        let spec = sweep.spec.clone().with(|c| {
            c.machine.workers = job.workers;
            c.machine.seed = request.seed;
            c.recursion.spacing = set.spacing.map(|s| s.lipschitz);
        });
        let line = match &set.points {
            Points::Plane(points) => made(points, (job.program, sweep.until), &spec)?,
            Points::Space(points) => made(points, (job.program, sweep.until), &spec)?,
            Points::Higher(points) => {
                let dimension = points.slice().dimension();
                return Err(septet_core::Error::from(SpecError::OnlySpace {
                    what: "experiments",
                    dimension,
                })
                .into());
            }
        };
        Ok(Line {
            sweep: sweep.words(),
            command: sweep.command(job),
            kind: request.kind.name().to_string(),
            seed: request.seed,
            asked: request.n,
            settings: sweep.settings(job.workers),
            ..line
        })
    }
}

fn made<P: Point>(
    points: &[P],
    (program, until): (Program, Option<Until>),
    spec: &Spec,
) -> Result<Line, RunError> {
    Ok(match program {
        Program::Simulate => of_run(&count(points, until, spec)?),
        Program::Triangulate => {
            let run = triangulate(points, spec)?;
            // The time excludes the canonical ordering of the output, as it does for the serial kernel.
            Line { seconds: run.times.triangulate, ..of_run(&run) }
        }
        Program::Serial => serial(points)?,
    })
}

/// Runs the algorithm of Bowyer and Watson on the whole set, in the order of a space-filling curve.
fn serial<P: Point>(points: &[P]) -> Result<Line, RunError> {
    let start = Instant::now();
    let order = insertion_order(points);
    let kernel = Incremental::build(order.iter().map(|&i| points[i as usize]).collect(), None)?;
    let seconds = start.elapsed().as_secs_f64();
    let cells = kernel.cells().count() as u64;
    let n = points.len() as u64;
    Ok(Line {
        schema: SCHEMA.to_string(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        sweep: String::new(),
        command: String::new(),
        program: Program::Serial,
        kind: String::new(),
        dimension: P::DIM,
        seed: 0,
        asked: n,
        n,
        workers: 1,
        leaf: n,
        samples: 0,
        tries: 0,
        settings: RunOptions::default(),
        supergraph: None,
        phases: Vec::new(),
        totals: ByGroup::default(),
        tree: TreeRow::default(),
        levels: Vec::new(),
        rounds: Vec::new(),
        graph: None,
        end: Some(Ending { cells, ..Ending::default() }),
        seconds,
    })
}
