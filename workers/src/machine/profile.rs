//! Traces of a run: `tracing` spans and events, which cost nothing without a subscriber.
//!
//! This module reads no clock and writes no output. The caller's subscriber does both; the subscriber of
//! `septet::trace` writes Chrome's JSON. Every span and event carries the fields that identify it, so a subscriber
//! does not need its parents. There are four targets, from coarse to fine:
//!
//! | target | level | span or event | fields |
//! |---|---|---|---|
//! | [`PHASE`] | INFO | span `run`, on the coordinator | run, workers, points, planning |
//! | | | span `phase`, on the coordinator | run, phase |
//! | | | span `stage`, a part of a task that consists of several runs | run, phase (its name) |
//! | [`ROUND`] | DEBUG | span `round`: the work of one rank between two exchanges | run, phase, round, worker, messages (received), begins (whether a phase begins with it) |
//! | [`MESSAGE`] | TRACE | events `sent` and `received` | run, phase, from, to, round (of sending), sequence, bytes, kind, subproblem |
//! | [`SUBPROBLEM`] | TRACE | span `subproblem`: one step at one node of the tree | run, phase, round, worker, subproblem, step, points |
//!
//! `run` is [`crate::config::WorkerConfig::run`]. The triple (run, from, sequence) identifies a message. Messages of a
//! worker to itself are not traced.

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

/// A rank in a round of a run.
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
    /// Enters the span of this rank's work in this round. The round starts with `received` messages, or with the beginning
    /// of the phase if `received` is `None`. Returns an empty span at the end of the run.
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

/// Enters the span of a run on `points` points. The run is `planning` if it stops after a phase to determine the tree.
pub fn run_span(config: &WorkerConfig, points: u64) -> EnteredSpan {
    let planning = config.until.is_some();
    tracing::info_span!(target: PHASE, "run", run = config.run, workers = config.workers, points, planning)
        .entered()
}

/// Enters the span of a phase, from the coordinator's first step in this phase to its first step in the next phase.
pub fn phase_span(run: u64, phase: Phase) -> EnteredSpan {
    if phase == Phase::Done {
        return Span::none().entered();
    }
    tracing::info_span!(target: PHASE, "phase", run, phase = phase.name()).entered()
}

/// Enters the span of a stage of a task such as a mesh. The span contains the runs of the stage, and `run` is their
/// common number.
pub fn stage_span(run: u64, stage: &str) -> EnteredSpan {
    tracing::info_span!(target: PHASE, "stage", run, phase = stage).entered()
}

/// Traces the messages that a rank sends.
pub fn sent<P: Point>(phase: Phase, messages: &[Message<P>]) {
    if tracing::enabled!(target: MESSAGE, Level::TRACE) {
        for message in messages {
            trace(phase, message, Direction::Sent);
        }
    }
}

/// Traces the messages that a rank receives.
pub fn received<P: Point>(phase: Phase, messages: &[Message<P>]) {
    if tracing::enabled!(target: MESSAGE, Level::TRACE) {
        for message in messages {
            trace(phase, message, Direction::Received);
        }
    }
}

/// The direction of a traced message.
#[derive(Clone, Copy)]
enum Direction {
    Sent,
    Received,
}

fn trace<P: Point>(phase: Phase, message: &Message<P>, direction: Direction) {
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
    match direction {
        Direction::Sent => event!("sent"),
        Direction::Received => event!("received"),
    }
}
