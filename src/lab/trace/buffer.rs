//! The recording of trace rows: a clock, a buffer for each thread, and the state that all threads share.
//!
//! A thread writes rows into its own buffer, so its rows are in the order of their times. It flushes the buffer to the
//! file when the buffer is full. Counters and the ids of arrows need an order among threads. They are created under a
//! common lock, which only messages, steps and the end of the trace take. Locks are nested in the order thread, shared,
//! processes, file.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use thread_local::ThreadLocal;
use tracing::span::Id;

use super::event::{Args, Event, FlowArgs, Track, Value, microseconds};
use super::messages::{Flights, Name};
use super::processes::{Lane, Processes};

/// Size in bytes at which a thread's buffer is flushed to the file.
const BOUND: usize = 1 << 16;

/// Rows in the order of their times.
#[derive(Debug, Default)]
struct Rows {
    text: Vec<u8>,
    last: u64,
}

impl Rows {
    /// Returns the time since `start` in microseconds, which is later than all previous times.
    fn now(&mut self, start: Instant) -> f64 {
        self.last = (start.elapsed().as_nanos() as u64).max(self.last + 1);
        microseconds(self.last)
    }

    fn push(&mut self, event: &Event<'_>) {
        write_row(&mut self.text, event);
    }
}

fn write_row(text: &mut Vec<u8>, event: &Event<'_>) {
    text.extend_from_slice(b",\n");
    // Events consist of numbers and text, so serialization cannot fail.
    let _ = serde_json::to_writer(text, event);
}

/// The state of one thread.
#[derive(Debug)]
struct Buffer {
    /// Index of the thread among the threads that wrote rows.
    slot: u64,
    rows: Rows,
    /// Slices that have begun but not ended.
    open: Vec<(Id, Track)>,
}

/// The state of all threads.
#[derive(Debug, Default)]
struct Shared {
    flights: Flights,
    /// Number of running steps in each run.
    active: std::collections::BTreeMap<u64, u64>,
    rows: Rows,
}

/// The file.
#[derive(Debug)]
struct Sink {
    file: Option<BufWriter<File>>,
    empty: bool,
    failed: Option<io::Error>,
}

impl Sink {
    fn write(&mut self, text: &[u8]) {
        let Some(file) = &mut self.file else { return };
        // The first row is not preceded by a comma.
        let skip = usize::from(self.empty);
        if self.failed.is_none() && text.len() > skip {
            self.empty = false;
            self.failed = file.write_all(&text[skip..]).err();
        }
    }

    fn empty_into(&mut self, text: &mut Vec<u8>) {
        self.write(text);
        text.clear();
    }
}

/// The recorder, which receives the events of the layer.
#[derive(Debug)]
pub(super) struct Recorder {
    start: Instant,
    threads: ThreadLocal<Mutex<Buffer>>,
    slots: AtomicU64,
    shared: Mutex<Shared>,
    processes: Mutex<Processes>,
    sink: Mutex<Sink>,
    done: AtomicBool,
}

