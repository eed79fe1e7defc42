//! Periodic boxes.

/// A periodic box whose faces are perpendicular to the axes.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Periodic {
    /// The length along each axis; `None` for an axis that is not periodic.
    pub lengths: Vec<Option<f64>>,
    /// The lower corner; empty for 0. Numbers of axes that are not periodic are not used.
    pub origin: Vec<f64>,
    /// Whether points outside of the box are admitted. They stand for their images in it.
    pub wrap: bool,
}

impl Periodic {
    /// Creates a box with these lengths, whose lower corner is 0.
    pub fn of_lengths(lengths: &[f64]) -> Self {
        Periodic::of(lengths.iter().map(|&length| Some(length)).collect())
    }

    /// Creates a box with these lengths, if the axes are periodic, whose lower corner is 0.
    pub fn of(lengths: Vec<Option<f64>>) -> Self {
        Periodic { lengths, ..Periodic::default() }
    }

    /// Returns the lower corner, if it was given.
    pub(crate) fn corner(&self) -> Option<Vec<Option<f64>>> {
        (!self.origin.is_empty()).then(|| self.origin.iter().map(|&number| Some(number)).collect())
    }
}
