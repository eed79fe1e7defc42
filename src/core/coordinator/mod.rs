//! Runs a machine over an input, measures the phases, reports progress and handles cancellation.

use std::sync::Arc;
use std::time::Instant;

use tracing::span::EnteredSpan;

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::transport::TransportError;
use septet_workers::config::WorkerConfig;
use septet_workers::host::{Job, Watch};
use septet_workers::input::Source;
use septet_workers::profile::{phase_span, run_span};
use septet_workers::share::{Certificate, Choice, Share, merged_ledger};
use septet_workers::transport::{Machine, MachineError};

use crate::error::{Error, incomplete};
use crate::input::{Prepared, Whole};
use crate::spec::{Control, Progress};

pub(crate) use septet_workers::leader::Plan;

/// The results of all ranks, with measured times.
#[derive(Debug)]
pub(crate) struct Collected<P> {
    /// The input, as the ranks prepared it.
    pub(crate) input: Prepared,
    /// The shares of all ranks, in the order of the ranks.
    pub(crate) shares: Vec<Share<P>>,
    /// The merged ledgers of all ranks.
    pub(crate) ledger: LedgerPart,
    /// The certificate.
    pub(crate) certified: Certificate,
    /// The supergraph.
    pub(crate) choice: Choice,
    /// Wall-clock seconds of each phase, in order.
    pub(crate) seconds: Vec<(Phase, f64)>,
}

impl<P> Collected<P> {
    /// Merges the ledgers of these `ranks`, and takes the certificate and the choice from the share of the coordinator.
    fn of(
        mut shares: Vec<Share<P>>,
        config: &WorkerConfig,
        seconds: Vec<(Phase, f64)>,
    ) -> Result<Self, Error> {
        let (arrived, ranks) = (shares.len(), config.ranks());
        if arrived != ranks as usize {
            return Err(incomplete(format!("the machine returned the shares of {arrived} of {ranks} ranks")));
        }
        let ledger = merged_ledger(shares.iter().map(|share| &share.ledger.part), config.fault);
        // A message that changed on its way could make the ranks refuse a valid input.
        let input = match Prepared::of(&mut shares, config) {
            Err(Error::Points(_)) if ledger.balance != 0 => return Err(unbalanced()),
            input => input?,
        };
        let Some(first) = shares.first().filter(|share| share.rank == COORDINATOR) else {
            return Err(incomplete("the share of the coordinator is missing".to_string()));
        };
        if shares.iter().any(|share| share.certified.totals != first.certified.totals) {
            return Err(incomplete("the ranks have different totals of the run".to_string()));
        }
        let first = &mut shares[0];
        let certified = std::mem::take(&mut first.certified);
        let choice = std::mem::take(&mut first.choice);
        Ok(Collected { input, shares, ledger, certified, choice, seconds })
    }

    /// Checks that the ranks received the messages that were sent.
    ///
    /// # Errors
    /// Fails if the hashes of sent and received messages do not balance.
    pub(crate) fn check_balance(&self) -> Result<(), Error> {
        if self.ledger.balance == 0 { Ok(()) } else { Err(unbalanced()) }
    }
}

/// Returns the error for messages that changed or vanished.
pub(crate) fn unbalanced() -> Error {
    incomplete("the messages that the ranks received are not those that were sent".to_string())
}

/// The rows of this process.
pub(crate) struct Held<'a, P> {
    /// The source of the rows.
    pub(crate) source: &'a dyn Source<P>,
    /// Number of rows.
    pub(crate) rows: u64,
}

/// The shares that a machine returned, with measured times.
pub(crate) struct Returned<P> {
    /// The shares of the ranks of this process.
    pub(crate) shares: Vec<Share<P>>,
    /// Wall-clock seconds of each phase, in order.
    pub(crate) seconds: Vec<(Phase, f64)>,
}

/// A run of a machine, as its caller observes it.
pub(crate) struct Coordinator<'a> {
    control: &'a Control,
    config: Arc<WorkerConfig>,
}

impl<'a> Coordinator<'a> {
    pub(crate) fn new(control: &'a Control, config: Arc<WorkerConfig>) -> Self {
        Coordinator { control, config }
    }

    /// Runs all ranks until the machine stops, and measures the phases.
    pub(crate) fn run<P: Point>(
        self,
        machine: &mut dyn Machine<P>,
        input: Whole<'_, P>,
        plan: &Plan,
    ) -> Result<Collected<P>, Error> {
        let config = self.config.clone();
        let rows = input.positions.len() as u64;
        let Returned { shares, seconds } = self.shares(machine, Held { source: &input, rows }, plan)?;
        Collected::of(shares, &config, seconds)
    }

    /// Runs the ranks of this process until the machine stops, and measures the phases.
    pub(crate) fn shares<P: Point>(
        self,
        machine: &mut dyn Machine<P>,
        Held { source, rows }: Held<'_, P>,
        plan: &Plan,
    ) -> Result<Returned<P>, Error> {
        let Coordinator { control, config } = self;
        let _run = run_span(&config, rows);
        let mut log = PhaseLog {
            control,
            run: config.run,
            phase: None,
            span: None,
            started: Instant::now(),
            seconds: Vec::new(),
        };
        let job = Job { config, source, plan };
        let shares = machine.run(&job, &mut log).map_err(|error| match error {
            MachineError::Transport(TransportError::Stopped) if control.is_cancelled() => Error::Interrupted,
            MachineError::Transport(error) => error.into(),
            MachineError::Start(error) => error.into(),
        })?;
        Ok(Returned { shares, seconds: log.seconds })
    }
}

/// The measured phases of a run.
struct PhaseLog<'a> {
    control: &'a Control,
    run: u64,
    /// The current phase.
    phase: Option<Phase>,
    span: Option<EnteredSpan>,
    started: Instant,
    seconds: Vec<(Phase, f64)>,
}

impl Watch for PhaseLog<'_> {
    fn phase_ends(&mut self, phase: Phase) {
        add_seconds(&mut self.seconds, phase, self.started.elapsed().as_secs_f64());
        self.started = Instant::now();
    }

    fn phase_begins(&mut self, phase: Phase) {
        // A phase with several passes is one span.
        if self.phase != Some(phase) {
            self.span = None;
            self.span = Some(phase_span(self.run, phase));
            self.phase = Some(phase);
        }
    }

    fn round(&mut self, round: u32, phase: Phase) {
        if let Some(progress) = &self.control.progress {
            let position = (phase as usize, Phase::ALL.len() - 1);
            progress(Progress { phase: phase.name(), position, round });
        }
    }
}

/// Adds the seconds of a phase. A phase that runs in several passes has one entry.
fn add_seconds(all: &mut Vec<(Phase, f64)>, phase: Phase, seconds: f64) {
    match all.last_mut() {
        Some((last, sum)) if *last == phase => *sum += seconds,
        _ => all.push((phase, seconds)),
    }
}