/// Locks a mutex, even if it is poisoned: a panic in another thread leaves no row incomplete.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Recorder {
    /// Returns a recorder that writes to a file, and starts the clock.
    pub(super) fn new(file: File) -> Self {
        let mut file = BufWriter::new(file);
        let version = env!("CARGO_PKG_VERSION");
        let head = format!(
            "{{\"displayTimeUnit\":\"ms\",\"otherData\":{{\"program\":\"septet {version}\"}},\"traceEvents\":["
        );
        let failed = file.write_all(head.as_bytes()).err();
        Recorder {
            start: Instant::now(),
            threads: ThreadLocal::new(),
            slots: AtomicU64::new(0),
            shared: Mutex::default(),
            processes: Mutex::default(),
            sink: Mutex::new(Sink { file: Some(file), empty: true, failed }),
            done: AtomicBool::new(false),
        }
    }

    fn thread(&self) -> &Mutex<Buffer> {
        self.threads.get_or(|| {
            let slot = self.slots.fetch_add(1, Ordering::Relaxed);
            Mutex::new(Buffer { slot, rows: Rows::default(), open: Vec::new() })
        })
    }

    fn track(&self, run: u64, rank: u64, lane: Lane) -> Track {
        lock(&self.processes).track(run, rank, lane, &mut |event| self.write_now(event))
    }

    /// Writes a row to the file at once, because metadata must precede the rows that it describes.
    fn write_now(&self, event: &Event<'_>) {
        let mut text = Vec::new();
        write_row(&mut text, event);
        lock(&self.sink).write(&text);
    }

    fn relieve(&self, rows: &mut Rows) {
        if rows.text.len() > BOUND {
            lock(&self.sink).empty_into(&mut rows.text);
        }
    }

    /// Records the start of a run with this number of workers.
    pub(super) fn run(&self, run: u64, workers: u64, planning: bool) {
        lock(&self.processes).begin(run, workers, planning, &mut |event| self.write_now(event));
    }

    /// Returns the track for steps of a rank on this thread.
    pub(super) fn steps(&self, run: u64, rank: u64) -> Track {
        let slot = lock(self.thread()).slot;
        self.track(run, rank, Lane::Steps(slot))
    }

    /// Returns the track for the rounds of a rank.
    pub(super) fn rounds(&self, run: u64, rank: u64) -> Track {
        self.track(run, rank, Lane::Rounds)
    }

    /// Returns the track for the phases of a run.
    pub(super) fn phases(&self, run: u64) -> Track {
        self.track(run, 0, Lane::Phases)
    }

    /// Begins a slice on this thread.
    pub(super) fn begin(&self, id: &Id, track: Track, name: &str, cat: &'static str, args: &Args) {
        if self.done.load(Ordering::Relaxed) {
            return;
        }
        let buffer = &mut *lock(self.thread());
        let ts = buffer.rows.now(self.start);
        buffer.rows.push(&Event::Begin { name, cat, ts, track, args });
        buffer.open.push((id.clone(), track));
    }

    /// Ends a slice on this thread.
    pub(super) fn end(&self, id: &Id) {
        let buffer = &mut *lock(self.thread());
        let Some(at) = buffer.open.iter().rposition(|(open, _)| open == id) else { return };
        let (_, track) = buffer.open.remove(at);
        let ts = buffer.rows.now(self.start);
        buffer.rows.push(&Event::End { ts, track });
        self.relieve(&mut buffer.rows);
    }

    /// Records that a message was sent: an arrow begins in the slice of the sender.
    pub(super) fn sent(&self, name: Name, kind: &str, args: FlowArgs) {
        if self.done.load(Ordering::Relaxed) {
            return;
        }
        let (run, track) = (name.0, self.rounds(name.0, args.from));
        let buffer = &mut *lock(self.thread());
        let id = {
            let shared = &mut *lock(&self.shared);
            let id = shared.flights.leave(name, args.bytes);
            self.count(shared, run, "bytes", Value::InFlight(shared.flights.in_flight(run)));
            id
        };
        let ts = buffer.rows.now(self.start);
        buffer.rows.push(&Event::FlowStart { name: kind, cat: "message", id, ts, track, args });
        self.relieve(&mut buffer.rows);
    }

    /// Records that a message was received: its arrow ends in the slice of the receiver.
    pub(super) fn received(&self, name: Name, kind: &str, to: u64) {
        if self.done.load(Ordering::Relaxed) {
            return;
        }
        let (run, track) = (name.0, self.rounds(name.0, to));
        let buffer = &mut *lock(self.thread());
        let id = {
            let shared = &mut *lock(&self.shared);
            let Some(id) = shared.flights.arrive(name) else { return };
            self.count(shared, run, "bytes", Value::InFlight(shared.flights.in_flight(run)));
            id
        };
        let ts = buffer.rows.now(self.start);
        buffer.rows.push(&Event::FlowEnd { name: kind, cat: "message", id, bp: "e", ts, track });
        self.relieve(&mut buffer.rows);
    }

    /// Records the beginning or the end of a step at a node.
    pub(super) fn active(&self, run: u64, begins: bool) {
        if self.done.load(Ordering::Relaxed) {
            return;
        }
        let shared = &mut *lock(&self.shared);
        let active = shared.active.entry(run).or_default();
        *active = if begins { *active + 1 } else { active.saturating_sub(1) };
        let value = Value::Subproblems(*active);
        self.count(shared, run, "active", value);
    }

    fn count(&self, shared: &mut Shared, run: u64, name: &'static str, args: Value) {
        let track = self.rounds(run, 0);
        let ts = shared.rows.now(self.start);
        shared.rows.push(&Event::Counter { name, ts, track, args });
        self.relieve(&mut shared.rows);
    }

    /// Ends open slices and closes the file.
    pub(super) fn finish(&self) -> io::Result<File> {
        self.done.store(true, Ordering::Relaxed);
        for thread in &self.threads {
            let buffer = &mut *lock(thread);
            while let Some((_, track)) = buffer.open.pop() {
                let ts = buffer.rows.now(self.start);
                buffer.rows.push(&Event::End { ts, track });
            }
            lock(&self.sink).empty_into(&mut buffer.rows.text);
        }
        let shared = &mut *lock(&self.shared);
        let sink = &mut *lock(&self.sink);
        sink.empty_into(&mut shared.rows.text);
        if let Some(error) = sink.failed.take() {
            return Err(error);
        }
        let Some(mut file) = sink.file.take() else { return Err(io::ErrorKind::NotConnected.into()) };
        file.write_all(b"\n]}\n")?;
        file.into_inner().map_err(io::IntoInnerError::into_error)
    }
}
