//! Traces: their rules read row by row here, and as a whole by Perfetto's own trace processor.

mod perfetto;
mod rules;

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use septet_core::spec::{Correction, Progress, Workers};
use septet_core::{Outcome, Spec, simulate};
use septet_lab::trace::{Detail, layer};
use tracing_subscriber::layer::SubscriberExt;

use septet_common::sets::space;
use septet_common::{assert_same_counts, simulated, threaded};
use septet_core::generate::Kind as Points;

/// One test at a time: `tracing` keeps for each event of the program whether anybody listens, and decides it by
/// the thread that comes by first; a test without a listener would decide it for one with.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does the work with a trace in this scope alone.
fn traced<T>(path: &Path, detail: Detail, work: impl FnOnce() -> T) -> T {
    let (layer, file) = layer(path, detail).unwrap();
    let done = tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), work);
    assert!(!path.exists(), "the trace has its name before it is finished");
    assert_eq!(file.finish().unwrap(), path);
    done
}

/// A traced run, and the number of its exchanges.
fn counted_run(path: &Path, points: &[DVec3], spec: &Spec) -> (Outcome, u64) {
    let exchanges = Arc::new(AtomicU64::new(0));
    let counter = exchanges.clone();
    let spec = spec.clone().with(|c| {
        c.control.progress =
            Some(Arc::new(move |seen: Progress| counter.store(seen.round.into(), Ordering::Relaxed)));
    });
    let run = traced(path, Detail::default(), || simulate(points, &spec));
    (run.unwrap(), exchanges.load(Ordering::Relaxed))
}

/// One slice between any two exchanges for each worker, one arrow for each message.
fn assert_complete(path: &Path, run: &Outcome, exchanges: u64) {
    let workers = u64::from(run.settled.workers);
    let messages: u64 = run.ledger.phases.iter().map(|p| p.messages).sum();
    let seen = rules::read(path);
    for rank in 0..=workers {
        assert_eq!(seen.slices[&(rank + 1, "round".to_owned())], exchanges, "rank {rank}");
    }
    assert_eq!(seen.arrows, messages);
    assert_eq!(seen.last["bytes in flight"], 0);
    assert_eq!(seen.last["active subproblems"], 0);
}

/// The same by Perfetto, and its steps are those that the rules find.
fn assert_read_by_perfetto(path: &Path, run: &Outcome, exchanges: u64) {
    assert_complete(path, run, exchanges);
    let seen = rules::read(path);
    let (workers, messages) = (u64::from(run.settled.workers), seen.arrows);
    let perfetto = perfetto::read(path);
    assert_eq!(perfetto.faults(), Vec::<String>::new());
    assert_eq!(perfetto.overlaps(), 0);
    assert_eq!(perfetto.processes().len() as u64, workers + 1);
    for (rank, (pid, name, place)) in (0u64..).zip(perfetto.processes()) {
        let expected = if rank == 0 { "coordinator".to_owned() } else { format!("worker {rank}") };
        assert_eq!((pid, name, place), (rank + 1, expected, rank + 1));
        assert_eq!(perfetto.slices(pid, "rounds", "round"), exchanges, "rank {rank}");
    }
    let steps: u64 = seen.slices.iter().filter(|s| s.0.1 == "subproblem").map(|s| s.1).sum();
    assert_eq!(perfetto.slices_of("subproblem"), steps);
    assert_eq!(perfetto.flows(), [messages; 5]);
    assert_eq!(perfetto.last("bytes in flight"), 0);
    assert_eq!(perfetto.last("active subproblems"), 0);
    // Nothing was left open: Perfetto gives a slice without an end the duration -1.
    assert!(perfetto.shortest() >= 0);
}

/// Checks a trace of a run, which made this number of exchanges.
type Check = fn(&Path, &Outcome, u64);

#[test]
fn a_trace_of_a_large_run_is_complete_and_small() {
    large_run(assert_complete);
}

#[test]
#[ignore = "needs Node.js and Perfetto's trace processor"]
fn perfetto_reads_a_trace_of_a_large_run() {
    large_run(assert_read_by_perfetto);
}

fn large_run(check: Check) {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("trace.json");
    let spec = septet_common::base().with(|c| {
        c.machine.workers = Workers::Count(16);
        c.machine.threads = Some(2);
    });
    let (run, exchanges) = counted_run(&path, &space(Points::Uniform, 100_000, 3), &spec);
    assert!(fs::metadata(&path).unwrap().len() < 100_000_000);
    check(&path, &run, exchanges);
}

#[test]
fn every_transport_and_any_threads_are_heard() {
    several_runs(assert_complete);
}

#[test]
#[ignore = "needs Node.js and Perfetto's trace processor"]
fn perfetto_reads_traces_of_every_transport() {
    several_runs(assert_read_by_perfetto);
}

fn several_runs(check: Check) {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let points = space(Points::Clusters, 3000, 8);
    let configs = [
        simulated(Workers::Count(7), 5, 200),
        threaded(Workers::Count(7), 3, 200),
        // Cores to itself: steps in threads of a pool.
        threaded(Workers::Count(1), 3, 200),
        threaded(Workers::Count(2), 4, 200),
        // A phase in several passes.
        simulated(Workers::Count(5), 5, 200).with(|c| c.recursion.neighbours = Correction::BottomUp),
    ];
    for (i, spec) in configs.iter().enumerate() {
        let path = directory.path().join(format!("{i}.json"));
        let (run, exchanges) = counted_run(&path, &points, spec);
        check(&path, &run, exchanges);
    }
}

