//! Histograms in reports that are written and read back.

use serde::{Deserialize, Serialize};

use septet_meshing::quality::histogram::Histogram;

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
    /// Number of values in each bin.
    pub counts: Vec<u64>,
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
        HistogramReport {
            from: h.from,
            to: h.to,
            below: h.below,
            above: h.above,
            least: finite(h.least),
            most: finite(h.most),
            mean: h.mean().and_then(finite),
            counts: h.counts.clone(),
        }
    }
}
