//! Perfetto's trace processor, run over a file by `tests/foreign/read_trace.mjs`.
//!
//! `SEPTET_NODE` names Node.js, `SEPTET_TRACE_PROCESSOR` the folder of the processor (see `tests/run`). `tests/run`
//! installs both and runs these tests, which a plain `cargo test` ignores.

use std::env;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The findings of the processor.
pub struct Found(Value);

/// The findings for a valid file.
pub fn read(path: &Path) -> Found {
    try_read(path).unwrap_or_else(|printed| panic!("{}: {printed}", path.display()))
}

/// The same for a file that it may refuse.
pub fn try_read(path: &Path) -> Result<Found, String> {
    let named =
        |name: &str| env::var_os(name).unwrap_or_else(|| panic!("{name} is not set: tests/run sets it"));
    let (node, processor) = (named("SEPTET_NODE"), named("SEPTET_TRACE_PROCESSOR"));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign/read_trace.mjs");
    let output = Command::new(node).arg(script).arg(processor).arg(path).output().unwrap();
    if output.status.success() {
        Ok(Found(serde_json::from_slice(&output.stdout).unwrap()))
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

impl Found {
    fn rows(&self, key: &str) -> &[Value] {
        self.0[key].as_array().unwrap()
    }

    fn sum<'a>(rows: impl Iterator<Item = &'a Value>) -> u64 {
        rows.map(|r| r["count"].as_u64().unwrap()).sum()
    }

    /// Errors and losses of the import.
    pub fn faults(&self) -> Vec<String> {
        self.rows("faults").iter().map(Value::to_string).collect()
    }

    /// Slices that overlap another of their track and depth.
    pub fn overlaps(&self) -> u64 {
        Self::sum(self.rows("overlaps").iter())
    }

    /// Number, name and place of each process.
    pub fn processes(&self) -> Vec<(u64, String, u64)> {
        let of = |r: &Value| {
            (r["pid"].as_u64().unwrap(), r["name"].as_str().unwrap().to_owned(), r["place"].as_u64().unwrap())
        };
        self.rows("processes").iter().map(of).collect()
    }

    /// Slices of a process on the tracks of a name.
    pub fn slices(&self, pid: u64, track: &str, category: &str) -> u64 {
        let fits = |r: &&Value| r["pid"] == pid && r["track"] == track && r["category"] == category;
        Self::sum(self.rows("slices").iter().filter(fits))
    }

    /// Slices of a category.
    pub fn slices_of(&self, category: &str) -> u64 {
        Self::sum(self.rows("slices").iter().filter(|r| r["category"] == category))
    }

    /// Duration of the shortest slice, in nanoseconds.
    pub fn shortest(&self) -> i64 {
        self.rows("slices").iter().map(|r| r["shortest"].as_i64().unwrap()).min().unwrap()
    }

    /// Arrows: all, those forward in time, from rounds, to rounds, and between different tracks.
    pub fn flows(&self) -> [u64; 5] {
        ["count", "forward", "from_rounds", "to_rounds", "apart"]
            .map(|key| self.rows("flows")[0][key].as_u64().unwrap())
    }

    /// Last value of a counter.
    pub fn last(&self, name: &str) -> u64 {
        let row = self.rows("counters").iter().find(|r| r["name"] == name);
        row.unwrap_or_else(|| panic!("no counter {name}"))["last"].as_u64().unwrap()
    }
}
