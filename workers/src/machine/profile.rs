//! What a run tells whoever listens: `tracing` spans and events, and nothing where nobody does.
//!
//! No clock is read here and nothing is written: a subscriber of the caller's does both (that of
//! `septet::trace` writes Chrome's JSON). Every span and event carries what tells it apart, so that none
//! needs its parents. Four targets, from coarse to fine:
//!
//! | target | level | span or event | fields |
//! |---|---|---|---|
//! | [`PHASE`] | INFO | span `run`, the coordinator's | run, workers, points, planning |
//! | | | span `phase`, the coordinator's | run, phase |
//! | | | span `stage`, of a whole that is made of runs | run, phase (its name) |
//! | [`ROUND`] | DEBUG | span `round`: what one rank does between two exchanges | run, phase, round, worker, messages (received), begins (does a phase begin with it?) |
//! | [`MESSAGE`] | TRACE | events `sent` and `received` | run, phase, from, to, round (of sending), sequence, bytes, kind, subproblem |
//! | [`SUBPROBLEM`] | TRACE | span `subproblem`: one step at one node of the tree | run, phase, round, worker, subproblem, step, points |
//!
//! `run` is [`crate::config::WorkerConfig::run`]; (run, from, sequence) names a message. A worker's messages to
//! itself are not told.

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::Message;
use tracing::span::EnteredSpan;
use tracing::{Level, Span};

use crate::config::WorkerConfig;

/// Target of runs and phases.
pub const PHASE: &str = "septet::phase";

/// Target of rounds.
pub const ROUND: &str = "septet::round";

/// Target of messages.
pub const MESSAGE: &str = "septet::message";

/// Target of steps at nodes of the tree.
pub const SUBPROBLEM: &str = "septet::subproblem";

/// Where something happens: a rank in a round.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// The run.
    pub run: u64,
    /// The rank.
    pub rank: Rank,
    /// The round.
    pub round: u32,
}

impl Site {
    /// Enters the span of what this rank does in this round. `received` messages start it, or, if none, the
    /// beginning of the phase. At the end of the run nothing is done.
    pub fn round(self, phase: Phase, received: Option<usize>) -> EnteredSpan {
        if phase == Phase::Done {
            return Span::none().entered();
        }
        tracing::debug_span!(
            target: ROUND,
            "round",
            run = self.run,
            phase = phase.name(),
            round = self.round,
            worker = self.rank,
            messages = received.unwrap_or(0),
            begins = received.is_none(),
        )
        .entered()
    }

    /// Enters the span of a step at a node of `points` points.
    pub fn subproblem(self, phase: Phase, node: NodeId, step: &'static str, points: u64) -> EnteredSpan {
        tracing::trace_span!(
            target: SUBPROBLEM,
            "subproblem",
            run = self.run,
            phase = phase.name(),
            round = self.round,
            worker = self.rank,
            subproblem = node.0,
            step,
            points,
        )
        .entered()
    }
}

/// Enters the span of a whole run on `points` points. The run is only `planning` where it stops early to learn
/// the tree.
pub fn run_span(config: &WorkerConfig, points: u64) -> EnteredSpan {
    let planning = config.until.is_some();
    tracing::info_span!(target: PHASE, "run", run = config.run, workers = config.workers, points, planning)
        .entered()
}

/// Enters the span of a phase, from the coordinator's first step in it to its first in the next.
pub fn phase_span(run: u64, phase: Phase) -> EnteredSpan {
    if phase == Phase::Done {
        return Span::none().entered();
    }
    tracing::info_span!(target: PHASE, "phase", run, phase = phase.name()).entered()
}

/// Enters the span of a stage of a larger whole, such as a mesh, whose runs bear this number: it holds those runs.
pub fn stage_span(run: u64, stage: &str) -> EnteredSpan {
    tracing::info_span!(target: PHASE, "stage", run, phase = stage).entered()
}

/// Tells of messages that leave.
pub fn sent<P: Point>(phase: Phase, messages: &[Message<P>]) {
    if tracing::enabled!(target: MESSAGE, Level::TRACE) {
        for message in messages {
            tell(phase, message, true);
        }
    }
}

/// Tells of messages that arrived.
pub fn received<P: Point>(phase: Phase, messages: &[Message<P>]) {
    if tracing::enabled!(target: MESSAGE, Level::TRACE) {
        for message in messages {
            tell(phase, message, false);
        }
    }
}

fn tell<P: Point>(phase: Phase, message: &Message<P>, leaves: bool) {
    macro_rules! event {
        ($name:literal) => {
            tracing::event!(
                name: $name,
                target: MESSAGE,
                Level::TRACE,
                run = message.run,
                phase = phase.name(),
                from = message.from,
                to = message.to,
                round = message.round,
                sequence = message.sequence,
                bytes = message.encoded_len(),
                kind = message.body.kind(),
                subproblem = message.node.0,
            )
        };
    }
    if leaves { event!("sent") } else { event!("received") }
}
