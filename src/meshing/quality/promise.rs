//! What is promised of radius-edge ratios.
//!
//! **Statement.** Where features meet at no less than 90 degrees, a cell with its circumcentre in the domain has `R/l <= g / (1 - g L)`,
//! where g depends on the balls that hold the centre ([`super::balls`]):
//!
//! | the centre lies in | g |
//! | --- | --- |
//! | no ball | 1 |
//! | that of a piece, or of a triangle with `r <= f(m)` above which it stands | `sqrt(2) / (1 - L)` |
//! | only those of triangles with `f(m) < r <= k f(m)` | the smaller of `sqrt(2) k / (1 - k L)` and `max sqrt(4 - 2 d^2) / (1 - L sqrt(3 + 2 d))` over d from 0 to `sqrt(2)` |
//!
//! The proof is in the header of [`crate::generate`]. Nothing is promised where `g L >= 1`.
//!
//! *The maximum over d is bounded from above*: its numerator falls and its denominator falls, so on each of `STEPS` parts the numerator
//! at the lower end over the denominator at the upper end is no less.
//!
//! **Work and depth.** `STEPS`.

/// Parts of the range of d.
const STEPS: u32 = 1 << 14;

/// The radius-edge bounds that hold where features meet at no less than 90 degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// Of cells whose circumcentres lie in the domain and in no ball: `1/(1-L)`.
    pub free: f64,
    /// Of those in the ball of a piece, or above a triangle that is no larger than f.
    pub near: Option<f64>,
    /// Of those above a triangle that is larger than f.
    pub above: Option<f64>,
}

impl Promise {
    /// The bounds at this Lipschitz constant, whatever the mesh.
    pub fn of(lipschitz: f64) -> Self {
        Self::with(lipschitz, f64::INFINITY)
    }

    /// The bounds where no triangle has more than `widest` times the size at its centre.
    pub fn with(lipschitz: f64, widest: f64) -> Self {
        let measured = wide(lipschitz, widest.max(1.0));
        let above = [measured, above_any(lipschitz)].into_iter().flatten().reduce(f64::min);
        Promise {
            free: 1.0 / (1.0 - lipschitz),
            near: wide(lipschitz, 1.0).and_then(|g| bound(g, lipschitz)),
            above: above.and_then(|g| bound(g, lipschitz)),
        }
    }

    /// The bounds of free and near cells and of those above large triangles.
    pub fn all(self) -> [Option<f64>; 3] {
        [Some(self.free), self.near, self.above]
    }
}

/// `g / (1 - g L)`.
fn bound(g: f64, lipschitz: f64) -> Option<f64> {
    (g * lipschitz < 1.0).then(|| g / (1.0 - g * lipschitz))
}

/// g above triangles that are no larger than `widest` times the size at their centres.
fn wide(lipschitz: f64, widest: f64) -> Option<f64> {
    let part = widest * lipschitz;
    (widest.is_finite() && part < 1.0).then(|| std::f64::consts::SQRT_2 * widest / (1.0 - part))
}

/// g above triangles whose centres lie in the ball of a piece.
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
    fn bounds_are_what_the_table_says() {
        assert_eq!(Promise::of(0.5).all(), [Some(2.0), None, None]);
        let none = Promise::of(0.0);
        assert_eq!(none.free, 1.0);
        assert!((none.near.unwrap() - 2f64.sqrt()).abs() < 1e-15);
        assert!((none.above.unwrap() - 2.0).abs() < 1e-3, "{none:?}");
        // Where every triangle is complete, nothing distinguishes those above it.
        let complete = Promise::with(0.25, 0.9);
        assert_eq!(complete.near, complete.above);
        for lipschitz in [0.06, 0.12, 0.25] {
            let (any, some) = (Promise::of(lipschitz), Promise::with(lipschitz, 1.2));
            assert!(some.above <= any.above && some.near == any.near && some.near < some.above);
            // The bound on parts is no less than the function at their ends, and not much more.
            let at =
                |d: f64| (4.0 - 2.0 * d * d).max(0.0).sqrt() / (1.0 - lipschitz * (3.0 + 2.0 * d).sqrt());
            let most = (0..=1000).map(|i| at(f64::from(i) * 1e-3 * 2f64.sqrt())).fold(0.0, f64::max);
            let g = above_any(lipschitz).unwrap();
            assert!(g >= most && g < 1.01 * most, "{lipschitz}: {g} {most}");
        }
    }
}
