//! Implements the machine of the generator by runs of `septet`.
//!
//! A rule is evaluated by a run of the ranks (`crate::run::evaluation`). An independent set is a run of
//! [`crate::independent`], and a triangulation is a run of [`crate::triangulate`], or of [`crate::simulate`] if the caller
//! asks for its work and depth by the paper's recursion. A facet with at most `LEAF` points would be a single leaf of its
//! machine. Such facets are items of an evaluation, which triangulates them in parallel.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use glam::DVec2;
use septet_geometry::cost::Cost;
use septet_geometry::dependence::Dependence;
use septet_geometry::evaluation::{Evaluated, Evaluation};
use septet_geometry::incremental::{Incremental, IncrementalError};
use septet_geometry::point::{Point, Simplex};
use septet_meshing::executor::{Evaluator, Executor, Part, evaluated};
use septet_meshing::generate::{Delaunay, MeshMachine, StageCounts};
use septet_meshing::mesh::StageLine;
use septet_meshing::points::conflicts::Site;
use septet_meshing::points::independent::Independent;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;
use septet_workers::config::cores;
use septet_workers::profile::stage_span;
use tracing::span::EnteredSpan;

use super::run_log::{EVALUATION, INDEPENDENT_SET, RunLog, SiteCounts, TRIANGULATION, depth_of};
use crate::error::Error;
use crate::result::outcome::{Outcome, Selection, TrafficTotal};
use crate::result::share::Neighbour;
use crate::run::calls::{independent, simulate, triangulate};
use crate::run::evaluation::evaluate;
use crate::spec::{Alpha, Graph, Spec};

/// The largest number of points of a facet that is one leaf.
const LEAF: usize = 4096;

/// A machine that counts the resources of each stage.
#[derive(Debug)]
pub struct CountedMachine {
    spec: Spec,
    /// The counts of the runs so far.
    counts: Mutex<Counts>,
    /// Whether triangulations run by the paper's recursion.
    recursion: bool,
    owners: Owners,
    since: Instant,
    /// The span of the current stage, for subscribers.
    span: Option<EnteredSpan>,
}

/// The counts of stages and runs.
#[derive(Debug, Default)]
struct Counts {
    lines: Vec<StageLine>,
    run_log: RunLog,
}

/// The worker of each cell of the last triangulation of the highest dimension.
#[derive(Debug, Default)]
struct Owners {
    dimension: usize,
    of: Vec<u32>,
}

/// The name of the stage before the first stage of the generator: the size function, the cells of the volume and the
/// corners.
pub(super) const FIRST_STAGE: &str = "sizes";

/// Returns the phase that is charged for a part of Section 5.
fn phase_of(part: Part) -> Phase {
    match part {
        Part::Octree => Phase::Octree,
        Part::Sizes => Phase::Sizes,
        Part::Candidates => Phase::Candidates,
        Part::Conflicts => Phase::Conflicts,
        Part::Completion => Phase::Completion,
    }
}

/// The data of a run for the log.
struct Taken<'a> {
    task: &'static str,
    points: usize,
    fixed: usize,
    ledger: &'a Ledger,
    phase_seconds: &'a [(Phase, f64)],
    seconds: f64,
}

impl CountedMachine {
    /// Creates a machine with this configuration. Its first stage is the size function.
    pub fn new(spec: Spec) -> Self {
        let mut machine = CountedMachine {
            spec,
            counts: Mutex::default(),
            recursion: false,
            owners: Owners::default(),
            since: Instant::now(),
            span: None,
        };
        machine.begin(FIRST_STAGE);
        machine
    }

    /// Lets triangulations run by the paper's recursion, which counts their work and depth for any number of workers.
    #[must_use]
    pub fn with_recursion(mut self, recursion: bool) -> Self {
        self.recursion = recursion;
        self
    }

    /// Returns the log of all runs.
    pub fn into_log(self) -> RunLog {
        self.counts.into_inner().unwrap_or_else(PoisonError::into_inner).run_log
    }

    /// Returns the worker of each cell of the last triangulation in this dimension, in its order. Returns `None` if
    /// that triangulation did not have `cells` cells.
    pub(super) fn owners(&self, dimension: usize, cells: usize) -> Option<&[u32]> {
        let Owners { dimension: of, of: owners } = &self.owners;
        (*of == dimension && owners.len() == cells).then_some(owners)
    }

