//! Growth laws, and their columns in a fit.

use serde::Serialize;

/// A growth law: `y = a + b g(x)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Law {
    /// log2 n.
    #[serde(rename = "log n")]
    Log,
    /// (log2 n)^2.
    #[serde(rename = "log^2 n")]
    LogSquared,
    /// (log2 n)^(d/2), in space only; in the plane it equals log n (paper, Section 4.5).
    #[serde(rename = "log^(d/2) n")]
    LogHalfD,
    /// n^(1/d).
    #[serde(rename = "n^(1/d)")]
    Root,
    /// n^(1 - 1/d), in space only; in the plane it equals n^(1/d).
    #[serde(rename = "n^(1-1/d)")]
    Surface,
    /// n.
    #[serde(rename = "n")]
    Linear,
    /// n log2 n.
    #[serde(rename = "n log n")]
    LinearLog,
}

impl Law {
    /// Returns the laws that differ from each other in this dimension.
    pub fn all(dimension: usize) -> impl Iterator<Item = Law> {
        let all =
            [Law::Log, Law::LogHalfD, Law::LogSquared, Law::Root, Law::Surface, Law::Linear, Law::LinearLog];
        all.into_iter().filter(move |law| dimension != 2 || !matches!(law, Law::LogHalfD | Law::Surface))
    }

    /// Returns the law as text.
    pub fn name(self) -> &'static str {
        match self {
            Law::Log => "log n",
            Law::LogSquared => "log^2 n",
            Law::LogHalfD => "log^(d/2) n",
            Law::Root => "n^(1/d)",
            Law::Surface => "n^(1-1/d)",
            Law::Linear => "n",
            Law::LinearLog => "n log n",
        }
    }

    /// Returns g(x).
    pub fn at(self, x: f64, dimension: usize) -> f64 {
        let (log, d) = (x.log2(), dimension as f64);
        match self {
            Law::Log => log,
            Law::LogSquared => log * log,
            Law::LogHalfD => log.max(0.0).powf(d / 2.0),
            Law::Root => x.powf(1.0 / d),
            Law::Surface => x.powf(1.0 - 1.0 / d),
            Law::Linear => x,
            Law::LinearLog => x * log,
        }
    }
}
