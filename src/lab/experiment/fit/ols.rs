//! Weighted least squares with Student's intervals.
//!
//! **Statement.** For rows `(1, g_1, .., g_k)` with values y and weights w, the fit minimises the sum of
//! `w (y - fit)^2`. It uses Householder's QR ([`super::qr`]) of the rows scaled by sqrt(w), with columns scaled so that
//! their largest entry is 1 before the weights are applied. The error variance is the weighted sum of squared residuals
//! over `N - k - 1`, where N is the number of rows.

use serde::Serialize;

use super::distribution::t_quantile;
use super::qr::{Solution, Triangle};

/// One observation: a row of the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The columns without the constant.
    pub columns: Vec<f64>,
    /// The value.
    pub y: f64,
    /// The weight.
    pub weight: f64,
}

/// An estimate with its interval. The level of the interval is 95 %, unless the field that contains it states another
/// one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// The standard error.
    pub error: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// A fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The coefficients, beginning with the constant.
    pub coefficients: Vec<Interval>,
    /// Inverse of the matrix of normal equations, row by row.
    pub bread: Vec<Vec<f64>>,
    /// Weighted sum of squared residuals.
    pub rss: f64,
    /// Weighted sum of squares around the weighted mean.
    pub tss: f64,
    /// Number of observations minus number of coefficients.
    pub freedom: f64,
}

impl Fit {
    /// Returns the fraction of the (weighted) variance that the fit explains, or 1 if there is no variance.
    pub fn r_squared(&self) -> f64 {
        if self.tss > 0.0 { 1.0 - self.rss / self.tss } else { 1.0 }
    }

    /// Returns the fitted value for a row with these columns.
    pub fn at(&self, columns: &[f64]) -> f64 {
        let slopes = self.coefficients[1..].iter().zip(columns);
        self.coefficients[0].value + slopes.map(|(c, x)| c.value * x).sum::<f64>()
    }

    /// Returns Akaike's criterion with the correction for few observations; lower is better. A residual below the
    /// rounding error is replaced by the rounding error.
    pub fn aicc(&self, observations: usize) -> f64 {
        let n = observations as f64;
        // The parameters are the coefficients and the error variance.
        let k = self.coefficients.len() as f64 + 1.0;
        let rss = self.rss.max(1e-24 * self.tss).max(f64::MIN_POSITIVE);
        n * (rss / n).ln() + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0).max(0.5)
    }
}

/// Returns the fit, or `None` if the columns do not determine the coefficients or no degrees of freedom remain for
/// the error.
pub fn least_squares(rows: &[Observation]) -> Option<Fit> {
    let width = rows.first()?.columns.len() + 1;
    let freedom = rows.len().checked_sub(width).filter(|&f| f > 0)? as f64;
    let mut scale = vec![1.0; width];
    for (j, s) in scale.iter_mut().enumerate().skip(1) {
        *s = rows.iter().map(|r| r.columns[j - 1].abs()).fold(0.0, f64::max);
        if *s == 0.0 {
            return None;
        }
    }
    let column = |row: &Observation, j: usize| if j == 0 { 1.0 } else { row.columns[j - 1] / scale[j] };
    let matrix: Vec<Vec<f64>> =
        (0..width).map(|j| rows.iter().map(|r| r.weight.sqrt() * column(r, j)).collect()).collect();
    let values: Vec<f64> = rows.iter().map(|r| r.weight.sqrt() * r.y).collect();
    let triangle = Triangle::of(matrix.clone(), values.clone());
    let largest = triangle.diagonal().next()?;
    if triangle.diagonal().fold(f64::INFINITY, f64::min) <= 1e-12 * largest {
        return None;
    }
    let Solution { coefficients: solution, bread } = triangle.solve();
    let fitted = |i: usize| matrix.iter().zip(&solution).map(|(column, c)| column[i] * c).sum::<f64>();
    let rss = values.iter().enumerate().map(|(i, y)| (y - fitted(i)) * (y - fitted(i))).sum::<f64>();
    let quantile = t_quantile(freedom, 0.975);
    let coefficients = (0..width).map(|j| {
        let value = solution[j] / scale[j];
        let error = (bread[j][j] * rss / freedom).sqrt() / scale[j];
        Interval { value, error, low: value - quantile * error, high: value + quantile * error }
    });
    let weight: f64 = rows.iter().map(|r| r.weight).sum();
    let mean = rows.iter().map(|r| r.weight * r.y).sum::<f64>() / weight;
    Some(Fit {
        coefficients: coefficients.collect(),
        bread: (0..width)
            .map(|i| (0..width).map(|j| bread[i][j] / (scale[i] * scale[j])).collect())
            .collect(),
        rss,
        tss: rows.iter().map(|r| r.weight * (r.y - mean) * (r.y - mean)).sum(),
        freedom,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs().max(1.0), "{a} against {b}");
    }

    fn row(x: f64, y: f64, weight: f64) -> Observation {
        Observation { columns: vec![x], y, weight }
    }

    /// Computed by hand: for x = 1..5 and y = 2, 4, 5, 4, 5, the slope is 0.6, the intercept 2.2, and the residual sum
    /// 2.4. The error of the slope is sqrt(0.8 / 10), and t(3) at 97.5 % is 3.182446305.
    #[test]
    fn a_line_by_hand() {
        let rows: Vec<_> =
            [2.0, 4.0, 5.0, 4.0, 5.0].iter().zip(1..).map(|(&y, x)| row(f64::from(x), y, 1.0)).collect();
        let fit = least_squares(&rows).unwrap();
        close(fit.coefficients[0].value, 2.2);
        close(fit.coefficients[1].value, 0.6);
        close(fit.rss, 2.4);
        close(fit.coefficients[1].error, 0.08f64.sqrt());
        close(fit.coefficients[1].high, 0.6 + 3.182_446_305_284_263 * 0.08f64.sqrt());
        close(fit.r_squared(), 0.6);
    }

    #[test]
    fn a_weight_is_a_repetition_in_the_coefficients() {
        let once = [row(1.0, 1.0, 1.0), row(2.0, 3.0, 2.0), row(4.0, 2.0, 1.0)];
        let twice = [row(1.0, 1.0, 1.0), row(2.0, 3.0, 1.0), row(2.0, 3.0, 1.0), row(4.0, 2.0, 1.0)];
        let (a, b) = (least_squares(&once).unwrap(), least_squares(&twice).unwrap());
        close(a.coefficients[1].value, b.coefficients[1].value);
        close(a.rss, b.rss);
    }

    #[test]
    fn what_is_not_determined_has_no_fit() {
        assert_eq!(least_squares(&[]), None);
        assert_eq!(least_squares(&[row(1.0, 1.0, 1.0), row(2.0, 1.0, 1.0)]), None);
        let same = [row(3.0, 1.0, 1.0), row(3.0, 2.0, 1.0), row(3.0, 4.0, 1.0)];
        assert_eq!(least_squares(&same), None);
    }
}
