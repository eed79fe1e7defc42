//! Events of Chrome's trace format, as rows of JSON.
//!
//! Source: *Trace Event Format* (Google), as read by Perfetto's JSON importer. Metadata has no time. A slice is a
//! pair of `B` and `E`, so the rows of a thread must be in the order of their times. Flows are bound to the enclosing
//! slice.

use septet_protocol::ids::Group;
use serde::Serialize;

/// A process and a thread of the trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub(super) struct Track {
    pub(super) pid: u64,
    pub(super) tid: u64,
}

/// The arguments of a slice.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Args {
    pub(super) run: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) phase: Option<String>,
    /// The group of the phase, in slices of phases.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) group: Option<Group>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) round: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) worker: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) workers: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) messages: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) subproblem: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) points: Option<u64>,
}

/// The arguments of a message.
#[derive(Clone, Debug, Serialize)]
pub(super) struct FlowArgs {
    pub(super) from: u64,
    pub(super) to: u64,
    pub(super) round: u64,
    pub(super) bytes: u64,
    pub(super) subproblem: u64,
}

/// One row.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "ph")]
pub(super) enum Event<'a> {
    /// The name or the sort index of a process or thread.
    #[serde(rename = "M")]
    Metadata {
        name: &'static str,
        #[serde(flatten)]
        track: Track,
        args: Naming<'a>,
    },
    /// The beginning of a slice.
    #[serde(rename = "B")]
    Begin {
        name: &'a str,
        cat: &'static str,
        ts: f64,
        #[serde(flatten)]
        track: Track,
        args: &'a Args,
    },
    /// The end of a slice.
    #[serde(rename = "E")]
    End {
        ts: f64,
        #[serde(flatten)]
        track: Track,
    },
    /// The sending of a message.
    #[serde(rename = "s")]
    FlowStart {
        name: &'a str,
        cat: &'static str,
        id: u64,
        ts: f64,
        #[serde(flatten)]
        track: Track,
        args: FlowArgs,
    },
    /// The receipt of a message.
    #[serde(rename = "f")]
    FlowEnd {
        name: &'a str,
        cat: &'static str,
        id: u64,
        /// `e` binds the arrow to the enclosing slice instead of the next one.
        bp: &'static str,
        ts: f64,
        #[serde(flatten)]
        track: Track,
    },
    /// The values of a counter from this time on.
    #[serde(rename = "C")]
    Counter {
        name: &'static str,
        ts: f64,
        #[serde(flatten)]
        track: Track,
        args: Value,
    },
}

/// The content of metadata.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Naming<'a> {
    /// The name.
    Name { name: &'a str },
    /// The sort index.
    Sort { sort_index: u64 },
}

/// The value of a counter. Perfetto forms the name of the track from the name of the event and the name of the value:
/// `bytes in flight`, `active subproblems`.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) enum Value {
    /// Bytes in transit.
    #[serde(rename = "in flight")]
    InFlight(u64),
    /// Number of running steps at nodes of the tree.
    #[serde(rename = "subproblems")]
    Subproblems(u64),
}

/// Converts nanoseconds to the microseconds of the format. The result is exact to the nanosecond for 104 days.
pub(super) fn microseconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_what_the_format_wants() {
        let track = Track { pid: 1, tid: 2 };
        let text = |e: &Event<'_>| serde_json::to_string(e).unwrap();
        let name = Event::Metadata { name: "process_name", track, args: Naming::Name { name: "a \"b\"" } };
        assert_eq!(
            text(&name),
            r#"{"ph":"M","name":"process_name","pid":1,"tid":2,"args":{"name":"a \"b\""}}"#
        );
        let args = Args { run: 7, round: Some(3), ..Args::default() };
        let begin =
            Event::Begin { name: "hulls", cat: "round", ts: microseconds(1_234_567), track, args: &args };
        let expected = r#"{"ph":"B","name":"hulls","cat":"round","ts":1234.567,"pid":1,"tid":2,"args":{"run":7,"round":3}}"#;
        assert_eq!(text(&begin), expected);
        assert_eq!(text(&Event::End { ts: 0.001, track }), r#"{"ph":"E","ts":0.001,"pid":1,"tid":2}"#);
    }
}
