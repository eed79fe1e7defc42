//! The report of a run by several processes.

use serde::{Deserialize, Serialize};

/// A process of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ProcessReport {
    /// Number of the process, counted from 0.
    pub process: u32,
    /// Number of workers.
    pub workers: u32,
    /// Points that the workers hold after the partition.
    pub points: u64,
    /// Points of other workers that are vertices of their cells, counted for each worker.
    pub ghosts: u64,
    /// Bytes that the process received from other processes, checksums included.
    pub bytes_in: u64,
    /// Bytes that the process sent to other processes, checksums included.
    pub bytes_out: u64,
    /// Measured peak of resident memory.
    pub peak_rss_bytes: Option<u64>,
    /// Measured seconds from the start of the command to the end of its outputs.
    pub seconds: f64,
}
