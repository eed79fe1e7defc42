//! What the generator asks for, as runs of the machine.
//!
//! An independent set is a run of [`crate::independent`], a triangulation one of [`crate::triangulate`]. Facets of at most
//! a leaf's points are leaves of a machine that has only those: they are triangulated where they are, side by side.

use std::time::Instant;

use glam::DVec2;
use rayon::prelude::*;
use septet_geometry::incremental::{Incremental, IncrementalError};
use septet_geometry::point::{Point, Simplex};
use septet_meshing::cores::Cores;
use septet_meshing::generate::{Machine, Stage, Triangulation};
use septet_meshing::mesh::StageLine;
use septet_meshing::points::conflicts::Site;
use septet_meshing::points::independent::Independent;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;
use septet_workers::profile::stage_span;
use tracing::span::EnteredSpan;

use super::record::{INDEPENDENT_SET, Record, TRIANGULATION};
use crate::config::Config;
use crate::error::Error;
use crate::run::independent::independent;
use crate::run::{TrafficTotal, triangulate};

/// Points up to which a facet is one leaf.
const LEAF: usize = 4096;

/// The machine with what each stage took.
#[derive(Debug)]
pub struct Counted {
    config: Config,
    lines: Vec<StageLine>,
    record: Record,
    owners: Owners,
    since: Instant,
    /// Told to whoever listens, as long as the stage goes on.
    span: Option<EnteredSpan>,
}

/// The worker of each cell of the last triangulation of the highest dimension.
#[derive(Debug, Default)]
struct Owners {
    dimension: usize,
    of: Vec<u32>,
}

/// What a run is recorded by.
struct Taken<'a> {
    task: &'static str,
    points: usize,
    fixed: usize,
    ledger: &'a Ledger,
    phase_seconds: &'a [(Phase, f64)],
    seconds: f64,
}

impl Counted {
    /// A machine of this configuration.
    pub fn new(config: Config) -> Self {
        Counted {
            config,
            lines: Vec::new(),
            record: Record::default(),
            owners: Owners::default(),
            since: Instant::now(),
            span: None,
        }
    }

    /// The workers of the cells of the last triangulation in this dimension, in its order; none if there was none of so
    /// many cells.
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
        let points = [taken.points as u64, taken.fixed as u64];
        self.record.add(&line.name, taken.task, points, ledger, taken.seconds);
        self.record.add_phases(&line.name, taken.task, ledger, taken.phase_seconds);
    }

    fn close(&mut self) {
        self.span = None;
        if let Some(line) = self.lines.last_mut() {
            line.seconds += self.since.elapsed().as_secs_f64();
        }
        self.since = Instant::now();
    }

    /// The lines with what the generator counted itself, and what the runs took one by one.
    pub(super) fn finish(mut self, stages: &[Stage]) -> (Vec<StageLine>, Record) {
        self.close();
        for (line, stage) in self.lines.iter_mut().zip(stages) {
            line.candidates = stage.candidates;
            line.points = stage.points;
            line.completion_rounds = u64::from(stage.completion);
            line.set_rounds = u64::from(stage.set_rounds);
        }
        (self.lines, self.record)
    }
}

impl<P: Point> Machine<P> for Counted {
    type Error = Error;

    fn stage(&mut self, name: &'static str) {
        self.close();
        self.span = Some(stage_span(self.config.machine.name(), name));
        self.lines.push(StageLine { name: name.to_string(), ..StageLine::default() });
    }

    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, Error> {
        let places: Vec<P> = sites.iter().map(|s| s.at).collect();
        let sizes: Vec<f64> = sites.iter().map(|s| s.size).collect();
        let run = independent(&places, &sizes, fixed, &self.config)?;
        self.add(&Taken {
            task: INDEPENDENT_SET,
            points: sites.len(),
            fixed,
            ledger: &run.ledger,
            phase_seconds: &run.phase_seconds,
            seconds: run.seconds,
        });
        Ok(Independent {
            members: run.members.into_iter().map(|m| m as u32).collect(),
            undecided: run.undecided,
        })
    }

    fn delaunay(&mut self, points: &[P]) -> Result<Triangulation<P::Cell>, Error> {
        let run = triangulate(points, &self.config)?;
        self.add(&Taken {
            task: TRIANGULATION,
            points: points.len(),
            fixed: 0,
            ledger: &run.ledger,
            phase_seconds: &run.phase_seconds,
            seconds: run.total_seconds,
        });
        let (mut cells, mut neighbours) = (Vec::new(), Vec::new());
        let Some(pieces) = run.pieces() else { return Ok(Triangulation { cells, neighbours }) };
        cells.reserve(pieces.len());
        neighbours.reserve(pieces.len());
        let mut first = Vec::new();
        let mut count = 0;
        for piece in pieces.pieces() {
            first.push(count);
            count += (piece.rows.len() / (2 * P::Cell::LEN)) as u32;
        }
        if P::DIM >= self.owners.dimension {
            let of = pieces.pieces().iter();
            let of = of.flat_map(|p| vec![p.owner; p.rows.len() / (2 * P::Cell::LEN)]).collect();
            self.owners = Owners { dimension: P::DIM, of };
        }
        for (p, piece) in (0u32..).zip(pieces.pieces()) {
            for (c, row) in (0u32..).zip(piece.rows.chunks_exact(2 * P::Cell::LEN)) {
                let (mut cell, mut across) = (P::Cell::splat(0), P::Cell::splat(u32::MAX));
                for (slot, &v) in row[..P::Cell::LEN].iter().enumerate() {
                    cell.as_mut()[slot] = piece.ids[v as usize] as u32;
                    if let Some((q, d)) = pieces.neighbour(p, c, slot) {
                        across.as_mut()[slot] = first[q as usize] + d;
                    }
                }
                cells.push(cell);
                neighbours.push(across);
            }
        }
        Ok(Triangulation { cells, neighbours })
    }

    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, Error> {
        let small = |set: &Vec<DVec2>| (set.len() <= LEAF).then(|| in_a_leaf(set));
        let mut made: Vec<Option<Vec<[u32; 3]>>> = sets.par_iter().map(small).map(Option::flatten).collect();
        for (set, made) in sets.iter().zip(&mut made).filter(|(_, made)| made.is_none()) {
            *made = Some(Machine::<DVec2>::delaunay(self, set)?.cells);
        }
        Ok(made.into_iter().map(Option::unwrap_or_default).collect())
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        AllCores.map(items, f)
    }
}

/// The threads of the global pool, for what needs no machine.
#[derive(Clone, Copy, Debug)]
pub(super) struct AllCores;

impl Cores for AllCores {
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        items.par_iter().map(f).collect()
    }
}

/// The triangles of a leaf; nothing if they are for the machine to find, or to say why there are none.
fn in_a_leaf(points: &[DVec2]) -> Option<Vec<[u32; 3]>> {
    match Incremental::new(points.to_vec()) {
        Ok(built) => Some(built.cells().collect()),
        Err(IncrementalError::Flat { .. }) => Some(Vec::new()),
        Err(_) => None,
    }
}
