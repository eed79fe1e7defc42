//! The rules of a trace, checked row by row.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

/// The contents of a trace.
#[derive(Default)]
pub struct Seen {
    /// Slices of each process and category.
    pub slices: BTreeMap<(u64, String), u64>,
    /// Slices of each name.
    pub names: BTreeMap<String, u64>,
    /// Messages with both ends.
    pub arrows: u64,
    /// Last value of each counter.
    pub last: BTreeMap<String, u64>,
    /// Names of processes.
    pub processes: BTreeMap<u64, String>,
}

/// A thread of the trace: process, thread.
type Track = (u64, u64);

#[derive(Default)]
struct Reader {
    seen: Seen,
    threads: BTreeMap<Track, String>,
    times: BTreeMap<Track, f64>,
    counted: BTreeMap<String, f64>,
    open: BTreeMap<Track, u64>,
    /// Arrows begun: name, category, time.
    begun: BTreeMap<u64, (String, String, f64)>,
    ended: BTreeMap<u64, f64>,
}

/// Reads a trace that has to keep every rule.
pub fn read(path: &Path) -> Seen {
    let whole: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let mut reader = Reader::default();
    for row in whole["traceEvents"].as_array().unwrap() {
        reader.row(row);
    }
    assert!(reader.open.values().all(|depth| *depth == 0), "slices without an end");
    // Rows of threads are not sorted, so ends may precede beginnings.
    for (id, ended) in &reader.ended {
        let (_, _, began) = reader.begun.get(id).unwrap_or_else(|| panic!("arrow {id} comes from nowhere"));
        assert!(ended > began, "arrow {id} goes back in time");
    }
    assert_eq!(reader.begun.len(), reader.ended.len(), "messages that never arrived");
    reader.seen.arrows = reader.begun.len() as u64;
    reader.seen
}

fn text(row: &Value, key: &str) -> String {
    row[key].as_str().unwrap_or_else(|| panic!("no {key}: {row}")).to_owned()
}

fn number(row: &Value, key: &str) -> u64 {
    row[key].as_u64().unwrap_or_else(|| panic!("no {key}: {row}"))
}

impl Reader {
    fn row(&mut self, row: &Value) {
        let track = (number(row, "pid"), number(row, "tid"));
        assert!((1..1 << 32).contains(&track.0) && (1..1 << 32).contains(&track.1), "{row}");
        if row["ph"] == "M" {
            self.metadata(row, track);
            return;
        }
        assert!(self.seen.processes.contains_key(&track.0), "a process without a name: {row}");
        assert!(self.threads.contains_key(&track), "a thread without a name: {row}");
        let time = row["ts"].as_f64().unwrap();
        if row["ph"] == "C" {
            self.counter(row, time);
            return;
        }
        let last = self.times.insert(track, time).unwrap_or(-1.0);
        assert!(time > last, "{time} after {last}: {row}");
        let depth = self.open.entry(track).or_default();
        match row["ph"].as_str().unwrap() {
            "B" => {
                *depth += 1;
                assert!(row["args"]["run"].is_u64(), "{row}");
                *self.seen.slices.entry((track.0, text(row, "cat"))).or_default() += 1;
                *self.seen.names.entry(text(row, "name")).or_default() += 1;
            }
            "E" => *depth = depth.checked_sub(1).unwrap_or_else(|| panic!("an end of nothing: {row}")),
            kind => {
                assert!(*depth > 0, "an arrow outside all slices: {row}");
                self.arrow(kind, row, time);
            }
        }
    }

    fn metadata(&mut self, row: &Value, track: Track) {
        assert!(row.get("ts").is_none(), "metadata with a time: {row}");
        match row["name"].as_str().unwrap() {
            "process_name" => {
                let before = self.seen.processes.insert(track.0, text(&row["args"], "name"));
                assert!(before.is_none(), "named twice: {row}");
            }
            "thread_name" => {
                let before = self.threads.insert(track, text(&row["args"], "name"));
                assert!(before.is_none(), "named twice: {row}");
            }
            "process_sort_index" | "thread_sort_index" => {
                number(&row["args"], "sort_index");
            }
            _ => panic!("unknown metadata: {row}"),
        }
    }

    fn counter(&mut self, row: &Value, time: f64) {
        let args = row["args"].as_object().unwrap();
        assert_eq!(args.len(), 1);
        let (key, value) = args.iter().next().unwrap();
        let name = format!("{} {key}", text(row, "name"));
        let last = self.counted.insert(name.clone(), time).unwrap_or(-1.0);
        assert!(time > last, "{time} after {last}: {row}");
        self.seen.last.insert(name, value.as_u64().unwrap());
    }

    fn arrow(&mut self, kind: &str, row: &Value, time: f64) {
        let id = number(row, "id");
        match kind {
            "s" => {
                let entry = (text(row, "name"), text(row, "cat"), time);
                assert!(self.begun.insert(id, entry).is_none(), "two arrows of one number: {row}");
            }
            "f" => {
                assert_eq!(row["bp"], "e", "{row}");
                assert!(self.ended.insert(id, time).is_none(), "an arrow ends twice: {row}");
            }
            _ => panic!("unknown event: {row}"),
        }
    }
}
