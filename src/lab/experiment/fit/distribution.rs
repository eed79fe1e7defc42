//! Student's t and Fisher's F, by the regularised incomplete beta function.
//!
//! **Statement.** Let `I_x(a, b)` be the regularised incomplete beta function. With v degrees of freedom and `t >= 0`,
//! `P(T > t) = I_x(v/2, 1/2) / 2` for `x = v / (v + t^2)`. With m and n degrees of freedom, `P(F > f) = I_x(n/2, m/2)`
//! for `x = n / (n + m f)` (DLMF 8.17; Abramowitz and Stegun 26.5.27 and 26.5.28). The relative error is below 1e-12
//! up to a thousand degrees of freedom.

use std::f64::consts::PI;

/// Number of terms after which the continued fraction counts as divergent. About `sqrt(max(a, b))` terms are needed.
const TERMS: u32 = 100_000;

/// The replacement for a partial denominator of zero in the continued fraction.
const TINY: f64 = 1e-300;

/// Returns `ln Gamma(x)` for `x > 0`: Stirling's series (DLMF 5.11.1) at `x + n >= 10`, minus the logarithm of
/// `x (x + 1) .. (x + n - 1)`.
fn ln_gamma(x: f64) -> f64 {
    let (mut z, mut product) = (x, 1.0);
    while z < 10.0 {
        product *= z;
        z += 1.0;
    }
    let w = 1.0 / (z * z);
    let series = [1.0 / 12.0, -1.0 / 360.0, 1.0 / 1260.0, -1.0 / 1680.0, 1.0 / 1188.0, -691.0 / 360_360.0];
    let series = series.iter().rev().fold(0.0, |sum, term| sum * w + term) / z;
    (z - 0.5) * z.ln() - z + 0.5 * (2.0 * PI).ln() + series - product.ln()
}

/// Returns `ln B(a, b)`.
fn ln_beta(a: f64, b: f64) -> f64 {
    ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b)
}

/// Returns `I_x(a, b)` for positive a and b. The argument `y` is `1 - x`, computed by the caller without
/// cancellation.
///
/// The continued fraction of DLMF 8.17.22 converges fast for `x < (a + 1) / (a + b + 2)`. Otherwise
/// `I_x(a, b) = 1 - I_y(b, a)`.
fn beta_regularised(a: f64, b: f64, x: f64, y: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if y <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() + b * y.ln() - ln_beta(a, b)).exp();
    if x < (a + 1.0) / (a + b + 2.0) {
        front * fraction(a, b, x) / a
    } else {
        1.0 - front * fraction(b, a, y) / b
    }
}

/// Returns the continued fraction of `I_x(a, b)`, computed by the modified method of Lentz (Thompson and Barnett
/// 1986), or NaN if it does not converge.
fn fraction(a: f64, b: f64, x: f64) -> f64 {
    let kept = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / kept(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for m in (1..TERMS).map(f64::from) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut step = 1.0;
        for term in [even, odd] {
            d = 1.0 / kept(1.0 + term * d);
            c = kept(1.0 + term / c);
            step = c * d;
            value *= step;
        }
        if (step - 1.0).abs() <= f64::EPSILON {
            return value;
        }
    }
    f64::NAN
}

/// Returns P(T > t), or NaN if there are no degrees of freedom.
pub(super) fn t_above(freedom: f64, t: f64) -> f64 {
    if freedom.is_nan() || freedom <= 0.0 || t.is_nan() {
        return f64::NAN;
    }
    let square = t * t;
    let (x, y) = if square.is_finite() {
        (freedom / (freedom + square), square / (freedom + square))
    } else {
        (0.0, 1.0)
    };
    let above = 0.5 * beta_regularised(0.5 * freedom, 0.5, x, y);
    if t < 0.0 { 1.0 - above } else { above }
}

/// Returns P(F > f), or NaN if there are no degrees of freedom.
pub(super) fn f_above(above: f64, below: f64, f: f64) -> f64 {
    let sound = above > 0.0 && below > 0.0 && !f.is_nan();
    let scaled = above * f.max(0.0);
    match (sound, scaled.is_finite()) {
        (false, _) => f64::NAN,
        (true, false) => 0.0,
        (true, true) => {
            let sum = below + scaled;
            beta_regularised(0.5 * below, 0.5 * above, below / sum, scaled / sum)
        }
    }
}

