//! k of a nearest-neighbour graph.

use std::fmt;

/// The k of [`Neighbours::Auto`].
pub const FALLBACK_K: u32 = 48;

/// k of a nearest-neighbour graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Neighbours {
    /// 48, or all other points if there are fewer.
    Auto,
    /// A fixed number, less than the number of points.
    Count(u32),
    /// `ceil(c ln n)`.
    Log(f64),
}

impl Neighbours {
    /// Returns k for a number of points, or `None` if a fixed k is not positive or not less than that number.
    pub fn of(self, points: u64) -> Option<u32> {
        let most = points.saturating_sub(1).max(1);
        match self {
            Neighbours::Auto => Some(u64::from(FALLBACK_K).min(most) as u32),
            Neighbours::Count(k) => (k > 0 && u64::from(k) < points).then_some(k),
            Neighbours::Log(factor) => {
                Some(((factor * (points.max(2) as f64).ln()).ceil() as u64).clamp(1, most) as u32)
            }
        }
    }
}

impl fmt::Display for Neighbours {
    /// Writes the value as it is given on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Neighbours::Auto => f.write_str("auto"),
            Neighbours::Count(k) => k.fmt(f),
            Neighbours::Log(factor) => write!(f, "{factor}ln"),
        }
    }
}
