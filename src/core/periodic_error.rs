//! Periodic boxes that cannot be used, and sites outside of them.

use thiserror::Error;

use crate::remedy::Remedy;

/// A periodic box that cannot be used, or a site outside of it.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PeriodicError {
    /// The box has another dimension than the points.
    #[error("numbers of the {what}: {given}, but the points have {dimension} coordinates")]
    Dimension {
        /// The box or its origin.
        what: &'static str,
        /// Number of numbers.
        given: usize,
        /// Number of coordinates.
        dimension: usize,
    },
    /// The points have a dimension above 3.
    #[error("periodic boxes exist in the plane and in space, but the points have dimension {dimension}")]
    Higher {
        /// Number of coordinates of a point.
        dimension: usize,
    },
    /// No axis is periodic.
    #[error("no axis of the box is periodic")]
    Open,
    /// The number of a length or of the origin is not admitted.
    #[error("{what} {value}: expected {expected}")]
    Number {
        /// The length of the box or its origin.
        what: &'static str,
        /// The number.
        value: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// A site lies outside of the box.
    #[error(
        "point {index}: coordinate {value} lies outside of the periodic box from {low} to {high} (rounded){}", and_others(*others)
    )]
    Outside {
        /// Position of the first such point.
        index: usize,
        /// Its coordinate.
        value: f64,
        /// Lower end of the box.
        low: f64,
        /// Upper end of the box, rounded.
        high: f64,
        /// Number of other such points.
        others: usize,
    },
    /// The whole number of lengths to a site is too large for exact arithmetic.
    #[error("point {index}: coordinate {value} is too many lengths of the box, {length}, away from the box")]
    Far {
        /// Position of the point.
        index: usize,
        /// Its coordinate.
        value: f64,
        /// The length of the box.
        length: f64,
    },
    /// The digits of the points and of the box spread too far for exact signs.
    #[error(
        "the coordinates, weights and the periodic box spread over {bits} binary digits, but exact signs are available up to \
         410"
    )]
    Spread {
        /// Number of binary digits from the lowest set bit to the highest.
        bits: i32,
    },
    /// There are more points than a periodic run can number.
    #[error("{points} points in a periodic box are too many: at most {most}")]
    Many {
        /// Number of points.
        points: usize,
        /// Largest number of points.
        most: usize,
    },
    /// The task has no periodic boxes.
    #[error("only `triangulate` and `simulate` take a periodic box, and not on a machine of the caller")]
    Task,
    /// An output of the run has no place for images of points.
    #[error("{output} has no place for images of points")]
    Output {
        /// The output.
        output: &'static str,
    },
}

/// Returns the end of a message that names one of several points.
fn and_others(others: usize) -> String {
    match others {
        0 => String::new(),
        1 => ", as another point does".to_owned(),
        _ => format!(", as {others} other points do"),
    }
}

impl PeriodicError {
    /// Returns `true` if a point of the input is the reason.
    pub fn is_of_point(&self) -> bool {
        matches!(self, Self::Outside { .. } | Self::Far { .. } | Self::Many { .. } | Self::Spread { .. })
    }

    /// Returns the position of the point that is the reason, to be replaced by its position in the input.
    pub fn point(&mut self) -> Option<&mut usize> {
        match self {
            Self::Outside { index, .. } | Self::Far { index, .. } => Some(index),
            _ => None,
        }
    }

    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        match self {
            Self::Outside { .. } => {
                Some(Remedy::of("correct it, give {origin}, or move such points into the box with {wrap}"))
            }
            Self::Far { .. } => Some(Remedy::plain("move the point near the box")),
            Self::Dimension { .. } => Some(Remedy::plain("give one number for each coordinate")),
            Self::Spread { .. } => {
                Some(Remedy::plain("round the coordinates to a common grid, or drop the points far away"))
            }
            Self::Open | Self::Number { .. } | Self::Many { .. } => None,
            Self::Higher { .. } | Self::Task => Some(Remedy::of("omit {periodic}")),
            Self::Output { .. } => Some(Remedy::of("omit it, or omit {periodic}")),
        }
    }
}