    fn counts(&mut self) -> &mut Counts {
        self.counts.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, taken: &Taken<'_>) {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let Counts { lines, run_log } = &mut *counts;
        let Some(line) = lines.last_mut() else { return };
        let ledger = taken.ledger;
        let TrafficTotal { rounds, messages, bytes } = TrafficTotal::of(ledger);
        line.rounds += rounds;
        line.messages += messages;
        line.bytes += bytes;
        line.work += ledger.phases.iter().map(|p| p.work).sum::<u64>();
        line.depth += ledger.phases.iter().map(depth_of).sum::<u64>();
        let sites = SiteCounts { points: taken.points as u64, fixed: taken.fixed as u64 };
        run_log.add(&line.name, taken.task, sites, ledger, taken.seconds);
        run_log.add_phases(&line.name, ledger, taken.phase_seconds);
    }

    /// Begins a stage. Each stage has a line for each phase of an evaluation.
    fn begin(&mut self, name: &str) {
        self.close();
        self.span = Some(stage_span(self.spec.machine.name(), name));
        let Counts { lines, run_log } = self.counts();
        lines.push(StageLine { name: name.to_string(), ..StageLine::default() });
        for phase in Phase::OF_MESHES {
            run_log.begin(name, phase);
        }
    }

    fn close(&mut self) {
        self.span = None;
        let seconds = self.since.elapsed().as_secs_f64();
        if let Some(line) = self.counts().lines.last_mut() {
            line.seconds += seconds;
        }
        self.since = Instant::now();
    }

    /// Triangulates by the direct path, which charges the operations of its workers, one after the other.
    fn triangulated<P: Point>(&self, points: &[P]) -> Result<Outcome, Error> {
        triangulate(points, &self.spec.clone().with(|spec| spec.keep.operations = true))
    }

    /// Triangulates by the paper's recursion. The cells are those of the direct path.
    fn simulated<P: Point>(&self, points: &[P]) -> Result<Outcome, Error> {
        let spec = self.spec.clone().with(|spec| {
            spec.recursion.graph = Graph::Density { alpha: Alpha::Value(ALPHA) };
            spec.keep.neighbours = true;
        });
        simulate(points, &spec)
    }

    /// Adds the counts of the generator to the lines of its stages. Returns the lines and the log of all runs.
    pub(super) fn finish(mut self, stages: &[StageCounts]) -> (Vec<StageLine>, RunLog) {
        self.close();
        let Counts { mut lines, run_log } = self.counts.into_inner().unwrap_or_else(PoisonError::into_inner);
        for (line, stage) in lines.iter_mut().skip(1).zip(stages) {
            line.candidates = stage.candidates;
            line.points = stage.points;
            line.completion_rounds = u64::from(stage.completion);
            line.set_rounds = u64::from(stage.set_rounds);
        }
        (lines, run_log)
    }
}

/// alpha of the density graph of a triangulation by the recursion. Points of a mesh are well-spaced, and splaying finds the
/// stars that the graph lacks.
const ALPHA: f64 = 2.5;

impl<P: Point> Evaluator<P> for CountedMachine {
    type Error = Error;

    fn evaluate(&self, part: Part, rule: &dyn Evaluation) -> Result<Evaluated, Error> {
        let run = evaluate::<P>(&self.spec, phase_of(part), rule)?;
        self.add(&Taken {
            task: EVALUATION,
            points: rule.count() as usize,
            fixed: 0,
            ledger: &run.ledger,
            phase_seconds: &run.phase_seconds,
            seconds: run.seconds,
        });
        Ok(run.evaluated)
    }
}

impl<P: Point> MeshMachine<P> for CountedMachine {
    fn stage(&mut self, name: &'static str) {
        self.begin(name);
    }

