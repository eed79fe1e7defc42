//! The host of rank 0: it runs the coordinator against a transport, with the clock of the phases, progress and
//! cancellation. What the coordinator does is in [`septet_workers::coordinator`].

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{COORDINATOR, Phase, Rank};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::{Merged, PointBatch};
use septet_protocol::tasks::TaskLog;
use septet_protocol::transport::{HostState, Transport, TransportError};
use septet_workers::config::WorkerConfig;
use septet_workers::coordinator::{PieceRows, Share, Source};
use septet_workers::machine::Running;
use septet_workers::profile::{phase_span, run_span};
use septet_workers::programs::coordinate;

use crate::config::{Config, Progress};
use crate::error::Error;
use crate::input::prepare::Prepared;
use crate::result::pieces::{Loose, Piece};
use crate::result::view::Album;

pub(crate) use septet_workers::leader::Plan;

/// The result of a run as the coordinator collected it, with the seconds of its phases.
#[derive(Debug, Default)]
pub(crate) struct Collected {
    /// Pieces of a triangulation, in the order of their arrival.
    pub(crate) pieces: Vec<Loose>,
    /// Rows of cells, in the parts in which they arrived.
    pub(crate) cells: Vec<Vec<u64>>,
    pub(crate) owner: Vec<Rank>,
    pub(crate) leaves: Vec<u64>,
    pub(crate) edges: Vec<u64>,
    /// Members of an independent set, in the order of their arrival.
    pub(crate) members: Vec<u64>,
    /// Points undecided at the start of each of its rounds.
    pub(crate) undecided: Vec<u64>,
    pub(crate) ledger: LedgerPart,
    /// Workers whose part of the ledger has arrived.
    pub(crate) parts: u32,
    /// The picture.
    pub(crate) album: Album,
    pub(crate) merged: Merged,
    pub(crate) supergraph: Option<Supergraph>,
    pub(crate) why: Option<String>,
    /// The record of tasks, if the run keeps one.
    pub(crate) tasks: Option<Box<TaskLog>>,
    /// Number of points gathered when the exchange was cut short.
    pub(crate) fallback: Option<(String, u64)>,
    /// Wall-clock seconds of each phase, measured here.
    pub(crate) seconds: Vec<(Phase, f64)>,
}

impl Collected {
    fn of<P: Point>(share: Share<P>, seconds: Vec<(Phase, f64)>) -> Self {
        let loose = |PieceRows { owner, leaf, ids, rows, open }| {
            let seam = Vec::new();
            Loose { piece: Piece { owner, leaf, ids, rows, seam }, open }
        };
        let mut album = Album::default();
        for part in &share.views {
            album.add(part);
        }
        Collected {
            pieces: share.pieces.into_iter().map(loose).collect(),
            cells: share.cells.parts,
            owner: share.cells.owners,
            leaves: share.cells.leaves,
            edges: share.edges,
            members: share.selected.members,
            undecided: share.selected.undecided,
            ledger: share.counted.ledger,
            parts: share.counted.parts,
            album,
            merged: share.certified.merged,
            supergraph: share.choice.supergraph,
            why: share.choice.why,
            tasks: share.counted.tasks,
            fallback: share.certified.fallback,
            seconds,
        }
    }
}

impl<P: Point> Source<P> for Prepared<'_, P> {
    fn population(&self) -> u64 {
        self.positions.len() as u64
    }

    fn frame(&self) -> Vec<(u64, P)> {
        self.frame.iter().map(|&i| (self.id(i), self.positions[i])).collect()
    }

    fn block(&self, block: u32, blocks: u32) -> PointBatch<P> {
        let n = self.positions.len() as u128;
        let share = |b: u32| (n * u128::from(b) / u128::from(blocks)) as usize;
        let range = share(block)..share(block + 1);
        // With a little room: a worker receives about as many owned points, and then those near its border.
        let room = range.len() + range.len() / 8;
        let (mut ids, mut positions) = (Vec::with_capacity(room), Vec::with_capacity(room));
        ids.extend(self.ids(range.clone()));
        positions.extend_from_slice(&self.positions[range.clone()]);
        let radii2 = self.radii2.get(range).unwrap_or_default().to_vec();
        PointBatch { radii2: Bulk(radii2), ..PointBatch::in_transit(ids, positions) }
    }
}

/// The host of rank 0.
pub(crate) struct Coordinator<'a> {
    config: &'a Config,
    machine: Arc<WorkerConfig>,
}

impl<'a> Coordinator<'a> {
    pub(crate) fn new(config: &'a Config, machine: Arc<WorkerConfig>) -> Self {
        Coordinator { config, machine }
    }

    /// Runs the machine to its end: rank 0, and the clock of the phases.
    pub(crate) fn run<P: Point>(
        self,
        transport: &mut dyn Transport<P>,
        points: &Prepared<'_, P>,
        plan: &Plan,
    ) -> Result<Collected, Error> {
        let Coordinator { config, machine } = self;
        let _run = run_span(&machine, points.positions.len() as u64);
        let cancelled = || config.cancel.as_ref().is_some_and(|c| c.load(Ordering::Relaxed));
        let failure = |error| match error {
            TransportError::Stopped if cancelled() => Error::Interrupted,
            error => error.into(),
        };
        let program = |cx| coordinate(cx, points as &dyn Source<P>, plan.clone());
        let mut rank = Running::start(COORDINATOR, machine.clone(), None, program);
        let mut span = phase_span(machine.run, rank.phase());
        let mut sent = rank.step();
        let (mut round, mut started, mut seconds) = (0, Instant::now(), Vec::new());
        while sent.is_err() || !rank.is_done() {
            let (outbox, state) = HostState::after(sent, rank.busy());
            let delivery = transport.exchange(outbox, state).map_err(failure)?;
            if cancelled() {
                return Err(Error::Interrupted);
            }
            round += 1;
            if !delivery.active {
                time(&mut seconds, rank.phase(), started.elapsed().as_secs_f64());
                started = Instant::now();
            }
            rank.deliver(round, delivery.active.then_some(delivery.inbox));
            sent = rank.step();
            if !delivery.active {
                drop(span);
                span = phase_span(machine.run, rank.phase());
            }
            if let Some(progress) = &config.progress {
                let position = (rank.phase() as usize, Phase::ALL.len() - 1);
                progress(Progress { phase: rank.phase().name(), position, round });
            }
        }
        Ok(Collected::of(rank.into_result().unwrap_or_default(), seconds))
    }
}

/// Seconds of a phase; of one that runs in several passes, all of them.
fn time(all: &mut Vec<(Phase, f64)>, phase: Phase, seconds: f64) {
    match all.last_mut() {
        Some((last, sum)) if *last == phase => *sum += seconds,
        _ => all.push((phase, seconds)),
    }
}
