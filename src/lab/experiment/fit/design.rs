//! Growth laws, and their columns in a fit.

use serde::Serialize;

/// A growth law: `y = a + b g(x)`. The order of the laws is the order of their growth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Law {
    /// log2 n.
    #[serde(rename = "log n")]
    Log,
    /// (log2 n)^1.5. In space, this is the law (log2 n)^(d/2) of Section 4.5 of the paper.
    #[serde(rename = "log^1.5 n")]
    LogThreeHalves,
    /// (log2 n)^2.
    #[serde(rename = "log^2 n")]
    LogSquared,
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
    /// n (log2 n)^2.
    #[serde(rename = "n log^2 n")]
    LinearLogSquared,
}

impl Law {
    /// Returns the laws that differ from each other in this dimension, the lowest first.
    pub fn all(dimension: usize) -> impl Iterator<Item = Law> {
        let all = [
            Law::Log,
            Law::LogThreeHalves,
            Law::LogSquared,
            Law::Root,
            Law::Surface,
            Law::Linear,
            Law::LinearLog,
            Law::LinearLogSquared,
        ];
        all.into_iter().filter(move |&law| dimension != 2 || law != Law::Surface)
    }

    /// Returns the law as text.
    pub fn name(self) -> &'static str {
        match self {
            Law::Log => "log n",
            Law::LogThreeHalves => "log^1.5 n",
            Law::LogSquared => "log^2 n",
            Law::Root => "n^(1/d)",
            Law::Surface => "n^(1-1/d)",
            Law::Linear => "n",
            Law::LinearLog => "n log n",
            Law::LinearLogSquared => "n log^2 n",
        }
    }

    /// Returns g(x).
    pub fn at(self, x: f64, dimension: usize) -> f64 {
        let (log, d) = (x.log2(), dimension as f64);
        match self {
            Law::Log => log,
            Law::LogThreeHalves => log.max(0.0).powf(1.5),
            Law::LogSquared => log * log,
            Law::Root => x.powf(1.0 / d),
            Law::Surface => x.powf(1.0 - 1.0 / d),
            Law::Linear => x,
            Law::LinearLog => x * log,
            Law::LinearLogSquared => x * log * log,
        }
    }
}
