//! A measured number and its bound.

use serde::{Deserialize, Deserializer, Serialize};

/// The relation of a figure to its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// The value is at most the bound.
    AtMost,
    /// The value is at least the bound.
    AtLeast,
}

/// A measured number and its bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Figure {
    /// The measured quantity.
    pub what: String,
    /// The points on which it was measured.
    pub on: String,
    /// The first seed of the sets and of the runs.
    pub seed: u64,
    /// The measured value.
    #[serde(deserialize_with = "number")]
    pub value: f64,
    /// The required relation to the bound.
    pub relation: Relation,
    /// The bound.
    pub bound: f64,
    /// Whether the figure belongs to the printed statement of a claim that is checked in another reading. Such a figure
    /// is reported, but does not decide whether the claim passes.
    pub as_printed: bool,
    /// The p-value: if the true value were at the bound, the probability of an estimate at least this far on the
    /// permitted side of it. `None` for a figure without statistical error.
    pub p: Option<f64>,
}

/// Returns the larger value. NaN counts as larger than any number.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Returns the largest value, or NaN if there are no values or one of them is NaN.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().reduce(worse).unwrap_or(f64::NAN)
}

/// Returns the smallest value, or NaN if there are no values or one of them is NaN.
pub(super) fn smallest(values: impl IntoIterator<Item = f64>) -> f64 {
    -largest(values.into_iter().map(|value| -value))
}

/// Reads a number. JSON has `null` instead of a number that is not finite.
fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}

impl Figure {
    pub(super) fn at_most(
        what: impl Into<String>,
        on: impl Into<String>,
        seed: u64,
        value: f64,
        bound: f64,
    ) -> Figure {
        let (what, on) = (what.into(), on.into());
        Figure { what, on, seed, value, relation: Relation::AtMost, bound, as_printed: false, p: None }
    }

    pub(super) fn at_least(
        what: impl Into<String>,
        on: impl Into<String>,
        seed: u64,
        value: f64,
        bound: f64,
    ) -> Figure {
        Figure { relation: Relation::AtLeast, ..Figure::at_most(what, on, seed, value, bound) }
    }

    /// Adds the p-value of the test of the figure against its bound.
    pub(super) fn with_p(self, p: f64) -> Figure {
        Figure { p: Some(p), ..self }
    }

    /// Marks the figure as belonging to the printed statement.
    pub(super) fn printed(self) -> Figure {
        Figure { as_printed: true, ..self }
    }

    /// Returns `true` if the value satisfies the bound. NaN satisfies no bound.
    pub fn holds(&self) -> bool {
        match self.relation {
            Relation::AtMost => self.value <= self.bound,
            Relation::AtLeast => self.value >= self.bound,
        }
    }

    /// Returns the ratio of the value to an upper bound, or of a lower bound to the value. It is 1 at the bound and
    /// above 1 beyond it.
    pub(super) fn strain(&self) -> f64 {
        let (above, below) = match self.relation {
            Relation::AtMost => (self.value, self.bound),
            Relation::AtLeast => (self.bound, self.value),
        };
        match (self.holds(), below == 0.0) {
            // If the bound holds with a divisor of zero, the figure ranks between values far from their bound and
            // values close to it.
            (true, true) => 0.5,
            (false, true) => f64::INFINITY,
            // A figure without a value is decisive.
            _ if self.value.is_nan() => f64::INFINITY,
            _ => above / below,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_undefined_value_satisfies_no_bound() {
        for figure in [
            Figure::at_most("depth", "no points", 1, f64::NAN, f64::INFINITY),
            Figure::at_least("depth", "no points", 1, f64::NAN, 0.0),
        ] {
            assert!(!figure.holds() && figure.strain().is_infinite(), "{figure:?}");
        }
        assert!([[1.0, f64::NAN], [f64::NAN, 1.0]].into_iter().all(|[a, b]| worse(a, b).is_nan()));
        assert_eq!([largest([1.0, 2.0, 0.5]), smallest([1.0, 2.0, 0.5])], [2.0, 0.5]);
        assert!(largest([]).is_nan() && smallest([]).is_nan() && smallest([1.0, f64::NAN]).is_nan());
    }
}
