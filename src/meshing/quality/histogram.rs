//! Histograms with equal bins, and with counts of the values outside them.

/// Counts of values in equal bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// The lower end of the first bin.
    pub from: f64,
    /// The upper end of the last bin.
    pub to: f64,
    /// The number of values in each bin. A bin includes its lower end and excludes its upper end.
    pub counts: Vec<u64>,
    /// The number of values below the first bin.
    pub below: u64,
    /// The number of values that are NaN, or at or above the end of the last bin.
    pub above: u64,
    /// The smallest value.
    pub least: f64,
    /// The largest value.
    pub most: f64,
    sum: f64,
}

impl Histogram {
    /// Creates an empty histogram with `bins` equal bins.
    pub fn new(from: f64, to: f64, bins: usize) -> Self {
        let counts = vec![0; bins.max(1)];
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        Histogram { from, to, counts, below: 0, above: 0, least, most, sum: 0.0 }
    }

    /// Counts a value.
    pub fn add(&mut self, x: f64) {
        self.least = self.least.min(x);
        self.most = self.most.max(x);
        self.sum += x;
        let at = (x - self.from) / (self.to - self.from) * self.counts.len() as f64;
        if x < self.from {
            self.below += 1;
        } else if let Some(count) = (x < self.to).then(|| self.counts.len() - 1) {
            self.counts[(at as usize).min(count)] += 1;
        } else {
            self.above += 1;
        }
    }

    /// Returns the number of values.
    pub fn total(&self) -> u64 {
        self.below + self.above + self.counts.iter().sum::<u64>()
    }

    /// Returns the mean, or `None` if there are no values.
    pub fn mean(&self) -> Option<f64> {
        let total = self.total();
        (total > 0).then(|| self.sum / total as f64)
    }

    /// Returns the ends of bin `i`.
    pub fn bin(&self, i: usize) -> [f64; 2] {
        let step = (self.to - self.from) / self.counts.len() as f64;
        [self.from + step * i as f64, self.from + step * (i + 1) as f64]
    }
}
