//! A measured number and its bound.

use serde::Serialize;

/// How a figure stands to its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// Not above.
    AtMost,
    /// Not below.
    AtLeast,
}

/// A measured number and its bound.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What was measured.
    pub what: String,
    /// On which points.
    pub on: String,
    /// The first seed of the sets and of the runs.
    pub seed: u64,
    /// The number.
    pub value: f64,
    /// How it has to stand to the bound.
    pub relation: Relation,
    /// The bound.
    pub bound: f64,
    /// Of the sentence as printed, where the claim is judged by another reading: reported, not judged.
    pub as_printed: bool,
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
        Figure { what, on, seed, value, relation: Relation::AtMost, bound, as_printed: false }
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

    /// Of the sentence as printed.
    pub(super) fn printed(self) -> Figure {
        Figure { as_printed: true, ..self }
    }

    /// Does it keep its bound? What is no number keeps none.
    pub fn holds(&self) -> bool {
        match self.relation {
            Relation::AtMost => self.value <= self.bound,
            Relation::AtLeast => self.value >= self.bound,
        }
    }

    /// How near it is to its bound: 1 at the bound, above 1 beyond it.
    pub(super) fn strain(&self) -> f64 {
        let (above, below) = match self.relation {
            Relation::AtMost => (self.value, self.bound),
            Relation::AtLeast => (self.bound, self.value),
        };
        match (self.holds(), below == 0.0) {
            // Nothing where nothing is allowed says more than what is far from its bound, and less than what is near.
            (true, true) => 0.5,
            (false, true) => f64::INFINITY,
            _ => above / below,
        }
    }
}