/// Returns the t with `P(T <= t) = p`, or NaN if there are no degrees of freedom or p is not a probability.
///
/// It uses Newton's method, starting at 0. P(T > t) decreases and is convex for t > 0, so the iterates increase to the
/// root and do not pass it. They stop when rounding prevents a further increase.
pub(super) fn t_quantile(freedom: f64, p: f64) -> f64 {
    if freedom.is_nan() || freedom <= 0.0 || !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    if p < 0.5 {
        return -t_quantile(freedom, 1.0 - p);
    }
    let above = 1.0 - p;
    if above == 0.0 {
        return f64::INFINITY;
    }
    let scale = -ln_beta(0.5 * freedom, 0.5) - 0.5 * freedom.ln();
    let mut t = 0.0;
    loop {
        let density = (scale - 0.5 * (freedom + 1.0) * (t * t / freedom).ln_1p()).exp();
        let next = t + (t_above(freedom, t) - above) / density;
        if next.is_nan() || next <= t * (1.0 + f64::EPSILON) {
            return t;
        }
        t = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance * b.abs(), "{a} against {b}");
    }

    #[test]
    fn gamma_is_the_factorial() {
        close(ln_gamma(0.5), 0.5 * PI.ln(), 1e-14);
        close(ln_gamma(171.0), (1..171).map(|i| f64::from(i).ln()).sum(), 1e-14);
        assert!(ln_gamma(1.0).abs() < 1e-14 && ln_gamma(2.0).abs() < 1e-14);
    }

    /// With 1, 2 and 4 degrees of freedom, the quantile has a closed form (Shaw 2006).
    #[test]
    fn quantiles_with_a_closed_form() {
        for p in [0.5_f64, 0.500_1, 0.75, 0.9, 0.975, 0.995, 0.999_999] {
            let alpha = 4.0 * p * (1.0 - p);
            let q = (alpha.sqrt().acos() / 3.0).cos() / alpha.sqrt();
            let four = 2.0 * (q - 1.0).max(0.0).sqrt();
            let (one, two) = ((PI * (p - 0.5)).tan(), (2.0 * p - 1.0) / (alpha / 2.0).sqrt());
            for (freedom, t, tolerance) in [(1.0, one, 1e-10), (2.0, two, 1e-10), (4.0, four, 1e-7)] {
                close(t_quantile(freedom, p), t, tolerance);
                close(t_quantile(freedom, 1.0 - p), -t, tolerance);
                close(t_above(freedom, t), 1.0 - p, tolerance);
            }
        }
    }

    /// Tables of Student's t, 97.5 % and 99.5 % (NIST/SEMATECH e-Handbook 1.3.6.7.2, with the digits of scipy 1.17).
    #[test]
    fn quantiles_of_tables() {
        for (freedom, inner, outer) in [
            (3.0, 3.182_446_305_284, 5.840_909_309_734),
            (5.0, 2.570_581_835_636, 4.032_142_983_555),
            (10.0, 2.228_138_851_965, 3.169_272_672_617),
            (30.0, 2.042_272_456_301, 2.749_995_653_567),
            (100.0, 1.983_971_518_524, 2.625_890_521_438),
            (1000.0, 1.962_339_080_826, 2.580_754_698_066),
        ] {
            close(t_quantile(freedom, 0.975), inner, 1e-10);
            close(t_quantile(freedom, 0.995), outer, 1e-10);
            close(t_above(freedom, inner), 0.025, 1e-10);
            close(t_above(freedom, -inner), 0.975, 1e-10);
        }
    }

    /// With 2 degrees of freedom in the numerator, P(F > f) is `(1 + 2 f / n)^(-n/2)`. With 1 degree, it is the
    /// two-sided probability of t.
    #[test]
    fn tails_of_f() {
        for n in [1.0, 2.0, 9.0, 60.0, 999.0] {
            for f in [1e-6, 0.3, 1.0, 4.0, 1e3] {
                close(f_above(2.0, n, f), (1.0 + 2.0 * f / n).powf(-0.5 * n), 1e-11);
                close(f_above(1.0, n, f), 2.0 * t_above(n, f.sqrt()), 1e-11);
            }
        }
        // Computed by scipy 1.17.
        close(f_above(3.0, 20.0, 3.5), 0.034_493_103_885_124, 1e-10);
        close(f_above(5.0, 12.0, 0.7), 0.633_962_093_984_679, 1e-10);
        close(f_above(4.0, 60.0, 12.0), 3.148_995_556_138e-7, 1e-10);
    }

    #[test]
    fn ends_and_nonsense() {
        assert_eq!(t_above(3.0, f64::INFINITY), 0.0);
        assert_eq!(t_above(3.0, f64::NEG_INFINITY), 1.0);
        assert_eq!(t_above(3.0, 0.0), 0.5);
        assert_eq!(t_quantile(3.0, 1.0), f64::INFINITY);
        assert_eq!((f_above(2.0, 3.0, 0.0), f_above(2.0, 3.0, f64::INFINITY)), (1.0, 0.0));
        for wrong in [t_above(0.0, 1.0), t_quantile(-1.0, 0.9), t_quantile(3.0, 1.5), f_above(0.0, 1.0, 1.0)]
        {
            assert!(wrong.is_nan());
        }
    }
}
