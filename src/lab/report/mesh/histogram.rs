//! Histograms as reports have them, written and read back.

use serde::{Deserialize, Serialize};

use septet_meshing::quality::histogram::Histogram;

/// Counts over equal bins; numbers that are not finite are null.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HistogramReport {
    /// The lower end of the first bin.
    pub from: f64,
    /// The upper end of the last bin.
    pub to: f64,
    /// How many lay below.
    pub below: u64,
    /// How many lay above.
    pub above: u64,
    /// The least; none of nothing.
    pub least: Option<f64>,
    /// The largest; none of nothing.
    pub most: Option<f64>,
    /// The mean; none of nothing.
    pub mean: Option<f64>,
    /// How many lay in each bin.
    pub counts: Vec<u64>,
}

impl HistogramReport {
    /// How many were counted.
    pub fn total(&self) -> u64 {
        self.below + self.above + self.counts.iter().sum::<u64>()
    }

    /// The ends of a bin.
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