    fn cancelled(&self) -> Option<Error> {
        self.spec.control.is_cancelled().then_some(Error::Interrupted)
    }

    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, Error> {
        let places: Vec<P> = sites.iter().map(|s| s.at).collect();
        let sizes: Vec<f64> = sites.iter().map(|s| s.size).collect();
        let run = independent(&places, &sizes, fixed, &self.spec)?;
        self.add(&Taken {
            task: INDEPENDENT_SET,
            points: sites.len(),
            fixed,
            ledger: &run.ledger,
            phase_seconds: &run.times.phases,
            seconds: run.times.total,
        });
        let Selection { members, undecided } = run.kept.selected.unwrap_or_default();
        Ok(Independent { members: members.into_iter().map(|m| m as u32).collect(), undecided })
    }

    fn delaunay(&mut self, points: &[P]) -> Result<Delaunay<P::Cell>, Error> {
        let run = if self.recursion { self.simulated(points)? } else { self.triangulated(points)? };
        self.add(&Taken {
            task: TRIANGULATION,
            points: points.len(),
            fixed: 0,
            ledger: &run.ledger,
            phase_seconds: &run.times.phases,
            seconds: run.times.total,
        });
        let (mut cells, mut neighbours) = (Vec::new(), Vec::new());
        cells.reserve(run.cell_count());
        neighbours.reserve(run.cell_count());
        // Ranks count from 1.
        let (mut first, mut count) = (vec![0], 0);
        for share in &run.shares {
            first.push(count);
            count += share.cell_count() as u32;
        }
        if P::DIM >= self.owners.dimension {
            let of = run.shares.iter().flat_map(|share| vec![share.rank; share.cell_count()]).collect();
            self.owners = Owners { dimension: P::DIM, of };
        }
        for share in &run.shares {
            for at in 0..share.cell_count() {
                let (mut cell, mut across) = (P::Cell::splat(0), P::Cell::splat(u32::MAX));
                for (slot, id) in share.cell_ids(at).enumerate() {
                    cell.as_mut()[slot] = id as u32;
                    match share.neighbour(at, slot) {
                        Some(Neighbour::Local(other)) => {
                            across.as_mut()[slot] = first[share.rank as usize] + other;
                        }
                        Some(Neighbour::Remote { rank, cell }) => {
                            across.as_mut()[slot] = first[rank as usize] + cell;
                        }
                        Some(Neighbour::Hull) | None => {}
                    }
                }
                cells.push(cell);
                neighbours.push(across);
            }
        }
        Ok(Delaunay { cells, neighbours })
    }

    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, Error> {
        let small: Vec<u32> = (0..sets.len() as u32).filter(|&i| sets[i as usize].len() <= LEAF).collect();
        let (seed, recursion) = (self.spec.machine.seed, self.recursion);
        let cells = evaluated::<P, _, _, _>(self, Part::Completion, &small, |i: u32, own| {
            in_a_leaf(&sets[i as usize], recursion.then_some(seed), own)
        })?;
        let mut made: Vec<Option<Vec<[u32; 3]>>> = vec![None; sets.len()];
        for (i, cells) in small.into_iter().zip(cells) {
            made[i as usize] = cells;
        }
        for (set, made) in sets.iter().zip(&mut made).filter(|(_, made)| made.is_none()) {
            *made = Some(MeshMachine::<DVec2>::delaunay(self, set)?.cells);
        }
        Ok(made.into_iter().map(Option::unwrap_or_default).collect())
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        AllCores.map(items, f)
    }
}

/// Maps with the threads of the call, for computations without a machine.
#[derive(Clone, Copy, Debug)]
pub(super) struct AllCores;

impl Executor for AllCores {
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        cores::map(items, f)
    }
}

/// Triangulates a leaf. Returns `None` on an error, so that the machine triangulates the facet or reports the error. With a
/// `seed`, charges an insertion in random order whose independent points are inserted at once
/// ([`septet_geometry::dependence`]), and otherwise the operations of one processor.
fn in_a_leaf(points: &[DVec2], seed: Option<u64>, own: &mut Cost) -> Option<Vec<[u32; 3]>> {
    match Incremental::new(points.to_vec()) {
        Ok(built) => {
            match seed.and_then(|seed| Dependence::new(points, seed).ok()) {
                Some(made) => own.then(made.cost()),
                None => built.charge(own),
            }
            Some(built.cells().collect())
        }
        Err(IncrementalError::Flat { .. }) => Some(Vec::new()),
        Err(_) => None,
    }
}
