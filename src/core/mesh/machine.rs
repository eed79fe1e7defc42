//! Implements the machine of the generator by runs of `septet`.
//!
//! An independent set is a run of [`crate::independent`], and a triangulation is a run of [`crate::triangulate`]. A
//! facet with at most `LEAF` points would be a single leaf of its machine. Such facets are triangulated locally and in
//! parallel.

use std::time::Instant;

use glam::DVec2;
use septet_geometry::incremental::{Incremental, IncrementalError};
use septet_geometry::point::{Point, Simplex};
use septet_meshing::executor::Executor;
use septet_meshing::generate::{Delaunay, MeshMachine, StageCounts};
use septet_meshing::mesh::StageLine;
use septet_meshing::points::conflicts::Site;
use septet_meshing::points::independent::Independent;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;
use septet_workers::config::cores;
use septet_workers::profile::stage_span;
use tracing::span::EnteredSpan;

use super::run_log::{INDEPENDENT_SET, RunLog, SiteCounts, TRIANGULATION};
use crate::error::Error;
use crate::result::outcome::{Selection, TrafficTotal};
use crate::result::share::Neighbour;
use crate::run::calls::{independent, triangulate};
use crate::spec::Spec;

/// The largest number of points of a facet that is one leaf.
const LEAF: usize = 4096;

/// A machine that counts the resources of each stage.
#[derive(Debug)]
pub struct CountedMachine {
    spec: Spec,
    lines: Vec<StageLine>,
    run_log: RunLog,
    owners: Owners,
    since: Instant,
    /// The span of the current stage, for subscribers.
    span: Option<EnteredSpan>,
}

/// The worker of each cell of the last triangulation of the highest dimension.
#[derive(Debug, Default)]
struct Owners {
    dimension: usize,
    of: Vec<u32>,
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
    /// Creates a machine with this configuration.
    pub fn new(spec: Spec) -> Self {
        CountedMachine {
            spec,
            lines: Vec::new(),
            run_log: RunLog::default(),
            owners: Owners::default(),
            since: Instant::now(),
            span: None,
        }
    }

    /// Returns the worker of each cell of the last triangulation in this dimension, in its order. Returns `None` if
    /// that triangulation did not have `cells` cells.
    pub(super) fn owners(&self, dimension: usize, cells: usize) -> Option<&[u32]> {
        let Owners { dimension: of, of: owners } = &self.owners;
        (*of == dimension && owners.len() == cells).then_some(owners)
    }

    fn add(&mut self, taken: &Taken<'_>) {
        let Some(line) = self.lines.last_mut() else { return };
        let ledger = taken.ledger;
        let TrafficTotal { rounds, messages, bytes } = TrafficTotal::of(ledger);
        line.rounds += rounds;
        line.messages += messages;
        line.bytes += bytes;
        line.work += ledger.phases.iter().map(|p| p.work).sum::<u64>();
        line.depth += ledger.phases.iter().map(|p| p.critical_depth).sum::<u64>();
        let sites = SiteCounts { points: taken.points as u64, fixed: taken.fixed as u64 };
        self.run_log.add(&line.name, taken.task, sites, ledger, taken.seconds);
        self.run_log.add_phases(&line.name, taken.task, ledger, taken.phase_seconds);
    }

    fn close(&mut self) {
        self.span = None;
        if let Some(line) = self.lines.last_mut() {
            line.seconds += self.since.elapsed().as_secs_f64();
        }
        self.since = Instant::now();
    }

    /// Adds the counts of the generator to the lines. Returns the lines and the log of all runs.
    pub(super) fn finish(mut self, stages: &[StageCounts]) -> (Vec<StageLine>, RunLog) {
        self.close();
        for (line, stage) in self.lines.iter_mut().zip(stages) {
            line.candidates = stage.candidates;
            line.points = stage.points;
            line.completion_rounds = u64::from(stage.completion);
            line.set_rounds = u64::from(stage.set_rounds);
        }
        (self.lines, self.run_log)
    }
}

impl<P: Point> MeshMachine<P> for CountedMachine {
    type Error = Error;

    fn stage(&mut self, name: &'static str) {
        self.close();
        self.span = Some(stage_span(self.spec.machine.name(), name));
        self.lines.push(StageLine { name: name.to_string(), ..StageLine::default() });
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
        let run = triangulate(points, &self.spec)?;
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
        let small = |set: &Vec<DVec2>| (set.len() <= LEAF).then(|| in_a_leaf(set));
        let mut made: Vec<Option<Vec<[u32; 3]>>> = cores::map(sets, |set| small(set).flatten());
        for (set, made) in sets.iter().zip(&mut made).filter(|(_, made)| made.is_none()) {
            *made = Some(MeshMachine::<DVec2>::delaunay(self, set)?.cells);
        }
        Ok(made.into_iter().map(Option::unwrap_or_default).collect())
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        AllCores.map(items, f)
    }
}

/// Maps with the threads of the global pool, for computations without a machine.
#[derive(Clone, Copy, Debug)]
pub(super) struct AllCores;

impl Executor for AllCores {
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        cores::map(items, f)
    }
}

/// Triangulates a leaf. Returns `None` on an error, so that the machine triangulates the facet or reports the error.
fn in_a_leaf(points: &[DVec2]) -> Option<Vec<[u32; 3]>> {
    match Incremental::new(points.to_vec()) {
        Ok(built) => Some(built.cells().collect()),
        Err(IncrementalError::Flat { .. }) => Some(Vec::new()),
        Err(_) => None,
    }
}
