//! What the numbers say, in words.

use serde::{Deserialize, Serialize};

use super::design::Law;
use super::equivalence::Equivalence;
use super::nested::Curvature;
use super::report::LawFit;

/// A law is left in the running while the best one is less than a hundred times as likely: Akaike's criterion
/// within 2 ln 100.
pub(super) const APART: f64 = 9.210_340_371_976_182;

/// Power of the test for curvature above which a law is out if the test found none.
const ENOUGH: f64 = 0.95;

/// A verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "says", rename_all = "kebab-case")]
pub enum Verdict {
    /// The count does not grow.
    Flat,
    /// It grows like this law, and no other of the list.
    Law {
        /// Which.
        law: Law,
    },
    /// It grows; laws that these sizes do not tell apart.
    CannotTell {
        /// Which.
        laws: Vec<Law>,
    },
    /// It bends downwards against log n: slower than any law of the list.
    Slower,
    /// It falls.
    Falls,
    /// The depth of a level does not depend on its size, within the margin.
    SizeFree,
    /// It does, by more than the margin.
    SizeBound,
    /// The interval reaches over the margin's end.
    SizeUnclear,
}

impl Verdict {
    /// The verdict on growth: `laws` by likelihood, the best first.
    pub(super) fn of_growth(laws: &[LawFit], curvature: &Curvature) -> Verdict {
        let log = laws.iter().find(|fit| fit.law == Law::Log);
        let slope = log.map_or(0.0, |fit| fit.slope.value);
        let sure = log.is_some_and(|fit| fit.slope.low > 0.0 || fit.slope.high < 0.0);
        if !curvature.bends && !sure {
            return Verdict::Flat;
        }
        if slope < 0.0 {
            return Verdict::Falls;
        }
        if curvature.bends && curvature.quadratic.value < 0.0 {
            return Verdict::Slower;
        }
        let mut running: Vec<Law> = laws
            .iter()
            .filter(|fit| fit.behind <= APART && fit.slope.value > 0.0)
            .map(|fit| fit.law)
            .collect();
        if curvature.bends {
            // What bends is not linear in log n, however likely.
            running.retain(|&law| law != Law::Log);
        } else {
            // Straight, so far as can be seen: out is what would have been seen to bend.
            running.retain(|&law| law == Law::Log || laws.iter().any(|f| f.law == law && f.power < ENOUGH));
            if !running.contains(&Law::Log) {
                running.push(Law::Log);
            }
        }
        running.sort_unstable();
        match running.as_slice() {
            [law] => Verdict::Law { law: *law },
            [] => Verdict::CannotTell { laws: laws.iter().take(1).map(|fit| fit.law).collect() },
            _ => Verdict::CannotTell { laws: running },
        }
    }

    pub(super) fn of_levels(test: &Equivalence) -> Verdict {
        match (test.flat, test.sloped) {
            (true, _) => Verdict::SizeFree,
            (_, true) => Verdict::SizeBound,
            _ => Verdict::SizeUnclear,
        }
    }

    /// One sentence.
    pub fn words(&self) -> String {
        match self {
            Verdict::Flat => "it does not grow at these n".to_string(),
            Verdict::Law { law } => format!("it grows like {}", law.name()),
            Verdict::CannotTell { laws } if laws.len() == 1 => {
                format!("it grows faster than log n; {} is nearest, and does not fit", laws[0].name())
            }
            Verdict::CannotTell { laws } => {
                let names: Vec<&str> = laws.iter().map(|law| law.name()).collect();
                format!("it grows; cannot tell {} apart at these n", names.join(", "))
            }
            Verdict::Slower => "it grows more slowly than log n".to_string(),
            Verdict::Falls => "it falls".to_string(),
            Verdict::SizeFree => {
                "the depth of a level does not depend on its size, within the margin".to_string()
            }
            Verdict::SizeBound => "the depth of a level depends on its size".to_string(),
            Verdict::SizeUnclear => {
                "cannot tell whether the depth of a level depends on its size".to_string()
            }
        }
    }
}
