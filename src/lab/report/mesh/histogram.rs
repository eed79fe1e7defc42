//! Histograms in reports that are written and read back.

use serde::{Deserialize, Serialize};

use septet_meshing::quality::histogram::Histogram;
pub use septet_meshing::quality::histogram::PERCENTILES;

/// Counts over equal bins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HistogramReport {
    /// The lower end of the first bin.
    pub from: f64,
    /// The upper end of the last bin.
    pub to: f64,
    /// Number of values below the first bin.
    pub below: u64,
    /// Number of values that are NaN, or at or above the upper end of the last bin.
    pub above: u64,
    /// The smallest value. `None` if there are no values, or if it is not finite.
    pub least: Option<f64>,
    /// The largest value. `None` if there are no values, or if it is not finite.
    pub most: Option<f64>,
    /// The mean. `None` if there are no values, or if it is not finite.
    pub mean: Option<f64>,
    /// Percentiles of the values.
    #[serde(default)]
    pub percentiles: Percentiles,
    /// Number of values in each bin.
    pub counts: Vec<u64>,
}

/// Percentiles: each is the smallest value that at least so many percent of the values do not exceed, or a number below it by at
/// most one part in 2048. `None` if there are no values, or if it is not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Percentiles {
    /// 1 %.
    pub p1: Option<f64>,
    /// 5 %.
    pub p5: Option<f64>,
    /// 25 %.
    pub p25: Option<f64>,
    /// 50 %, the median.
    pub p50: Option<f64>,
    /// 75 %.
    pub p75: Option<f64>,
    /// 95 %.
    pub p95: Option<f64>,
    /// 99 %.
    pub p99: Option<f64>,
}

impl Percentiles {
    /// Returns the percentiles in the order of [`PERCENTILES`].
    pub fn values(&self) -> [Option<f64>; 7] {
        [self.p1, self.p5, self.p25, self.p50, self.p75, self.p95, self.p99]
    }
}

impl HistogramReport {
    /// Returns the number of values.
    pub fn total(&self) -> u64 {
        self.below + self.above + self.counts.iter().sum::<u64>()
    }

    /// Returns the ends of a bin.
    pub fn bin(&self, i: usize) -> [f64; 2] {
        let step = (self.to - self.from) / self.counts.len() as f64;
        [self.from + step * i as f64, self.from + step * (i + 1) as f64]
    }
}

impl From<&Histogram> for HistogramReport {
    fn from(h: &Histogram) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        let [p1, p5, p25, p50, p75, p95, p99] = PERCENTILES.map(|p| h.percentile(p).and_then(finite));
        HistogramReport {
            from: h.from,
            to: h.to,
            below: h.below,
            above: h.above,
            least: finite(h.least),
            most: finite(h.most),
            mean: h.mean().and_then(finite),
            percentiles: Percentiles { p1, p5, p25, p50, p75, p95, p99 },
            counts: h.counts.clone(),
        }
    }
}
