//! Runs a machine over an input, measures the phases, reports progress and handles cancellation.

use std::sync::Arc;
use std::time::Instant;

use tracing::span::EnteredSpan;

use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;
use septet_workers::config::{Stop, WorkerConfig};
use septet_workers::host::{Job, Watch};
use septet_workers::profile::{phase_span, run_span};
use septet_workers::share::Share;
use septet_workers::transport::{Machine, MachineError};

use crate::error::Error;
use crate::input::Held;
use crate::spec::{Control, Progress};

pub(crate) use septet_workers::leader::Plan;

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

    /// Runs the ranks of this process until the machine stops, and measures the phases.
    pub(crate) fn shares<P: Point>(
        self,
        machine: &mut dyn Machine<P>,
        Held { source, points, .. }: Held<'_, P>,
        plan: &Plan,
    ) -> Result<Returned<P>, Error> {
        let Coordinator { control, config } = self;
        let _run = run_span(&config, points.len() as u64);
        let mut log = PhaseLog {
            control,
            run: config.run,
            stop: config.stop.clone(),
            phase: None,
            span: None,
            started: Instant::now(),
            seconds: Vec::new(),
        };
        let stop = config.stop.clone();
        let job = Job { config, source, plan };
        let shares = machine.run(&job, &mut log).map_err(|error| match error {
            MachineError::Transport(TransportError::Stopped) if control.is_cancelled() => Error::Interrupted,
            MachineError::Transport(error) => error.into(),
            MachineError::Start(error) => error.into(),
        })?;
        stop.measure();
        stop.check()?;
        Ok(Returned { shares, seconds: log.seconds })
    }
}

/// The measured phases of a run.
struct PhaseLog<'a> {
    control: &'a Control,
    run: u64,
    stop: Stop,
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
        self.stop.measure();
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
