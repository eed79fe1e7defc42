//! The largest share of a faster-growing law that the data do not exclude.
//!
//! **Statement.** Let g be the law of a conclusion, h a law of [`Law`] that grows faster, and X the largest size. The
//! fit `y = a + b g(x) + c h(x)` over the means at each size has the two-sided 95 % interval `[low, high]` of c, by
//! Student's t. The share of h is `c h(X) / y(X)`, where y(X) is the fitted value. [`NotExcluded::share`] is
//! `max(0, high) h(X) / y(X)`: a mixture with a larger share is rejected at a one-sided level of 2.5 %. If the
//! conclusion names several laws, g is the lowest of them. If the count does not grow, g is absent and the fit is
//! `y = a + c h(x)`.
//!
//! **Several higher laws.** A check that every share is at most a bound rejects a union of hypotheses ("some law has a
//! larger share"). It passes only if each hypothesis is rejected, so its level is 2.5 % without a correction (Berger
//! 1982).
//!
//! **Departures.** y(X) is treated as known, because its relative error is far below that of c. The share refers to the
//! whole count, including the constant a. A share can exceed 1: in such a mixture, a or b is negative.

use serde::Serialize;

use super::conclusion::Conclusion;
use super::design::Law;
use super::growth::Growth;
use super::ols::{Observation, least_squares};

/// A *higher* law, which grows faster than the law of the conclusion, and the largest share of it that the data do not
/// exclude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct NotExcluded {
    /// The higher law.
    pub law: Law,
    /// The share of the law in the count at the largest size. Larger shares are excluded at a one-sided level of 2.5 %.
    pub share: f64,
}

impl NotExcluded {
    /// Returns the law and its share, rounded up to a whole percent. Shares of 1 or more are "all of" the law.
    pub(super) fn words(&self) -> String {
        let law = self.law.name();
        if self.share < 1.0 {
            format!("{:.0} % of {law}", (100.0 * self.share).ceil())
        } else {
            format!("all of {law}")
        }
    }
}

/// Returns the laws above the conclusion with their shares, the largest share first. The list is empty if the
/// conclusion names no law, or if no [`Law`] is higher.
pub(super) fn not_excluded(growth: &Growth, conclusion: &Conclusion, dimension: usize) -> Vec<NotExcluded> {
    let Some(base) = Base::of(conclusion) else { return Vec::new() };
    let higher = Law::all(dimension).filter(|&law| base.is_below(law));
    let mut shares: Vec<NotExcluded> =
        higher.map(|law| NotExcluded { law, share: share(growth, base, law, dimension) }).collect();
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    shares
}

/// The law that a conclusion names, or a constant.
#[derive(Clone, Copy, Debug)]
enum Base {
    Constant,
    Law(Law),
}

impl Base {
    fn of(conclusion: &Conclusion) -> Option<Base> {
        match conclusion {
            Conclusion::Flat | Conclusion::Unclear => Some(Base::Constant),
            Conclusion::Law { law } => Some(Base::Law(*law)),
            Conclusion::CannotTell { laws } => laws.iter().min().copied().map(Base::Law),
            _ => None,
        }
    }

    fn is_below(self, law: Law) -> bool {
        match self {
            Base::Constant => true,
            Base::Law(base) => base < law,
        }
    }

    fn columns(self, higher: Law, x: f64, dimension: usize) -> Vec<f64> {
        let own = match self {
            Base::Constant => None,
            Base::Law(law) => Some(law),
        };
        own.into_iter().chain([higher]).map(|law| law.at(x, dimension)).collect()
    }
}

/// Returns the share of the higher law, or infinity if the sizes do not determine it.
fn share(growth: &Growth, base: Base, higher: Law, dimension: usize) -> f64 {
    let columns = |x: f64| base.columns(higher, x, dimension);
    let rows: Vec<Observation> = growth
        .rows()
        .into_iter()
        .map(|(x, y, weight)| Observation { columns: columns(x), y, weight })
        .collect();
    let largest = growth.table.iter().map(|row| row.x).fold(f64::NEG_INFINITY, f64::max);
    let Some(fit) = least_squares(&rows) else { return f64::INFINITY };
    let most = fit.coefficients.last().map_or(f64::INFINITY, |c| c.high) * higher.at(largest, dimension);
    let value = fit.at(&columns(largest));
    match (most > 0.0, value > 0.0) {
        (false, _) => 0.0,
        (true, true) => most / value,
        (true, false) => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::data::Measurement;
    use super::super::growth::{How, growth};
    use super::*;

    /// Returns the shares of one draw: 80 sizes over ten octaves, with a sawtooth of one tooth per octave and noise,
    /// both of this relative height.
    fn draw(law: impl Fn(f64) -> f64, height: f64, rng: &mut ChaCha8Rng) -> (Conclusion, Vec<NotExcluded>) {
        let values: Vec<Measurement> = (0..80)
            .map(|i| {
                let log = 10.0 + f64::from(i) / 7.9;
                let tooth = log.fract() - 0.5 + rng.random_range(-1.0..1.0);
                let (x, y) = (log.exp2(), law(log) * (1.0 + height * tooth));
                Measurement { asked: x as u64, seed: 1, x, y }
            })
            .collect();
        let how = How { dimension: 3, relative: false, margin: 0.05 };
        let growth = growth(&values, how).unwrap();
        let conclusion = Conclusion::of_growth(&growth);
        let shares = not_excluded(&growth, &conclusion, 3);
        (conclusion, shares)
    }

    /// The planted mixture `95 L + 0.5 L^2` has 9.5 % of log^2 n at L = 20. An upper end of a 95 % interval misses it
    /// in 2.5 % of draws.
    #[test]
    fn a_planted_share_is_not_excluded() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut covered, mut sum, mut times) = (0, 0.0, 0);
        for _ in 0..400 {
            let (conclusion, shares) = draw(|log| 95.0 * log + 0.5 * log * log, 0.02, &mut rng);
            let base = matches!(&conclusion, Conclusion::Law { law: Law::Log })
                || matches!(&conclusion, Conclusion::CannotTell { laws } if laws.contains(&Law::Log));
            if !base {
                continue;
            }
            let squared = shares.iter().find(|s| s.law == Law::LogSquared).unwrap();
            covered += i32::from(squared.share >= 0.095);
            sum += squared.share;
            times += 1;
        }
        assert!(times > 350, "{times}");
        let (covered, mean) = (f64::from(covered) / f64::from(times), sum / f64::from(times));
        println!("covered {covered}, mean share {mean}");
        assert!(covered >= 0.95, "{covered}");
        assert!((0.1..0.4).contains(&mean), "{mean}");
    }

    #[test]
    fn shares_fall_with_the_noise() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let [small, large] = [0.001, 0.02].map(|height| draw(|log| 50.0 + 95.0 * log, height, &mut rng).1);
        let of = |shares: &[NotExcluded], law| shares.iter().find(|s| s.law == law).unwrap().share;
        for law in [Law::LogThreeHalves, Law::LogSquared, Law::Root, Law::LinearLogSquared] {
            assert!(of(&small, law) < 0.2 * of(&large, law), "{law:?}: {small:?} {large:?}");
        }
        assert!(of(&small, Law::LogSquared) < 0.03, "{small:?}");
        // The nearest law is the hardest to exclude.
        assert_eq!(large[0].law, Law::LogThreeHalves);
        let (conclusion, shares) = draw(|log| 3.0 * log.exp2() * log * log, 0.01, &mut rng);
        assert_eq!((conclusion, shares), (Conclusion::Law { law: Law::LinearLogSquared }, Vec::new()));
    }
}
