//! Configurations that cannot run.

use septet_workers::config::Neighbours;
use thiserror::Error;

use crate::remedy::Remedy;

/// A combination of parameters with which no run is possible.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SpecError {
    /// There are no workers.
    #[error("at least one worker is needed")]
    NoWorkers,
    /// There are more workers than ranks.
    #[error("{workers} workers are too many: at most {most}")]
    TooManyWorkers {
        /// The number of workers in the configuration.
        workers: u32,
        /// The largest number of workers.
        most: u32,
    },
    /// A conflict graph takes no weights.
    #[error("sites of an independent set have sizes, so they cannot have weights")]
    Weighted,
    /// A method exists in the plane and in space only.
    #[error("{what} exist in dimensions 2 and 3 only, but the points have dimension {dimension}")]
    OnlySpace {
        /// The method, in the plural.
        what: &'static str,
        /// Number of coordinates of a point.
        dimension: usize,
    },
    /// This build does not triangulate points of this dimension.
    #[error(
        "points of dimension {dimension}: this build triangulates dimensions 2 and 3, because it was built without the \
         feature `dimensions`"
    )]
    Dimensions {
        /// Number of coordinates of a point.
        dimension: usize,
    },
    /// There are no threads.
    #[error("at least one thread is needed")]
    NoThreads,
    /// alpha is less than 1 or not a number.
    #[error("alpha is {alpha}: it must be a number of at least 1 (Definition 2.2), or `auto`")]
    Alpha {
        /// The value in the configuration.
        alpha: f64,
    },
    /// k is out of range.
    #[error("k is {k}, but the set has {points} points: k must be at least 1 and below that, or `auto`")]
    K {
        /// The value in the configuration.
        k: u64,
        /// Number of distinct points.
        points: u64,
    },
    /// A factor of log n is out of range.
    #[error("the factor of log n is {factor}: it must be a positive number")]
    LogFactor {
        /// The value in the configuration.
        factor: f64,
    },
    /// alpha or k is given for a supergraph that does not use it.
    #[error("a {graph} graph has no {parameter}")]
    Unused {
        /// The supergraph.
        graph: &'static str,
        /// alpha or k.
        parameter: &'static str,
    },
    /// k is given for an overlap graph whose alpha is automatic.
    #[error(
        "k of an overlap graph is {k}, but alpha is `auto`, which a sample of stars chooses for balls to the first \
         neighbour"
    )]
    AutomaticAlpha {
        /// The value in the configuration.
        k: Neighbours,
    },
    /// k of an overlap graph is a factor of ln n.
    #[error("k of an overlap graph is {factor}ln: it must be a number (Definition 2.2), or `auto`")]
    OverlapLog {
        /// The factor in the configuration.
        factor: f64,
    },
    /// A correction of balls to first neighbours is requested for balls beyond the first neighbour.
    #[error("`{correction}` finds the balls of first neighbours only, but k of the overlap graph is {k}")]
    FirstBalls {
        /// The name of the correction.
        correction: &'static str,
        /// The value in the configuration.
        k: u32,
    },
    /// A value is not one of an option.
    #[error("invalid value `{value}` for {option}: {expected}")]
    Value {
        /// The option.
        option: &'static str,
        /// The value.
        value: String,
        /// What was expected.
        expected: String,
    },
    /// An option has no effect without another one.
    #[error("{option} has no effect without {needed} {word}")]
    Needs {
        /// The option.
        option: &'static str,
        /// The option that it needs.
        needed: &'static str,
        /// The value that it needs.
        word: &'static str,
    },
    /// The rule of separator sets loses edges of the supergraph.
    #[error(
        "separator sets `smaller` hold for the density graph only: an edge of the {graph} graph can cross a \
         separator with one end's ball on its own side"
    )]
    SmallerSide {
        /// The supergraph.
        graph: &'static str,
    },
    /// A correction of neighbour balls is requested from a run without them.
    #[error("only `simulate` has neighbour balls, so only it has the correction `{correction}`")]
    Uncorrected {
        /// The name of the correction.
        correction: &'static str,
    },
    /// A draw has too few samples for a centrepoint.
    #[error("{samples} samples are too few for a centrepoint: at least {least}")]
    Samples {
        /// The number of samples in the configuration.
        samples: u64,
        /// The smallest number of samples.
        least: u64,
    },
    /// The number of great circles is out of range.
    #[error("a draw tries between 1 and {most} great circles, not {tries}")]
    Tries {
        /// The number in the configuration.
        tries: u32,
        /// The largest number of great circles.
        most: u32,
    },
    /// Great circles are given for a partition that draws none.
    #[error("a number of great circles has no effect on the partition {partition}, which draws none")]
    TriesOfBaseline {
        /// The name of the partition.
        partition: &'static str,
    },
    /// A process would have no worker.
    #[error("{workers} workers are too few for {processes} processes")]
    TooFewWorkers {
        /// The number of workers in the configuration.
        workers: u32,
        /// The number of processes.
        processes: u32,
    },
    /// An option needs all ranks in one process.
    #[error("{output} needs all points in one process")]
    NotDistributed {
        /// The output.
        output: &'static str,
        /// The option that asks for it.
        option: &'static str,
    },
    /// The leaf size is zero.
    #[error("a leaf holds at least one point")]
    EmptyLeaf,
}

impl SpecError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(match *self {
            Self::NoWorkers => Remedy::of("use {workers=1}"),
            Self::NoThreads => Remedy::of("use {threads=1}"),
            Self::EmptyLeaf => Remedy::of("use {leaf=1}"),
            Self::TooManyWorkers { most, .. } => Remedy::of("use at most ").set("workers", most),
            Self::Samples { least, .. } => Remedy::of("use at least ").set("samples", least),
            Self::Tries { most, .. } => Remedy::of("use {tries=1} to ").set("tries", most),
            Self::TooFewWorkers { processes, .. } => Remedy::of("use at least ").set("workers", processes),
            Self::Unused { parameter, .. } => {
                Remedy::of("omit ").option(parameter).then(", or choose another {supergraph}")
            }
            Self::AutomaticAlpha { .. } => Remedy::of("use {alpha=2.5}, or omit {k}"),
            Self::FirstBalls { .. } => Remedy::of("omit {neighbours} or {k}"),
            Self::Needs { option, needed, word } => {
                Remedy::of("add ").set(needed, word).then(", or omit ").option(option)
            }
            Self::SmallerSide { .. } => Remedy::of("use {separator-sets=both} or {separator-sets=ghost}"),
            Self::Dimensions { .. } => Remedy::of("build septet with the feature `dimensions`"),
            Self::OnlySpace { .. } => {
                Remedy::of("use `triangulate`, `simulate` or `verify`, or give points of 2 or 3 coordinates")
            }
            Self::Uncorrected { .. } => Remedy::of("use `simulate`, or omit {neighbours}"),
            Self::TriesOfBaseline { .. } => Remedy::of("omit {tries} or {partition}"),
            Self::NotDistributed { option, .. } => {
                Remedy::of("omit ").option(option).then(", or run in one process")
            }
            Self::Alpha { .. }
            | Self::K { .. }
            | Self::LogFactor { .. }
            | Self::OverlapLog { .. }
            | Self::Value { .. }
            | Self::Weighted => return None,
        })
    }
}
