//! A power law fitted to measured points, with a confidence interval.
//!
//! The fit is ordinary least squares of `ln y` over `ln x`. The exponent has a 95 % confidence interval by Student's
//! t, which assumes that the model is correct.

use septet_lab::experiment::fit::{Observation, least_squares};

/// `y = c x^e`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PowerLaw {
    pub(super) coefficient: f64,
    pub(super) exponent: f64,
    /// Half the width of the 95 % confidence interval of the exponent; `None` for fewer than three points.
    pub(super) margin: Option<f64>,
}

/// Fits points with positive coordinates. Returns `None` if all abscissae are equal.
pub(super) fn power_law(points: &[(f64, f64)]) -> Option<PowerLaw> {
    let logs: Vec<(f64, f64)> =
        points.iter().filter(|p| p.0 > 0.0 && p.1 > 0.0).map(|p| (p.0.ln(), p.1.ln())).collect();
    let (constant, exponent) = straight(&logs)?;
    let row = |&(x, y): &(f64, f64)| Observation { columns: vec![x], y, weight: 1.0 };
    let fit = least_squares(&logs.iter().map(row).collect::<Vec<_>>());
    let margin = fit.map(|fit| fit.coefficients[1].high - fit.coefficients[1].value);
    Some(PowerLaw { coefficient: constant.exp(), exponent, margin })
}

/// Fits the coefficient of a law: the geometric mean of `y / law(x)`.
pub(super) fn scaled(points: &[(f64, f64)], law: impl Fn(f64) -> f64) -> Option<f64> {
    let logs: Vec<f64> =
        points.iter().map(|&(x, y)| y / law(x)).filter(|r| *r > 0.0 && r.is_finite()).map(f64::ln).collect();
    (!logs.is_empty()).then(|| (logs.iter().sum::<f64>() / logs.len() as f64).exp())
}

/// Returns the least-squares line `a + b x`, or `None` if all abscissae are equal.
pub(super) fn straight(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let sxx: f64 = points.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / sxx;
    (points.len() > 1 && sxx > 1e-12).then_some((my - slope * mx, slope))
}

impl PowerLaw {
    /// Describes the law in words.
    pub(super) fn words(&self) -> String {
        match self.margin {
            Some(margin) => format!("fitted exponent {:.2} ± {margin:.2}", self.exponent),
            None => format!("fitted exponent {:.2}", self.exponent),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_found() {
        let exact: Vec<(f64, f64)> = (1..9).map(|i| (f64::from(i), 3.0 * f64::from(i).powf(0.66))).collect();
        let law = power_law(&exact).unwrap();
        assert!((law.exponent - 0.66).abs() < 1e-9 && (law.coefficient - 3.0).abs() < 1e-9);
        assert!(law.margin.unwrap() < 1e-6);
        assert_eq!(power_law(&[(2.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(power_law(&exact[..2]).unwrap().margin, None);
        assert!((scaled(&exact, |x| x.powf(0.66)).unwrap() - 3.0).abs() < 1e-9);
        let (a, b) = straight(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]).unwrap();
        assert!((a - 3.0).abs() < 1e-9 && (b - 2.0).abs() < 1e-9);
        // Steps of slope 1 and 3: the interval around 2 contains both.
        let noisy = [(1.0, 1.0), (2.0, 2.0), (4.0, 16.0)];
        let law = power_law(&noisy).unwrap();
        assert!((law.exponent - 2.0).abs() < 1e-9 && law.margin.unwrap() > 1.0);
    }
}