#[test]
fn details_add_up_and_change_nothing() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let points = space(Points::Uniform, 2000, 4);
    let spec = simulated(Workers::Count(4), 1, 200);
    let silent = simulate(&points, &spec).unwrap();
    let details = [Detail::Phase, Detail::Round, Detail::Message, Detail::Subproblem];
    for (i, detail) in details.into_iter().enumerate() {
        let path = directory.path().join(format!("{i}.json"));
        let run = traced(&path, detail, || simulate(&points, &spec)).unwrap();
        assert!(run.cells() == silent.cells());
        assert_same_counts(&run.ledger, &silent.ledger, "with a trace");
        let seen = rules::read(&path);
        let has = |category: &str| seen.slices.keys().any(|k| k.1 == category);
        // The run and its phases.
        assert_eq!(seen.slices[&(1, "phase".to_owned())], run.times.phases.len() as u64 + 1);
        assert_eq!(has("round"), detail >= Detail::Round);
        assert_eq!(seen.arrows > 0, detail >= Detail::Message);
        assert_eq!(seen.last.contains_key("bytes in flight"), detail >= Detail::Message);
        assert_eq!(has("subproblem"), detail >= Detail::Subproblem);
        assert_eq!(seen.last.contains_key("active subproblems"), detail >= Detail::Subproblem);
        if detail == Detail::Subproblem {
            let splits = run.ledger.part.nodes.values().filter(|f| f.attempts > 0).count();
            let drawn = seen.names["split"] + seen.names["draw"];
            assert!(drawn >= splits as u64, "{drawn} steps for {splits} splits");
        }
    }
}

#[test]
fn traces_distinguish_runs() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("trace.json");
    let points = space(Points::Uniform, 1000, 4);
    let (workers, one, two) = traced(&path, Detail::default(), || {
        let leaves = simulated(Workers::Leaves, 1, 300);
        let workers = simulate(&points, &leaves).unwrap().settled.workers;
        let other = |run: u64| simulated(Workers::Count(1), 1, 300).with(|c| c.machine.run = Some(run));
        // At the same time, from threads of the caller's.
        let listener = tracing::dispatcher::get_default(Clone::clone);
        let run = |number: u64| {
            let (listener, points) = (listener.clone(), &points);
            move || tracing::dispatcher::with_default(&listener, || simulate(points, &other(number)).unwrap())
        };
        let (one, two) = (run(77), run(78));
        std::thread::scope(|scope| {
            let both = (scope.spawn(one), scope.spawn(two));
            (workers, both.0.join().unwrap(), both.1.join().unwrap())
        })
    });
    assert!(one.cells() == two.cells() && workers > 1);
    let seen = rules::read(&path);
    let mut expected = vec!["planning: coordinator".to_owned(), "planning: worker 1".to_owned()];
    let of_main = |rank| if rank == 0 { "coordinator".to_owned() } else { format!("worker {rank}") };
    // The planning run came first, so the run it planned is not the first.
    expected.extend((0..=workers).map(|rank| format!("run 1: {}", of_main(rank))));
    for run in [77, 78] {
        expected.extend((0..=1).map(|rank| format!("run {run}: {}", of_main(rank))));
    }
    let mut names: Vec<String> = seen.processes.into_values().collect();
    names.sort();
    expected.sort();
    assert_eq!(names, expected);
}

#[test]
fn a_trace_that_is_dropped_vanishes() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let (layer, file) =
        layer::<tracing_subscriber::Registry>(&directory.path().join("trace.json"), Detail::Round).unwrap();
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
    drop((layer, file));
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

/// Spans left open when a trace is finished are closed there.
#[test]
fn a_trace_finished_early_is_whole() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("trace.json");
    let (layer, file) = layer(&path, Detail::default()).unwrap();
    tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), || {
        let site = septet_workers::profile::Site { run: 1, rank: 1, round: 3 };
        let _round = site.round(septet_protocol::ids::Phase::Hulls, Some(2));
        let _step = site.subproblem(
            septet_protocol::ids::Phase::Hulls,
            septet_protocol::ids::NodeId::ROOT,
            "split",
            9,
        );
        file.finish().unwrap();
    });
    let seen = rules::read(&path);
    assert_eq!(seen.slices.values().sum::<u64>(), 2);
}

/// The foreign reader finds planted errors, so that a pass is significant.
#[test]
#[ignore = "needs Node.js and Perfetto's trace processor"]
fn perfetto_refuses_torn_traces() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("trace.json");
    let spec = simulated(Workers::Count(3), 1, 200);
    traced(&path, Detail::default(), || simulate(&space(Points::Uniform, 800, 4), &spec)).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let rows: Vec<&str> = text.lines().collect();
    // Worker 1 sends a message in its first slice, which is then outside of all slices.
    let first = rows.iter().position(|r| r.contains("\"ph\":\"B\"") && r.contains("\"pid\":2,")).unwrap();
    let without: Vec<&str> = rows.iter().enumerate().filter(|r| r.0 != first).map(|r| *r.1).collect();
    let torn = directory.path().join("torn.json");
    fs::write(&torn, without.join("\n")).unwrap();
    assert!(std::panic::catch_unwind(|| rules::read(&torn)).is_err());
    let found = perfetto::read(&torn);
    assert!(!found.faults().is_empty());
    fs::write(&torn, &text[..text.len() / 2]).unwrap();
    assert!(perfetto::try_read(&torn).is_err());
}
