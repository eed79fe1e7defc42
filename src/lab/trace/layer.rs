//! The layer, which converts spans and events to slices, arrows and counters.

use std::sync::Arc;

use septet_protocol::ids::Phase;
use septet_workers::profile::{MESSAGE, PHASE, ROUND, SUBPROBLEM};
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing::{Event, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;
use tracing_subscriber::registry::LookupSpan;

use super::buffer::Recorder;
use super::event::{Args, FlowArgs};

/// The fields of a span or event. Missing fields are zero.
#[derive(Debug, Default)]
struct Fields {
    run: u64,
    phase: String,
    round: u64,
    worker: u64,
    workers: u64,
    messages: u64,
    subproblem: u64,
    points: u64,
    from: u64,
    to: u64,
    sequence: u64,
    bytes: u64,
    /// `step` or `kind`.
    what: String,
    /// `begins` or `planning`.
    flag: bool,
}

impl Visit for Fields {
    fn record_u64(&mut self, field: &Field, value: u64) {
        let place = match field.name() {
            "run" => &mut self.run,
            "round" => &mut self.round,
            "worker" => &mut self.worker,
            "workers" => &mut self.workers,
            "messages" => &mut self.messages,
            "subproblem" => &mut self.subproblem,
            "points" => &mut self.points,
            "from" => &mut self.from,
            "to" => &mut self.to,
            "sequence" => &mut self.sequence,
            "bytes" => &mut self.bytes,
            _ => return,
        };
        *place = value;
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        let place = if field.name() == "phase" { &mut self.phase } else { &mut self.what };
        value.clone_into(place);
    }

    fn record_bool(&mut self, _: &Field, value: bool) {
        self.flag = value;
    }

    fn record_debug(&mut self, _: &Field, _: &dyn std::fmt::Debug) {}
}

/// The kind of a slice, which determines its track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Phase,
    Round,
    Step,
}

/// A span and its row, which is written when the span is entered.
#[derive(Debug)]
struct Slice {
    kind: Kind,
    run: u64,
    rank: u64,
    name: String,
    args: Args,
}

impl Slice {
    fn phase(name: &str, fields: Fields) -> Self {
        let is_run = name == "run";
        let args = Args {
            run: fields.run,
            workers: is_run.then_some(fields.workers),
            points: is_run.then_some(fields.points),
            group: Phase::from_name(&fields.phase).filter(|_| !is_run).map(Phase::group),
            ..Args::default()
        };
        let name = if is_run { "run".to_owned() } else { fields.phase };
        Slice { kind: Kind::Phase, run: fields.run, rank: 0, name, args }
    }

    fn round(fields: Fields) -> Self {
        let suffix = match (fields.flag, fields.messages) {
            (true, _) => ": begin",
            (false, 0) => ": idle",
            _ => "",
        };
        let name = format!("{}{suffix}", fields.phase);
        let args = Args {
            run: fields.run,
            phase: Some(fields.phase),
            round: Some(fields.round),
            worker: Some(fields.worker),
            messages: Some(fields.messages),
            ..Args::default()
        };
        Slice { kind: Kind::Round, run: fields.run, rank: fields.worker, name, args }
    }

    fn step(fields: Fields) -> Self {
        let args = Args {
            run: fields.run,
            phase: Some(fields.phase),
            round: Some(fields.round),
            worker: Some(fields.worker),
            subproblem: Some(fields.subproblem),
            points: Some(fields.points),
            ..Args::default()
        };
        Slice { kind: Kind::Step, run: fields.run, rank: fields.worker, name: fields.what, args }
    }
}

/// The layer. It passes spans and events on to the recorder.
pub(super) struct ChromeLayer {
    recorder: Arc<Recorder>,
}

impl ChromeLayer {
    pub(super) fn new(recorder: Arc<Recorder>) -> Self {
        ChromeLayer { recorder }
    }
}

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for ChromeLayer {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let mut fields = Fields::default();
        attributes.record(&mut fields);
        let metadata = attributes.metadata();
        let slice = match metadata.target() {
            PHASE => {
                if metadata.name() == "run" {
                    self.recorder.run(fields.run, fields.workers, fields.flag);
                }
                Slice::phase(metadata.name(), fields)
            }
            ROUND => Slice::round(fields),
            SUBPROBLEM => Slice::step(fields),
            _ => return,
        };
        span.extensions_mut().insert(slice);
    }

    fn on_enter(&self, id: &Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let extensions = span.extensions();
        let Some(slice) = extensions.get::<Slice>() else { return };
        let recorder = &self.recorder;
        let (track, category) = match slice.kind {
            Kind::Phase => (recorder.phases(slice.run), "phase"),
            Kind::Round => (recorder.rounds(slice.run, slice.rank), "round"),
            Kind::Step => (recorder.steps(slice.run, slice.rank), "subproblem"),
        };
        recorder.begin(id, track, &slice.name, category, &slice.args);
        if slice.kind == Kind::Step {
            recorder.active(slice.run, true);
        }
    }

    fn on_exit(&self, id: &Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let extensions = span.extensions();
        let Some(slice) = extensions.get::<Slice>() else { return };
        self.recorder.end(id);
        if slice.kind == Kind::Step {
            self.recorder.active(slice.run, false);
        }
    }

    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let metadata = event.metadata();
        if metadata.target() != MESSAGE {
            return;
        }
        let mut fields = Fields::default();
        event.record(&mut fields);
        let name = (fields.run, fields.from, fields.sequence);
        if metadata.name() == "sent" {
            let Fields { from, to, round, bytes, subproblem, .. } = fields;
            self.recorder.sent(name, &fields.what, FlowArgs { from, to, round, bytes, subproblem });
        } else {
            self.recorder.received(name, &fields.what, fields.to);
        }
    }
}
