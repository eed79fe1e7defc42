//! A factor in the text of a fault.

use std::fmt;
use std::str::FromStr;

/// A positive factor of at most a million, so that no count overflows. Its text determines it exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor(f64);

// A factor is never NaN.
impl Eq for Factor {}

impl Factor {
    /// The factor 1.
    pub const ONE: Factor = Factor(1.0);

    /// The largest factor.
    const MOST: f64 = 1e6;

    /// Returns the factor, or `None` if the number is not positive or too large.
    pub fn new(value: f64) -> Option<Factor> {
        (value > 0.0 && value <= Factor::MOST).then_some(Factor(value))
    }

    /// Returns the number.
    pub fn value(self) -> f64 {
        self.0
    }
}

impl fmt::Display for Factor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for Factor {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        text.parse().ok().and_then(Factor::new).ok_or(())
    }
}
