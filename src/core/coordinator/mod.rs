//! The host of rank 0. It runs the coordinator against a transport, measures the phases, reports progress and handles
//! cancellation. The coordinator's program is [`septet_workers::coordinator`].

use std::sync::Arc;
use std::time::Instant;

use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::message::{PointBatch, PointSum};
use septet_protocol::transport::{HostState, Transport, TransportError};
use septet_workers::config::WorkerConfig;
use septet_workers::coordinator::{Share, Source};
use septet_workers::machine::Running;
use septet_workers::profile::{phase_span, run_span};
use septet_workers::programs::coordinate;

use crate::config::{Control, Progress};
use crate::error::Error;
use crate::input::prepare::Prepared;

pub(crate) use septet_workers::leader::Plan;

/// The result that the coordinator collected, with measured times.
#[derive(Debug)]
pub(crate) struct Collected<P> {
    /// The result.
    pub(crate) share: Share<P>,
    /// Wall-clock seconds of each phase, in order.
    pub(crate) seconds: Vec<(Phase, f64)>,
}

impl<P> Collected<P> {
    /// Checks that the ledgers of all ranks arrived, and that all messages arrived as they were sent.
    pub(crate) fn check_ledgers(&self, ranks: u32) -> Result<(), Error> {
        let arrived = self.share.counted.parts;
        if arrived != ranks {
            return Err(incomplete(format!("{arrived} of {ranks} ledgers arrived")));
        }
        if self.share.counted.ledger.balance != 0 {
            return Err(incomplete(
                "the messages that the ranks received are not those that were sent".into(),
            ));
        }
        Ok(())
    }
}

/// Returns the error for a result that is incomplete.
pub(crate) fn incomplete(reason: String) -> Error {
    TransportError::WorkerFailed { rank: COORDINATOR, reason }.into()
}

impl<P: Point> Source<P> for Prepared<'_, P> {
    fn population(&self) -> PointSum {
        self.sum()
    }

    fn frame(&self) -> Vec<(u64, P)> {
        self.frame.iter().map(|&i| (self.id(i), self.positions[i])).collect()
    }

    fn block(&self, block: u32, blocks: u32) -> PointBatch<P> {
        let n = self.positions.len() as u128;
        let share = |b: u32| (n * u128::from(b) / u128::from(blocks)) as usize;
        let range = share(block)..share(block + 1);
        // A worker later owns about as many points as its block has. The extra capacity is for the ghosts that it then
        // receives.
        let capacity = range.len() + range.len() / 8;
        let (mut ids, mut positions) = (Vec::with_capacity(capacity), Vec::with_capacity(capacity));
        ids.extend(self.ids(range.clone()));
        positions.extend_from_slice(&self.positions[range.clone()]);
        let radii2 = self.radii2.get(range).unwrap_or_default().to_vec();
        PointBatch { radii2: Bulk(radii2), ..PointBatch::in_transit(ids, positions) }
    }
}

/// The host of rank 0.
pub(crate) struct Coordinator<'a> {
    control: &'a Control,
    machine: Arc<WorkerConfig>,
}

impl<'a> Coordinator<'a> {
    pub(crate) fn new(control: &'a Control, machine: Arc<WorkerConfig>) -> Self {
        Coordinator { control, machine }
    }

    /// Runs rank 0 until the machine stops, and measures the phases.
    pub(crate) fn run<P: Point>(
        self,
        transport: &mut dyn Transport<P>,
        points: &Prepared<'_, P>,
        plan: &Plan,
    ) -> Result<Collected<P>, Error> {
        let Coordinator { control, machine } = self;
        let _run = run_span(&machine, points.positions.len() as u64);
        let failure = |error| match error {
            TransportError::Stopped if control.is_cancelled() => Error::Interrupted,
            error => error.into(),
        };
        let program = |cx| coordinate(cx, points as &dyn Source<P>, plan.clone());
        let mut rank = Running::start(COORDINATOR, machine.clone(), None, program);
        let mut span = phase_span(machine.run, rank.phase());
        let mut sent = rank.step();
        let (mut round, mut started, mut seconds) = (0, Instant::now(), Vec::new());
        while sent.is_err() || !rank.is_done() {
            let (outbox, state) = HostState::after(sent, rank.busy());
            // Like every rank, rank 0 reads the request to stop at each exchange. The round returns it on all hosts.
            let delivery = transport.exchange(outbox, state).map_err(failure)?;
            round += 1;
            if !delivery.active {
                add_seconds(&mut seconds, rank.phase(), started.elapsed().as_secs_f64());
                started = Instant::now();
            }
            rank.deliver(round, delivery.active.then_some(delivery.inbox));
            sent = rank.step();
            if !delivery.active {
                drop(span);
                span = phase_span(machine.run, rank.phase());
            }
            if let Some(progress) = &control.progress {
                let position = (rank.phase() as usize, Phase::ALL.len() - 1);
                progress(Progress { phase: rank.phase().name(), position, round });
            }
        }
        Ok(Collected { share: rank.into_result().unwrap_or_default(), seconds })
    }
}

/// Adds the seconds of a phase. A phase that runs in several passes has one entry.
fn add_seconds(all: &mut Vec<(Phase, f64)>, phase: Phase, seconds: f64) {
    match all.last_mut() {
        Some((last, sum)) if *last == phase => *sum += seconds,
        _ => all.push((phase, seconds)),
    }
}
