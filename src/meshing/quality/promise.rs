//! The promise about radius-edge ratios.
//!
//! **Statement.** Let no two features meet at less than 90 degrees. Then a cell with its circumcentre in the domain has
//! `R/l <= g / (1 - g L)`. The factor g depends on the balls that contain the centre ([`super::balls`]):
//!
//! | the centre lies in | g |
//! | --- | --- |
//! | no ball | 1 |
//! | the ball of a subsegment, or that of the subfacet below it, with `r <= f(m)` | `sqrt(2) / (1 - L)` |
//! | only balls of subfacets with `f(m) < r <= k f(m)` | the smaller of `sqrt(2) k / (1 - k L)` and `max sqrt(4 - 2 d^2) / (1 - L sqrt(3 + 2 d))` over d from 0 to `sqrt(2)` |
//!
//! The proof is in the header of [`crate::generate`]. Nothing is promised if `g L >= 1`.
//!
//! *An upper bound for the maximum over d.* Numerator and denominator decrease in d. On each of `STEPS` parts, the
//! numerator at the lower end divided by the denominator at the upper end is therefore an upper bound.
//!
//! **Measured.** The largest ratios of the generator's test domains: cube, L-shape, cubic hole, slanted box, two
//! regions and dangling elements.
//!
//! | L | free | near | above, any k | largest R/l found: free, near, above | largest k found |
//! | --- | --- | --- | --- | --- | --- |
//! | 0.06 | 1.0638 | 1.6538 | 2.5814 | 1.0205, 1.1324, 1.0716 | 1.151 |
//! | 0.12 | 1.1364 | 1.9910 | 3.6604 | 1.0890, 1.1948, 1.0838 | 1.141 |
//! | 0.25 | 1.3333 | 3.5672 | 58.7622 | 1.2408, 1.3979, 1.1620 | 1.209 |
//! | 0.5 | 2.0000 | none | none | 1.3995, 2.0426, 1.3497 | 1.628 |
//!
//! `cargo test -p septet-meshing ratios_keep -- --nocapture` repeats the measurement. `generate/tests/promises` asserts
//! the bounds exactly, for every cell.
//!
//! **Work and depth.** `STEPS` evaluations.

/// The number of parts of the range of d.
const STEPS: u32 = 1 << 14;

/// The radius-edge bounds if no two features meet at less than 90 degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// The bound for cells whose centre lies in the domain and in no ball: `1/(1-L)`.
    pub free: f64,
    /// The bound for cells whose centre lies in the ball of a subsegment, or above a subfacet with `r <= f(m)`.
    pub near: Option<f64>,
    /// The bound for cells whose centre lies above a subfacet with `r > f(m)`.
    pub above: Option<f64>,
}

impl Promise {
    /// Returns the bounds for a Lipschitz constant that hold for any mesh.
    pub fn of(lipschitz: f64) -> Self {
        Self::with(lipschitz, f64::INFINITY)
    }

    /// Returns the bounds if no subfacet has a radius above `widest` times the size at its centre.
    pub fn with(lipschitz: f64, widest: f64) -> Self {
        let measured = wide(lipschitz, widest.max(1.0));
        let above = [measured, above_any(lipschitz)].into_iter().flatten().reduce(f64::min);
        Promise {
            free: 1.0 / (1.0 - lipschitz),
            near: wide(lipschitz, 1.0).and_then(|g| bound(g, lipschitz)),
            above: above.and_then(|g| bound(g, lipschitz)),
        }
    }

    /// Returns the bounds of free cells, near cells, and cells above large subfacets.
    pub fn all(self) -> [Option<f64>; 3] {
        [Some(self.free), self.near, self.above]
    }
}

/// Returns `g / (1 - g L)`, or `None` if `g L >= 1`.
fn bound(g: f64, lipschitz: f64) -> Option<f64> {
    (g * lipschitz < 1.0).then(|| g / (1.0 - g * lipschitz))
}

/// Returns g for centres above subfacets with radii of at most `widest` times the size at their centres.
fn wide(lipschitz: f64, widest: f64) -> Option<f64> {
    let part = widest * lipschitz;
    (widest.is_finite() && part < 1.0).then(|| std::f64::consts::SQRT_2 * widest / (1.0 - part))
}

/// Returns g for centres above subfacets whose centres lie in the ball of a subsegment.
fn above_any(lipschitz: f64) -> Option<f64> {
    let step = std::f64::consts::SQRT_2 / f64::from(STEPS);
    let part = |i: u32| {
        let [low, high] = [i, i + 1].map(|i| f64::from(i) * step);
        (4.0 - 2.0 * low * low).max(0.0).sqrt() / (1.0 - lipschitz * (3.0 + 2.0 * high).sqrt())
    };
    let last = 1.0 - lipschitz * (1.0 + std::f64::consts::SQRT_2);
    (last > 0.0).then(|| (0..STEPS).map(part).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_agree_with_the_table() {
        assert_eq!(Promise::of(0.5).all(), [Some(2.0), None, None]);
        let none = Promise::of(0.0);
        assert_eq!(none.free, 1.0);
        assert!((none.near.unwrap() - 2f64.sqrt()).abs() < 1e-15);
        assert!((none.above.unwrap() - 2.0).abs() < 1e-3, "{none:?}");
        // If every subfacet is complete, the bounds above and near agree.
        let complete = Promise::with(0.25, 0.9);
        assert_eq!(complete.near, complete.above);
        for lipschitz in [0.06, 0.12, 0.25] {
            let (any, some) = (Promise::of(lipschitz), Promise::with(lipschitz, 1.2));
            assert!(some.above <= any.above && some.near == any.near && some.near < some.above);
            // The bound per part is an upper bound of the function at its ends, and not much larger.
            let at =
                |d: f64| (4.0 - 2.0 * d * d).max(0.0).sqrt() / (1.0 - lipschitz * (3.0 + 2.0 * d).sqrt());
            let most = (0..=1000).map(|i| at(f64::from(i) * 1e-3 * 2f64.sqrt())).fold(0.0, f64::max);
            let g = above_any(lipschitz).unwrap();
            assert!(g >= most && g < 1.01 * most, "{lipschitz}: {g} {most}");
        }
    }
}
