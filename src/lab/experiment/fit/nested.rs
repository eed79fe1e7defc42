//! The nested test of curvature against log n.

use serde::Serialize;

use super::distribution::{t_above, t_quantile};
use super::ols::{Fit, Interval, Observation, least_squares};

/// Significance level of the test.
pub(super) const SIZE: f64 = 0.01;

/// Power for which the smallest detectable curvature is stated.
const POWER: f64 = 0.95;

/// The quadratic term of `y = a + b L + c L^2`, L = log2 x.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Curvature {
    /// The coefficient c.
    pub quadratic: Interval,
    /// The F statistic of the hypothesis c = 0, with 1 and `freedom` degrees of freedom. It is the square of Student's
    /// t.
    pub f: f64,
    /// Degrees of freedom of the error.
    pub freedom: f64,
    /// Probability of an F of at least this size if c = 0.
    pub p: f64,
    /// Whether p is below 1 %.
    pub bends: bool,
    /// The smallest |c| that the test at 1 % would detect in 95 % of repetitions with this error.
    pub smallest_seen: f64,
    /// The critical value of t.
    pub critical: f64,
}

/// Tests the quadratic term. Returns `None` for fewer than 4 distinct x.
///
/// For the power, the distribution of t under an alternative is approximated by a shifted central distribution. At 10
/// degrees of freedom, the approximation changes the power by less than one percent.
pub(super) fn curvature(rows: &[(f64, f64, f64)]) -> Option<Curvature> {
    let full = parabola(rows)?;
    let quadratic = full.coefficients[2];
    // An exact fit leaves no error to compare with.
    let exact = full.rss <= 1e-24 * rows.iter().map(|r| r.2 * r.1 * r.1).sum::<f64>();
    let t = match (exact, quadratic.value.abs() > 1e-9 * full.coefficients[1].value.abs()) {
        (true, true) => f64::INFINITY,
        (true, false) => 0.0,
        (false, _) => (quadratic.value / quadratic.error).abs(),
    };
    let p = 2.0 * t_above(full.freedom, t);
    let critical = t_quantile(full.freedom, 1.0 - SIZE / 2.0);
    let error = if exact { 0.0 } else { quadratic.error };
    Some(Curvature {
        quadratic,
        f: t * t,
        freedom: full.freedom,
        p,
        bends: p < SIZE,
        smallest_seen: (critical + t_quantile(full.freedom, POWER)) * error,
        critical,
    })
}

/// Fits `y = a + b (L - middle) + c (L - middle)^2`. The shift does not change c and improves the conditioning.
fn parabola(rows: &[(f64, f64, f64)]) -> Option<Fit> {
    let middle = rows.iter().map(|r| r.0.log2()).sum::<f64>() / rows.len().max(1) as f64;
    let row = |&(x, y, weight): &(f64, f64, f64)| {
        let log = x.log2() - middle;
        Observation { columns: vec![log, log * log], y, weight }
    };
    least_squares(&rows.iter().map(row).collect::<Vec<_>>())
}

impl Curvature {
    /// Returns the quadratic term of these rows, which are the fitted values of a law at the same x. Also returns the
    /// probability that the test detects a curvature of this size in data with the error of this fit.
    pub(super) fn power_against(&self, rows: &[(f64, f64, f64)]) -> (f64, f64) {
        let Some(fit) = parabola(rows) else { return (0.0, 0.0) };
        let bend = fit.coefficients[2].value;
        let error = self.smallest_seen / (self.critical + t_quantile(self.freedom, POWER));
        if error > 0.0 {
            (bend, t_above(self.freedom, self.critical - bend.abs() / error))
        } else {
            (bend, f64::from(bend != 0.0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns `law(log2 x)` plus a wave that no parabola follows.
    fn rows(law: impl Fn(f64) -> f64, noise: f64) -> Vec<(f64, f64, f64)> {
        (0..40)
            .map(|i| {
                let log = 10.0 + f64::from(i) / 4.0;
                let wave = if i % 2 == 0 { noise } else { -noise };
                (log.exp2(), law(log) + wave, 1.0)
            })
            .collect()
    }

    #[test]
    fn a_parabola_is_found_and_a_line_is_not() {
        let line = curvature(&rows(|log| 3.0 + 2.0 * log, 0.5)).unwrap();
        assert!(!line.bends && line.p > 0.5, "{line:?}");
        let bent = curvature(&rows(|log| 3.0 + 0.1 * log * log, 0.5)).unwrap();
        assert!(bent.bends && (bent.quadratic.value - 0.1).abs() < 0.02, "{bent:?}");
        assert!(bent.smallest_seen < 0.1);
        let (bend, power) = line.power_against(&rows(|log| 0.1 * log * log, 0.0));
        assert!((bend - 0.1).abs() < 1e-9 && power > 0.95, "{bend} {power}");
        let (_, small) = line.power_against(&rows(|log| 1e-3 * log * log, 0.0));
        assert!(small < 0.05, "{small}");
    }

    #[test]
    fn without_noise_nothing_is_hidden() {
        let line = curvature(&rows(|log| 5.0 * log, 0.0)).unwrap();
        assert!(!line.bends, "{line:?}");
        let bent = curvature(&rows(|log| log * log, 0.0)).unwrap();
        assert!(bent.bends, "{bent:?}");
    }
}
