//! The context of a run: its command, files, times and memory.

use std::path::PathBuf;

use septet_core::Stats;
use septet_io::read::{Extent, FileReading};

/// The context of a run: the data of its report that the run itself does not contain.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunContext<'a> {
    /// `triangulate` or `simulate`.
    pub command: &'static str,
    /// The input as given on the command line.
    pub input: &'a str,
    /// The outputs as given on the command line.
    pub outputs: &'a [PathBuf],
    /// The column or the file of the weights, as given on the command line.
    pub weights: Option<&'a str>,
    /// The column or the file of the radii, as given on the command line.
    pub radii: Option<&'a str>,
    /// Number of threads of each process.
    pub threads: usize,
    /// Number of points that were dropped while reading.
    pub skipped: u64,
    /// What was read of the input. `None` for a sample.
    pub reading: Option<&'a FileReading>,
    /// The extent of the points that were read.
    pub extent: Option<&'a Extent>,
    /// Whether the points are a terrain.
    pub is_terrain: bool,
    /// The largest difference of the heights of coincident points of a terrain, if there are any.
    pub height_difference: Option<f64>,
    /// The numbers of the triangulation, if requested.
    pub stats: Option<&'a Stats>,
    /// Measured seconds of reading.
    pub read_seconds: f64,
    /// Measured seconds of writing.
    pub write_seconds: f64,
    /// Measured seconds of the whole command.
    pub total_seconds: f64,
    /// Measured resident memory before the run, in bytes.
    pub rss_before_bytes: Option<u64>,
    /// Measured peak of resident memory, in bytes.
    pub peak_rss_bytes: Option<u64>,
}
