//! Least squares with clustered errors, and one-sided tests of a coefficient.
//!
//! **Statement.** The rows of a cluster (a run, or all runs of one size) may depend on each other. The *score* of a
//! cluster is the contribution of its residuals to a coefficient: the row of `(A'A)^-1 A'` for the coefficient, times
//! the residuals. The variance of the coefficient is the clustered sandwich CR1: with G clusters, N rows and K
//! coefficients, it is the sum of the squared scores times `G/(G-1) (N-1)/(N-K)`. Tests use Student's distribution with
//! G - 1 degrees of freedom.

use std::collections::BTreeMap;

use super::distribution::{t_above, t_quantile};
use super::ols::{Observation, least_squares};

/// A row of a clustered fit.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusterRow {
    /// The cluster.
    pub cluster: u64,
    /// The columns without the constant.
    pub columns: Vec<f64>,
    /// The value.
    pub y: f64,
}

/// The estimate of a coefficient with its clustered error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// The standard error.
    pub error: f64,
    /// Number of clusters minus 1.
    pub freedom: f64,
}

impl Estimate {
    /// Returns the upper end of the one-sided 95 % interval.
    pub fn upper(&self) -> f64 {
        self.value + t_quantile(self.freedom, 0.95) * self.error
    }

    /// Returns the lower end of the one-sided 95 % interval.
    pub fn lower(&self) -> f64 {
        self.value - t_quantile(self.freedom, 0.95) * self.error
    }

    /// Returns the probability of an estimate at most this large if the true value were `bound`.
    pub fn p_below(&self, bound: f64) -> f64 {
        self.p_of(bound - self.value)
    }

    /// Returns the probability of an estimate at least this large if the true value were `bound`.
    pub fn p_above(&self, bound: f64) -> f64 {
        self.p_of(self.value - bound)
    }

    fn p_of(&self, distance: f64) -> f64 {
        if self.error > 0.0 {
            return t_above(self.freedom, distance / self.error);
        }
        // Without an error, the estimate decides.
        f64::from(u8::from(distance <= 0.0))
    }

    /// Returns the estimate times a positive factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Estimate {
        Estimate { value: factor * self.value, error: factor * self.error, ..self }
    }
}

/// Returns the coefficient of a column, where 0 is the constant. Returns `None` for fewer than 3 clusters, or if the
/// columns do not determine the coefficients.
pub fn clustered(rows: &[ClusterRow], column: usize) -> Option<Estimate> {
    let observed: Vec<Observation> =
        rows.iter().map(|r| Observation { columns: r.columns.clone(), y: r.y, weight: 1.0 }).collect();
    let fit = least_squares(&observed)?;
    let bread = fit.bread.get(column)?;
    let mut scores: BTreeMap<u64, f64> = BTreeMap::new();
    for row in rows {
        let slopes = bread[1..].iter().zip(&row.columns).map(|(b, x)| b * x).sum::<f64>();
        *scores.entry(row.cluster).or_default() += (row.y - fit.at(&row.columns)) * (bread[0] + slopes);
    }
    if scores.len() < 3 {
        return None;
    }
    let (g, n, k) = (scores.len() as f64, rows.len() as f64, bread.len() as f64);
    let meat: f64 = scores.values().map(|s| s * s).sum();
    let error = (meat * g / (g - 1.0) * (n - 1.0) / (n - k)).sqrt();
    Some(Estimate { value: fit.coefficients[column].value, error, freedom: g - 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(cluster: u64, x: f64, y: f64) -> ClusterRow {
        ClusterRow { cluster, columns: vec![x], y }
    }

    /// By hand: x = -1, 0, 1 with y = 0, 3, 0 has slope 0 and residuals -1, 2, -1. The scores are 1/2, 0 and -1/2, so
    /// the error is sqrt(1/2 * 3/2 * 2/1).
    #[test]
    fn single_rows_are_clusters() {
        let rows = [row(1, -1.0, 0.0), row(2, 0.0, 3.0), row(3, 1.0, 0.0)];
        let slope = clustered(&rows, 1).unwrap();
        assert!(slope.value.abs() < 1e-12 && (slope.error - 1.5f64.sqrt()).abs() < 1e-12, "{slope:?}");
        assert!((slope.freedom - 2.0).abs() < 1e-12);
        assert!(slope.lower() < 0.0 && slope.upper() > 0.0);
        assert!((slope.p_below(0.0) - 0.5).abs() < 1e-9 && slope.p_below(9.0) < 0.05);
        assert!(slope.p_above(9.0) > 0.9);
        assert_eq!(clustered(&rows[..2], 1), None);
    }

    /// Rows that are repeated within their clusters add no information.
    #[test]
    fn repeated_rows_leave_the_error() {
        let once: Vec<ClusterRow> = (0..8).map(|i| row(i, i as f64, (i * i % 5) as f64)).collect();
        let twice = [once.clone(), once.clone()].concat();
        let (a, b) = (clustered(&once, 1).unwrap(), clustered(&twice, 1).unwrap());
        let factor = (15.0f64 / 14.0 * 6.0 / 7.0).sqrt();
        assert!((b.error / a.error - factor).abs() < 1e-9, "{a:?} {b:?}");
    }
}
