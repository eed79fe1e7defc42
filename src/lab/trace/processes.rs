//! Processes and threads of the trace: one process per rank of each run, named before its first row.

use std::collections::{BTreeMap, BTreeSet};

use super::event::{Event, Naming, Track};

/// Number of process ids reserved for a run, which exceeds the number of ranks. Process ids are below 2^32 for the
/// first 2,048 runs.
const BLOCK: u64 = 1 << 21;

/// The content of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lane {
    /// The work of the rank between exchanges, and counters.
    Rounds,
    /// Phases of the run.
    Phases,
    /// Steps at nodes of the tree, executed by one operating system thread.
    Steps(u64),
}

impl Lane {
    /// Returns the thread id, which is at least 1.
    fn tid(self) -> u64 {
        match self {
            Lane::Rounds => 1,
            Lane::Phases => 2,
            Lane::Steps(slot) => 3 + slot,
        }
    }

    fn place(self) -> u64 {
        match self {
            Lane::Phases => 0,
            Lane::Rounds => 1,
            Lane::Steps(slot) => 2 + slot,
        }
    }

    fn name(self) -> String {
        match self {
            Lane::Rounds => "rounds".to_owned(),
            Lane::Phases => "phases".to_owned(),
            Lane::Steps(0) => "steps".to_owned(),
            Lane::Steps(slot) => format!("steps (thread {slot})"),
        }
    }
}

/// The number of a run in the trace, and whether it is a planning run.
#[derive(Clone, Copy, Debug)]
struct Known {
    number: u64,
    planning: bool,
}

/// The runs of the trace, and the processes and threads that already have names.
#[derive(Debug, Default)]
pub(super) struct Processes {
    runs: BTreeMap<u64, Known>,
    named: BTreeSet<u64>,
    threads: BTreeSet<Track>,
}

impl Processes {
    /// Begins a run, and names all its ranks in order.
    pub(super) fn begin(&mut self, run: u64, workers: u64, planning: bool, out: &mut dyn FnMut(&Event<'_>)) {
        let number = self.runs.len() as u64;
        self.runs.entry(run).or_insert(Known { number, planning });
        for rank in 0..=workers {
            self.track(run, rank, Lane::Rounds, out);
        }
    }

    /// Returns the track of a rank, and names it if it is new.
    pub(super) fn track(
        &mut self,
        run: u64,
        rank: u64,
        lane: Lane,
        out: &mut dyn FnMut(&Event<'_>),
    ) -> Track {
        let number = self.runs.len() as u64;
        let known = *self.runs.entry(run).or_insert(Known { number, planning: false });
        let track = Track { pid: known.number * BLOCK + rank + 1, tid: lane.tid() };
        if !self.threads.insert(track) {
            return track;
        }
        let mut tell = |name: &'static str, args: Naming<'_>| out(&Event::Metadata { name, track, args });
        if self.named.insert(track.pid) {
            let who = if rank == 0 { "coordinator".to_owned() } else { format!("worker {rank}") };
            let name = match known {
                Known { planning: true, .. } => format!("planning: {who}"),
                Known { number: 0, .. } => who,
                _ => format!("run {run}: {who}"),
            };
            tell("process_name", Naming::Name { name: &name });
            tell("process_sort_index", Naming::Sort { sort_index: track.pid });
        }
        tell("thread_name", Naming::Name { name: &lane.name() });
        tell("thread_sort_index", Naming::Sort { sort_index: lane.place() });
        track
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracks_are_named_once_and_numbered_from_one() {
        let mut processes = Processes::default();
        let mut rows = Vec::new();
        processes.begin(9, 2, false, &mut |e| rows.push(serde_json::to_value(e).unwrap()));
        let names = |rows: &[serde_json::Value], what: &str| -> Vec<String> {
            let of = rows.iter().filter(|r| r["name"] == what);
            of.map(|r| r["args"]["name"].as_str().unwrap().to_owned()).collect()
        };
        assert_eq!(names(&rows, "process_name"), ["coordinator", "worker 1", "worker 2"]);
        let before = rows.len();
        let track = processes.track(9, 2, Lane::Rounds, &mut |e| rows.push(serde_json::to_value(e).unwrap()));
        assert_eq!((track, rows.len()), (Track { pid: 3, tid: 1 }, before));
        let track =
            processes.track(4, 0, Lane::Steps(1), &mut |e| rows.push(serde_json::to_value(e).unwrap()));
        assert_eq!(track, Track { pid: BLOCK + 1, tid: 4 });
        assert_eq!(names(&rows[before..], "process_name"), ["run 4: coordinator"]);
        assert!(rows.iter().all(|r| r.get("ts").is_none()));
    }
}
