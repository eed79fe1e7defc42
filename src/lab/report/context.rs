//! What surrounds a run and is not known to it.

use std::path::PathBuf;

/// What surrounds a run and is not known to it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Setting<'a> {
    /// `triangulate` or `simulate`.
    pub command: &'static str,
    /// The input as named.
    pub input: &'a str,
    /// The outputs as named.
    pub outputs: &'a [PathBuf],
    /// Points dropped while reading.
    pub skipped: u64,
    /// Measured seconds of reading.
    pub read_seconds: f64,
    /// Measured seconds of writing.
    pub write_seconds: f64,
    /// Measured seconds of everything.
    pub total_seconds: f64,
    /// Measured memory before the run.
    pub rss_before_bytes: Option<u64>,
    /// Measured peak memory.
    pub peak_rss_bytes: Option<u64>,
}
