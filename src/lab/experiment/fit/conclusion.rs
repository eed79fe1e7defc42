//! The conclusion on the growth of a count.

use serde::Serialize;

use super::design::Law;
use super::equivalence::Equivalence;
use super::growth::{Growth, LawFit};
use super::lack::rejects;

/// A law remains possible if its Akaike criterion exceeds that of the best law by at most this difference, `2 ln 100`.
/// The best law is then at most a hundred times as likely as the other law.
pub(super) const APART: f64 = 9.210_340_371_976_182;

/// If the test for curvature finds none, it excludes the laws against which it has at least this power.
const ENOUGH: f64 = 0.95;

/// A conclusion.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "says", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Conclusion {
    /// The count does not grow: two one-sided tests find its change over the range of sizes within the margin.
    Flat,
    /// Growth is not significant, but a change beyond the margin is not excluded either.
    Unclear,
    /// The count grows like this law, and like no other [`Law`].
    Law {
        /// The law.
        law: Law,
    },
    /// The count grows, but these sizes do not distinguish the laws.
    CannotTell {
        /// The laws.
        laws: Vec<Law>,
    },
    /// The count grows, but no [`Law`] fits.
    NoneOfThese,
    /// The count bends downwards against log n: it grows more slowly than any [`Law`].
    Slower,
    /// The count decreases.
    Falls,
    /// The depth of a level does not depend on its size, within the margin.
    SizeFree,
    /// The depth of a level depends on its size by more than the margin.
    SizeBound,
    /// The confidence interval contains an end of the margin.
    SizeUnclear,
}

impl Conclusion {
    /// Returns the conclusion on growth. `growth.laws` must be ordered by likelihood, beginning with the best law.
    pub(super) fn of_growth(growth: &Growth) -> Conclusion {
        let (laws, curvature) = (&growth.laws, &growth.curvature);
        if growth.is_flat() {
            return Conclusion::Flat;
        }
        let log = laws.iter().find(|fit| fit.law == Law::Log);
        let slope = log.map_or(0.0, |fit| fit.slope.value);
        let sure = log.is_some_and(|fit| fit.slope.low > 0.0 || fit.slope.high < 0.0);
        if !curvature.bends && !sure {
            return Conclusion::Unclear;
        }
        if slope < 0.0 {
            return Conclusion::Falls;
        }
        if curvature.bends && curvature.quadratic.value < 0.0 {
            return Conclusion::Slower;
        }
        let fits = |fit: &&LawFit| fit.slope.value > 0.0 && !rejects(fit.lack_of_fit);
        let mut running: Vec<Law> =
            laws.iter().filter(fits).filter(|fit| fit.behind <= APART).map(|fit| fit.law).collect();
        if curvature.bends {
            // A count with significant curvature is not linear in log n, even if that law is likely.
            running.retain(|&law| law != Law::Log);
        } else {
            // No curvature is significant. A law is excluded if the test would have found its curvature.
            running.retain(|&law| law == Law::Log || laws.iter().any(|f| f.law == law && f.power < ENOUGH));
            if !running.contains(&Law::Log) && log.as_ref().is_some_and(fits) {
                running.push(Law::Log);
            }
        }
        running.sort_unstable();
        match running.as_slice() {
            [law] => Conclusion::Law { law: *law },
            [] => Conclusion::NoneOfThese,
            _ => Conclusion::CannotTell { laws: running },
        }
    }

    pub(super) fn of_levels(test: &Equivalence) -> Conclusion {
        match (test.flat, test.sloped) {
            (true, _) => Conclusion::SizeFree,
            (_, true) => Conclusion::SizeBound,
            _ => Conclusion::SizeUnclear,
        }
    }

    /// Returns the conclusion as one clause, without shares and exponent.
    pub fn words(&self) -> String {
        match self {
            Conclusion::Flat => "it does not grow at these n, within the margin".to_string(),
            Conclusion::Law { law } => format!("it grows like {}", law.name()),
            Conclusion::Unclear => "its growth at these n is unclear".to_string(),
            Conclusion::NoneOfThese => "it grows, but like none of these laws".to_string(),
            Conclusion::CannotTell { laws } => {
                let names: Vec<&str> = laws.iter().map(|law| law.name()).collect();
                format!("it grows, but these n do not distinguish {}", names.join(", "))
            }
            Conclusion::Slower => "it grows more slowly than log n".to_string(),
            Conclusion::Falls => "it falls".to_string(),
            Conclusion::SizeFree => {
                "the depth of a level does not depend on its size, within the margin".to_string()
            }
            Conclusion::SizeBound => "the depth of a level depends on its size".to_string(),
            Conclusion::SizeUnclear => {
                "it is unclear whether the depth of a level depends on its size".to_string()
            }
        }
    }
}

impl Growth {
    /// Returns `true` if an equivalence test finds no growth. The test fits a straight line, which cannot show a bend.
    /// If the means bend, their spread must therefore also be within the margin.
    fn is_flat(&self) -> bool {
        let straight = self.change.low.abs().max(self.change.high.abs()) < self.margin;
        let means = || self.table.iter().map(|row| row.mean);
        let spread = means().fold(f64::NEG_INFINITY, f64::max) - means().fold(f64::INFINITY, f64::min);
        let mean = means().sum::<f64>() / self.table.len().max(1) as f64;
        straight && (!self.curvature.bends || spread <= self.margin * mean)
    }
}
